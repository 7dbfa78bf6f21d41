"""Rows of results folders: one JSON object a line, the outcome of one cell
(results/schema/row.schema.json).

Results are a folder, or a pack: a zip with the rows at its top. rows.jsonl may be compressed as
rows.jsonl.zst. A line that is torn or is no object is counted and left out. The last row of a cell counts; a cell
is what was measured, the machine that measured it and the device that drew it, so that nothing of
two machines is ever one row. Missing, null and infinite numbers read as None.
"""

from __future__ import annotations

import json
import math
import subprocess
import zipfile
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

OK = "ok"
ROWS = "rows.jsonl"


class Unreadable(Exception):
    """Results that are damaged, or are none."""


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
    """All rows that count, in the order of the folders and lines. `runs`: the last row of each cell
    of each folder, so that two folders may have one cell.
    """

    rows: list[Row]
    sources: list[Source]
    superseded: int = 0
    runs: list[Row] = field(default_factory=list)

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
    try:
        return float(value) if math.isfinite(value) else None
    except OverflowError:  # an integer beyond them
        return None


@contextmanager
def open_member(place: Path, name: str) -> Iterator[IO[bytes] | None]:
    """A file at the top of a results folder or of a pack; None where it has none of that name.
    Raises Unreadable for a damaged pack.
    """
    if place.is_dir():
        if not (place / name).is_file():
            yield None
            return
        with (place / name).open("rb") as file:
            yield file
        return
    try:
        with zipfile.ZipFile(place) as pack:
            if name not in pack.namelist():
                yield None
                return
            with pack.open(name) as file:
                yield file
    except (zipfile.BadZipFile, EOFError, NotImplementedError, RuntimeError) as error:
        raise Unreadable(f"{place}: no pack that can be read: {error}") from error


@contextmanager
def open_rows(place: Path) -> Iterator[IO[bytes] | None]:
    """The lines of rows.jsonl, or of rows.jsonl.zst by the program zstd, of a results folder or a
    pack; None where it has neither. Raises Unreadable where they are damaged, OSError where there
    is no zstd.
    """
    packed = place / (ROWS + ".zst")
    if (place / ROWS).is_file() or not packed.is_file():
        with open_member(place, ROWS) as lines:
            yield lines
        return
    try:
        process = subprocess.Popen(
            ["zstd", "-dcq", "--", packed], stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
    except FileNotFoundError as error:
        raise OSError(
            f"{packed}: expected the program zstd, found none: install the Debian package zstd"
        ) from error
    with process:
        assert process.stdout is not None and process.stderr is not None
        yield process.stdout
        told = process.stderr.read().decode(errors="replace").strip()
        if process.wait() != 0:
            raise Unreadable(f"{packed}: {told or 'zstd cannot decompress it'}")


def read_folder(folder: Path) -> tuple[list[Row], Source]:
    """Rows of a results folder or pack, all of them, and what could not be read. Raises as
    open_rows does.
    """
    source = Source(folder)
    rows = []
    with open_rows(folder) as lines:
        if lines is None:
            source.note = f"no {ROWS}"
            return [], source
        for number, line in enumerate(lines, 1):
            if not line.strip():
                continue
            try:
                data = json.loads(line.decode("utf-8", errors="replace"))
            except (ValueError, RecursionError):
                data = None
            if isinstance(data, dict):
                rows.append(Row(data, folder, number))
            else:
                source.unreadable.append(number)
    source.rows = len(rows)
    if not rows:
        source.note = f"{ROWS} holds no row"
    return rows, source


def load(folders: Iterable[Path]) -> Results:
    """The last row of each cell of all folders; of two folders the later time counts, and of equal
    times the later folder. Raises as open_rows does.
    """
    latest: dict[tuple[str, str, str], Row] = {}
    sources, runs, read = [], [], 0
    for folder in folders:
        rows, source = read_folder(folder)
        sources.append(source)
        read += len(rows)
        last = {row.identity: row for row in rows}
        runs += last.values()
        for identity, row in last.items():
            before = latest.get(identity)
            if before is None or row.text("provenance/time") >= before.text("provenance/time"):
                latest[identity] = row
    return Results(list(latest.values()), sources, read - len(latest), runs)


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
