"""Rows of results folders: one JSON object a line, the outcome of one cell
(results/schema/row.schema.json).

A line that is torn or is no object is counted and left out. The last row of a cell counts; a cell
is what was measured, the machine that measured it and the device that drew it, so that nothing of
two machines is ever one row. Missing, null and infinite numbers read as None.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

OK = "ok"


@dataclass(frozen=True)
class Row:
    """One cell's outcome."""

    data: dict[str, Any]
    folder: Path
    line: int

    def get(self, path: str, default: Any = None) -> Any:
        """The value at "a/b/c", or `default` where any part is missing or null."""
        value: Any = self.data
        for part in path.split("/"):
            if not isinstance(value, dict):
                return default
            value = value.get(part)
        return default if value is None else value

    def number(self, path: str) -> float | None:
        """The finite number at a path."""
        return finite(self.get(path))

    def text(self, path: str, default: str = "") -> str:
        value = self.get(path)
        return value if isinstance(value, str) else default

    def objects(self, path: str) -> list[dict[str, Any]]:
        """The objects of the array at a path."""
        value = self.get(path)
        return [one for one in value if isinstance(one, dict)] if isinstance(value, list) else []

    @property
    def ok(self) -> bool:
        return self.text("status") == OK

    @property
    def stage(self) -> str:
        return self.text("stage", "unknown")

    @property
    def codec(self) -> str:
        return self.text("codec/id", "unknown")

    @property
    def dataset(self) -> str:
        return self.text("dataset/name", "unknown")

    @property
    def machine(self) -> str:
        return self.text("provenance/machine", "unknown")

    @property
    def device(self) -> str:
        return self.text("device/name")

    @property
    def threads(self) -> int:
        return int(self.number("threads") or 0)

    @property
    def extent(self) -> str:
        """ "X x Y x Z", or nothing where it is not known."""
        axes = self.get("dataset/extent", [])
        return " x ".join(str(a) for a in axes) if isinstance(axes, list) else ""

    @property
    def volume(self) -> str:
        """Data set and extent: two extents of a data set are two volumes."""
        return f"{self.dataset}, {self.extent}" if self.extent else self.dataset

    @property
    def parameters(self) -> dict[str, str]:
        found = self.get("codec/parameters", {})
        return {str(k): str(v) for k, v in found.items()} if isinstance(found, dict) else {}

    @property
    def identity(self) -> tuple[str, str, str]:
        cell = self.text("cell") or self.text("key") or f"{self.folder}:{self.line}"
        return self.machine, self.device, cell


@dataclass
class Source:
    """What was read of one results folder."""

    folder: Path
    rows: int = 0
    unreadable: list[int] = field(default_factory=list)
    note: str = ""


@dataclass
class Results:
    """All rows that count, in the order of the folders and lines."""

    rows: list[Row]
    sources: list[Source]
    superseded: int = 0

    @property
    def machines(self) -> list[str]:
        """Fingerprints, those with the most rows first."""
        counts = Counter(row.machine for row in self.rows)
        return sorted(counts, key=lambda machine: (-counts[machine], machine))

    def of(self, machine: str) -> list[Row]:
        return [row for row in self.rows if row.machine == machine]


def finite(value: Any) -> float | None:
    """A finite number as a float; None for anything else."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if math.isfinite(value) else None


def read_folder(folder: Path) -> tuple[list[Row], Source]:
    """Rows of FOLDER/rows.jsonl, all of them, and what could not be read."""
    source = Source(folder)
    path = folder / "rows.jsonl"
    if not path.is_file():
        source.note = "no rows.jsonl"
        return [], source
    rows = []
    with path.open(encoding="utf-8", errors="replace") as lines:
        for number, line in enumerate(lines, 1):
            if not line.strip():
                continue
            try:
                data = json.loads(line)
            except (ValueError, RecursionError):
                data = None
            if isinstance(data, dict):
                rows.append(Row(data, folder, number))
            else:
                source.unreadable.append(number)
    source.rows = len(rows)
    if not rows:
        source.note = "rows.jsonl holds no row"
    return rows, source


def load(folders: Iterable[Path]) -> Results:
    """The last row of each cell of all folders; of two folders the later time counts, and of equal
    times the later folder.
    """
    latest: dict[tuple[str, str, str], Row] = {}
    sources, read = [], 0
    for folder in folders:
        rows, source = read_folder(folder)
        sources.append(source)
        read += len(rows)
        for row in rows:
            before = latest.get(row.identity)
            newer = (
                before is None
                or before.folder == row.folder
                or row.text("provenance/time") >= before.text("provenance/time")
            )
            if newer:
                latest[row.identity] = row
    return Results(list(latest.values()), sources, read - len(latest))


def varying_parameters(rows: Iterable[Row]) -> dict[str, set[str]]:
    """For each codec the parameters that take several values in these rows."""
    values: dict[str, dict[str, set[str]]] = {}
    for row in rows:
        for name, value in row.parameters.items():
            values.setdefault(row.codec, {}).setdefault(name, set()).add(value)
    return {
        codec: {name for name, seen in names.items() if len(seen) > 1}
        for codec, names in values.items()
    }


def codec_label(row: Row, varying: dict[str, set[str]]) -> str:
    """The codec, and those of its parameters that tell it from others."""
    names = sorted(varying.get(row.codec, set()) & row.parameters.keys())
    return " ".join([row.codec] + [f"{name}={row.parameters[name]}" for name in names])
