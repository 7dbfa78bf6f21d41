"""Tables of the page: those that configurations made (DIR/tables), and all cells measured."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import estimates as e
from estimates import Estimate, spell
from rows import Row, codec_label, finite, varying_parameters


@dataclass
class Cell:
    """`sort`: what it is ordered by, its number or its text; `detail` stands below the text in
    small type; `href`: where its text leads.
    """

    text: str
    sort: float | None = None
    detail: str = ""
    href: str = ""

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

    def numeric_columns(self) -> list[bool]:
        """Of each column whether most of its cells that are not empty are numbers."""
        filled = [
            [line[column] for line in self.lines if line[column].text]
            for column in range(len(self.headings))
        ]
        return [
            bool(cells) and 2 * sum(cell.numeric for cell in cells) > len(cells) for cells in filled
        ]


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


def whole(value: float | None) -> Cell:
    return Cell(f"{value:,.0f}", value) if value is not None else Cell("")


def psnr(row: Row, path: str, exact: bool) -> Cell:
    """Exact figures are above all others."""
    value = row.number(path)
    if value is not None:
        return Cell(f"{value:.2f}", value)
    return Cell("exact", 1e9) if exact else Cell("")


Stages = dict[str, Row]  # what the stages found of one volume, codec, setting and thread count
Link = Callable[[Row], str]


def no_link(row: Row) -> str:
    return ""


@dataclass(frozen=True)
class Column:
    """`pick`: the row of which it is read."""

    heading: str
    pick: Callable[[Stages], Row | None]
    read: Callable[[Row], Cell]

    def cell(self, stages: Stages, link: Link) -> Cell:
        row = self.pick(stages)
        cell = self.read(row) if row is not None else Cell("")
        if row is not None and cell.text:
            cell.href = link(row)
        return cell


def stage(name: str) -> Callable[[Stages], Row | None]:
    return lambda stages: stages.get(name)


def sized(stages: Stages) -> Row:
    """A row that states a size."""
    rows = list(stages.values())
    return next((row for row in rows if e.rate(row) is not None), rows[0])


def most_wrong(stages: Stages) -> Row:
    """The row with the most voxels that differ."""
    return max(
        stages.values(),
        key=lambda row: (
            row.number("verification/mismatches") or 0,
            row.number("verification/voxels_compared") or 0,
        ),
    )


def mismatches(row: Row) -> Cell:
    wrong, of = row.number("verification/mismatches"), row.number("verification/voxels_compared")
    return Cell(f"{wrong:,.0f}", wrong, f"of {of:,.0f}") if wrong is not None and of else Cell("")


def plain(path: str, digits: int = 4) -> Callable[[Row], Cell]:
    return lambda row: number(row.number(path), digits)


VOXEL_COLUMNS = (
    Column("file rate %", sized, lambda row: number(e.rate(row))),
    Column("bits/voxel", sized, lambda row: number(e.bits_per_voxel(row))),
    Column("encode Mvoxel/s", stage("encode"), lambda row: timed(e.speed(row))),
    Column("decode Mvoxel/s", stage("decode"), lambda row: timed(e.speed(row))),
    Column("access ns", stage("random-access"), lambda row: timed(e.access_ns(row))),
    Column("voxels that differ", most_wrong, mismatches),
    Column("PSNR dB", sized, lambda row: psnr(row, "error/psnr_db", e.is_exact(row))),
    Column("largest error", sized, plain("error/largest_error")),
)


def joined_stages(rows: Iterable[Row]) -> list[Stages]:
    """Of each volume, codec, parameters and threads the rows of the stages that know no images."""
    joined: dict[tuple, Stages] = {}
    for row in rows:
        if row.ok and row.stage in ("encode", "decode", "random-access"):
            key = (row.volume, row.codec, tuple(sorted(row.parameters.items())), row.threads)
            joined.setdefault(key, {})[row.stage] = row
    return list(joined.values())


def voxel_cells(
    rows: list[Row],
    columns: Sequence[Column] = VOXEL_COLUMNS,
    link: Link = no_link,
    label: Callable[[Row], str] | None = None,
) -> Table | None:
    """A line for each volume, codec, parameters and threads; what encoding, decoding and random
    access found of it.
    """
    joined = joined_stages(rows)
    if not joined:
        return None
    varying = varying_parameters(row for stages in joined for row in stages.values())
    named = label or (lambda row: codec_label(row, varying))
    lines = []
    for stages in joined:
        row = next(iter(stages.values()))
        lines.append(
            [Cell(row.volume), Cell(named(row)), Cell(str(row.threads), row.threads)]
            + [column.cell(stages, link) for column in columns]
        )
    return Table(
        "Every volume and codec measured",
        ["volume", "codec", "threads", *(column.heading for column in columns)],
        lines,
        2,
        [
            "Times: medians of wall time, below each the 95 % interval of the median (minimum and maximum where n < 6, none where n < 3) and the rounds n.",
            "Sizes and errors are exact figures.",
        ],
    )


def jump_psnr(row: Row) -> Cell:
    jump = row.objects("jump/frames")
    return psnr(Row(jump[0], row.folder, row.line), "psnr_db", True) if jump else Cell("")


IMAGE_COLUMNS: tuple[tuple[str, Callable[[Row], Cell]], ...] = (
    ("path ms", lambda row: timed(e.path_ms(row))),
    ("first frame ms", lambda row: timed(e.first_frame_ms(row))),
    ("warm ms", lambda row: timed(e.warm_ms(row))),
    ("converged after frames", lambda row: whole(row.number("exact_after_frames"))),
    ("wrong pixels", lambda row: whole(row.number("verification/label_mismatches"))),
    (
        "image PSNR dB",
        lambda row: psnr(row, "picture_error/psnr_db", isinstance(row.get("picture_error"), dict)),
    ),
    ("PSNR dB after a jump", jump_psnr),
    ("device MiB", lambda row: number(e.gpu_mib(row))),
)


def image_cells(
    rows: list[Row], link: Link = no_link, label: Callable[[Row], str] | None = None
) -> Table | None:
    """A line for each cell of the stage render."""
    drawn = [row for row in rows if row.ok and row.stage == "render"]
    if not drawn:
        return None
    varying = varying_parameters(drawn)
    named = label or (lambda row: codec_label(row, varying))
    lines = []
    for row in drawn:
        line = [
            Cell(row.volume),
            Cell(named(row)),
            Cell(row.text("render/cache")),
            Cell(row.text("render/scene")),
            Cell(row.text("render/shading")),
            Cell(settings_text(row)),
        ]
        columns = [Column(name, lambda stages: row, read) for name, read in IMAGE_COLUMNS]
        lines.append(line + [column.cell({}, link) for column in columns])
    return Table(
        "Every image measured",
        ["volume", "codec", "access mode", "scene", "shading", "settings"]
        + [name for name, _ in IMAGE_COLUMNS],
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
    for name, usual in (
        ("cache_mib", 0),
        ("lod_bias", 0),
        ("ao_samples", 1),
        ("ao_roulette", False),
        ("step", None),
    ):
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
