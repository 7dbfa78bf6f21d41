"""Steps in the history of figures over commits, as `cvrbench history steps --format jsonl` tells
them.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

from tables import Cell, Table

MOST_STEPS = 200
SECONDS = 60


def objects_in(text: str) -> list[dict[str, Any]]:
    """All JSON objects of a text, on one line or several; what is behind broken text is left out."""
    decoder, found, at = json.JSONDecoder(), [], 0
    while (start := text.find("{", at)) >= 0:
        try:
            value, at = decoder.raw_decode(text, start)
        except ValueError:
            break
        if isinstance(value, dict):
            found.append(value)
    return found


def ask(program: str, store: Path) -> list[dict[str, Any]]:
    """Steps of all machines in a store. Exit code 1 says that a last step is a worse one. Raises
    OSError and SubprocessError.
    """
    done = subprocess.run(
        [program, "history", "steps", "--format", "jsonl", "--all-machines", "--store", str(store)],
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    if done.returncode not in (0, 1):
        raise subprocess.SubprocessError(done.stderr.strip())
    return objects_in(done.stdout)


def steps_table(steps: list[dict[str, Any]], machine: str) -> Table | None:
    """The last steps of one machine, newest first."""
    own = [step for step in steps if step.get("machine") == machine]
    if not own:
        return None
    own.sort(key=lambda step: str(step.get("time", "")), reverse=True)
    lines = []
    for step in own[:MOST_STEPS]:
        ratio = step.get("ratio")
        change = 100 * (ratio - 1) if isinstance(ratio, (int, float)) and ratio != 1 else None
        verdict = (
            "better"
            if not step.get("worse")
            else "worse"
            if step.get("last")
            else "worse, changed again since"
        )
        lines.append(
            [
                Cell(str(step.get("time", ""))),
                Cell(str(step.get("revision", ""))),
                Cell(str(step.get("previous", ""))),
                Cell(str(step.get("key", ""))),
                Cell(str(step.get("quantity", ""))),
                Cell(str(step.get("before", ""))),
                Cell(str(step.get("after", ""))),
                Cell("" if change is None else f"{change:+.1f}", change),
                Cell(verdict),
            ]
        )
    notes = [f"The last {MOST_STEPS} of {len(own)} steps."] if len(own) > MOST_STEPS else []
    return Table(
        "Steps in the history",
        [
            "time",
            "revision",
            "revision before",
            "cell",
            "quantity",
            "before",
            "after",
            "change %",
            "verdict",
        ],
        lines,
        2,
        notes,
    )
