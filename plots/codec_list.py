"""The codecs that the program knows, in the order of its list: what `cvrbench list codecs --json`
prints, and a run leaves as DIR/codecs.json.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rows import open_member

SECONDS = 60


@dataclass(frozen=True)
class Codec:
    """`entry`: all that the list says of it."""

    id: str
    family: str
    entry: dict[str, Any] = field(default_factory=dict, compare=False)

    def text(self, name: str) -> str:
        value = self.entry.get(name)
        return value if isinstance(value, str) else ""

    @property
    def parameters(self) -> list[dict[str, str]]:
        """Name, type, default, range and description of each, as texts."""
        found = self.entry.get("parameters")
        return [
            {key: str(value) for key, value in one.items()}
            for one in (found if isinstance(found, list) else [])
            if isinstance(one, dict)
        ]


def codecs_in(text: str) -> list[Codec]:
    """Codecs of a list; nothing of what is none."""
    try:
        entries: Any = json.loads(text)
    except (ValueError, RecursionError):
        return []
    found = (
        [entry for entry in entries if isinstance(entry, dict) and isinstance(entry.get("id"), str)]
        if isinstance(entries, list)
        else []
    )
    return [Codec(entry["id"], str(entry.get("family") or entry["id"]), entry) for entry in found]


def read_codecs(folder: Path) -> list[Codec]:
    """Of a results folder or pack."""
    with open_member(folder, "codecs.json") as file:
        return codecs_in(file.read().decode("utf-8", errors="replace")) if file else []


def ask(program: str) -> list[Codec]:
    """Codecs of a program; none where it does not answer."""
    try:
        done = subprocess.run(
            [program, "list", "codecs", "--json"],
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return []
    return codecs_in(done.stdout)


def listed(folders: Sequence[Path], program: str = "") -> list[Codec]:
    """Codecs of the lists of all folders, each once, in the order of the first list; of the program
    where no folder has one.
    """
    found: dict[str, Codec] = {}
    for folder in folders:
        for codec in read_codecs(folder):
            found.setdefault(codec.id, codec)
    return list(found.values()) or (ask(program) if program else [])
