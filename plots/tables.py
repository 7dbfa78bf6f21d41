"""Tables of the page: those that configurations made (DIR/tables), and all cells measured."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import estimates as e
from estimates import Estimate, spell
from rows import Row, codec_label, finite, varying_parameters


@dataclass
class Cell:
    """`sort`: what it is ordered by, its number or its text; `detail` stands below the text in
    small type.
    """

    text: str
    sort: float | None = None
    detail: str = ""

    @property
    def numeric(self) -> bool:
        return self.sort is not None


@dataclass
class Table:
    """`labels`: leading columns that label a line; the first of them heads its row."""

    caption: str
    headings: list[str]
    lines: list[list[Cell]]
    labels: int = 1
    notes: list[str] = field(default_factory=list)
    source: str = ""

    def numeric(self, column: int) -> bool:
        """Whether most of a column's cells that are not empty are numbers."""
        filled = [line[column] for line in self.lines if line[column].text]
        return bool(filled) and 2 * sum(cell.numeric for cell in filled) > len(filled)


def texts(value: Any) -> list[str]:
    """The texts of a list of texts. Raises TypeError for anything else."""
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise TypeError(f"expected a list of texts, found {type(value).__name__}")
    return value


def read_line(cells: list[dict[str, Any]], width: int, labels: int) -> list[Cell]:
    if len(cells) != width:
        raise ValueError(f"expected lines of {width} cells, found one of {len(cells)}")
    return [
        Cell(cell["text"], finite(cell.get("number")) if at >= labels else None)
        for at, cell in enumerate(cells)
    ]


def read_table(path: Path) -> Table | None:
    """A table of DIR/tables (results/schema/table.schema.json), or one that says why it cannot be
    read. None for a table without lines.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8", errors="replace"))
        headings = texts([column["heading"] for column in data["columns"]])
        labels = int(data["labels"])
        lines = [read_line(line["cells"], len(headings), labels) for line in data["lines"]]
        texts([cell.text for line in lines for cell in line])
        table = Table(
            data["title"], headings, lines, max(1, labels), texts(data["notes"]), str(path)
        )
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        reason = f"no table: {type(error).__name__}: {error}"
        return Table(
            path.stem,
            ["table", "why it is not shown"],
            [[Cell(path.stem), Cell(reason)]],
            2,
            [],
            str(path),
        )
    return table if table.lines else None


def config_tables(folder: Path) -> list[Table]:
    """Tables of a results folder, by name."""
    found = (read_table(path) for path in sorted((folder / "tables").glob("*.json")))
    return [table for table in found if table is not None]


def timed(found: Estimate | None) -> Cell:
    if found is None:
        return Cell("")
    interval = f"[{spell(found.low)}, {spell(found.high)}]" if found.low is not None else ""
    count = f"n = {found.n}" if found.n else ""
    return Cell(spell(found.value), found.value, " ".join(filter(None, (interval, count))))


def number(value: float | None, digits: int = 4) -> Cell:
    return Cell(spell(value, digits), value) if value is not None else Cell("")


def psnr(row: Row, path: str, exact: bool) -> Cell:
    """Exact figures are above all others."""
    value = row.number(path)
    if value is not None:
        return Cell(f"{value:.2f}", value)
    return Cell("exact", 1e9) if exact else Cell("")


def voxel_cells(rows: list[Row]) -> Table | None:
    """A line for each volume, codec, parameters and threads; what encoding, decoding and random
    access found of it.
    """
    joined: dict[tuple, dict[str, Row]] = {}
    for row in rows:
        if row.ok and row.stage in ("encode", "decode", "random-access"):
            key = (row.volume, row.codec, tuple(sorted(row.parameters.items())), row.threads)
            joined.setdefault(key, {})[row.stage] = row
    if not joined:
        return None
    varying = varying_parameters(row for stages in joined.values() for row in stages.values())
    lines = []
    for stages in joined.values():
        row = next(iter(stages.values()))
        size = next((r for r in stages.values() if e.rate(r) is not None), row)
        wrong = max(
            (
                r.number("verification/mismatches")
                for r in stages.values()
                if r.number("verification/mismatches") is not None
            ),
            default=None,
        )
        compared = max(
            (r.number("verification/voxels_compared") or 0 for r in stages.values()), default=0
        )
        encode, decode, access = (
            stages.get(stage) for stage in ("encode", "decode", "random-access")
        )
        lines.append(
            [
                Cell(row.volume),
                Cell(codec_label(row, varying)),
                Cell(str(row.threads), row.threads),
                number(e.rate(size)),
                number(e.bits_per_voxel(size)),
                timed(e.speed(encode) if encode else None),
                timed(e.speed(decode) if decode else None),
                timed(e.access_ns(access) if access else None),
                Cell(
                    "" if wrong is None or not compared else f"{wrong:,.0f}",
                    wrong if compared else None,
                    f"of {compared:,.0f}" if compared else "",
                ),
                psnr(size, "error/psnr_db", e.is_exact(size)),
                number(size.number("error/largest_error")),
            ]
        )
    headings = [
        "volume",
        "codec",
        "threads",
        "file rate %",
        "bits/voxel",
        "encode Mvoxel/s",
        "decode Mvoxel/s",
        "access ns",
        "voxels that differ",
        "PSNR dB",
        "largest error",
    ]
    return Table(
        "Every volume and codec measured",
        headings,
        lines,
        2,
        [
            "Times: medians of wall time, below each the 95 % interval of the median (minimum and maximum where n < 6, none where n < 3) and the rounds n.",
            "Sizes and errors are exact figures.",
        ],
    )


def image_cells(rows: list[Row]) -> Table | None:
    """A line for each cell of the stage render."""
    drawn = [row for row in rows if row.ok and row.stage == "render"]
    if not drawn:
        return None
    varying = varying_parameters(drawn)
    lines = []
    for row in drawn:
        jump = row.objects("jump/frames")
        lines.append(
            [
                Cell(row.volume),
                Cell(codec_label(row, varying)),
                Cell(row.text("render/cache")),
                Cell(row.text("render/scene")),
                Cell(row.text("render/shading")),
                Cell(settings_text(row)),
                timed(e.path_ms(row)),
                timed(e.first_frame_ms(row)),
                timed(e.warm_ms(row)),
                number(row.number("exact_after_frames")),
                number(row.number("verification/label_mismatches")),
                psnr(row, "picture_error/psnr_db", isinstance(row.get("picture_error"), dict)),
                psnr(Row(jump[0], row.folder, row.line), "psnr_db", True) if jump else Cell(""),
                number(e.gpu_mib(row)),
            ]
        )
    headings = [
        "volume",
        "codec",
        "access mode",
        "scene",
        "shading",
        "settings",
        "path ms",
        "first frame ms",
        "warm ms",
        "converged after frames",
        "wrong pixels",
        "image PSNR dB",
        "PSNR dB after a jump",
        "device MiB",
    ]
    return Table(
        "Every image measured",
        headings,
        lines,
        3,
        [
            "Times: device time of a frame, below each the interval of the median of its repetitions (rounds; of the fixed view frames) and their number n.",
            "Image PSNR: with this cell's levels and samples; after a jump: of the first frame.",
        ],
    )


def settings_text(row: Row) -> str:
    size = row.get("render/size", [])
    parts = ["x".join(map(str, size)) if isinstance(size, list) else ""]
    for name, usual in (("cache_mib", 0), ("lod_bias", 0), ("ao_samples", 1), ("step", None)):
        value = row.get(f"render/{name}")
        if value is not None and value != usual:
            parts.append(
                f"{name}={value:g}" if isinstance(value, (int, float)) else f"{name}={value}"
            )
    return ", ".join(filter(None, parts))


def failures(rows: list[Row]) -> Table | None:
    """Cells that are not ok, counted by status, stage and reason."""
    counted: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        if not row.ok:
            counted.setdefault(
                (row.text("status", "unknown"), row.stage, row.text("reason", "no reason given")),
                [],
            ).append(row)
    if not counted:
        return None
    lines = []
    for (status, stage, reason), found in sorted(
        counted.items(), key=lambda one: (one[0][0] == "unsupported", one[0])
    ):
        lines.append(
            [
                Cell(status),
                Cell(stage),
                Cell(reason),
                Cell(str(len(found)), len(found)),
                Cell(names(row.codec for row in found)),
                Cell(names(row.dataset for row in found)),
                Cell(names(row.text("render/cache") for row in found)),
            ]
        )
    return Table(
        "Cells without a result, by status and reason",
        ["status", "stage", "reason", "cells", "codecs", "data sets", "access modes"],
        lines,
        2,
    )


def names(values) -> str:
    """Distinct names in their order; an empty one is left out."""
    return ", ".join(dict.fromkeys(value for value in values if value))
