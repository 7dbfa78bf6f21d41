"""Tables and figures of the rows of one machine, with links: what pages of data sets and codecs
share.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import estimates as e
import look
import tables
from figures.figure import Figure, groups
from pages.frame import Site
from panels import draw_figure
from rows import Row
from tables import Cell, Column, Table, number, plain, sized, stage, whole


def memory_mib(row: Row) -> Cell:
    found = row.number("memory/peak_over_input")
    return number(None if found is None else found / 2**20)


def access_column(points: str, lod: int) -> Column:
    return Column(
        f"{points} level {lod}, ns",
        stage("random-access"),
        lambda row: tables.timed(e.access_ns(row, points, lod)),
    )


MORE_COLUMNS = (
    Column("file bytes", sized, lambda row: whole(row.number("size/bytes"))),
    Column("rate as published %", sized, plain("size/published_rate")),
    Column("GPU bits/voxel", sized, plain("size/gpu_bits_per_voxel")),
    Column("mean squared error", sized, plain("error/mean_squared_error")),
    Column("edge PSNR dB", sized, plain("error/edge_psnr_db")),
    Column("encode MiB", stage("encode"), memory_mib),
    Column("decode MiB", stage("decode"), memory_mib),
    access_column("clustered", 0),
    access_column("one-label", 0),
)


def images_of(site: Site, rows: list[Row]) -> list[Table]:
    """Frames of one machine, a table for each device."""
    found = []
    drawn = [row for row in rows if row.ok and row.stage == "render"]
    for device, own in groups(drawn, lambda row: row.device).items():
        table = tables.image_cells(own, site.link, site.measured.label)
        assert table is not None
        kind = own[0].text("device/type")
        table.caption = f"Frames by {device or 'an unnamed device'}"
        table.caption += f", {kind} device" if kind else ""
        found.append(table)
    return found


def drawn_figure(site: Site, figure: Figure, rows: list[Row], prefix: str) -> dict[str, Any] | None:
    """Its panels with two points or more."""
    drawn = draw_figure(replace(figure, name=f"{figure.name}-{prefix}"), [("", "", rows)], None)
    panels = [panel for one in drawn["machines"] for panel in one["panels"] if panel["points"] > 1]
    return drawn | {"panels": panels} if panels else None


def cells_of(site: Site, rows: list[Row], caption: str, leave_out: int | None) -> Table | None:
    """Every metric; a column that is empty throughout is left out."""
    columns = (*tables.VOXEL_COLUMNS, *MORE_COLUMNS)
    found = tables.voxel_cells(rows, columns, site.link, site.measured.label)
    if found is None:
        return None
    found.caption = caption
    empty = [
        at for at in range(3, len(found.headings)) if not any(line[at].text for line in found.lines)
    ]
    for at in sorted([*empty, *([] if leave_out is None else [leave_out])], reverse=True):
        found = narrowed(found, at)
    return with_codec_links(site, found, 0) if leave_out == 0 else found


def with_codec_links(site: Site, table: Table, column: int) -> Table:
    for line in table.lines:
        page = site.codec_page(line[column].text.split(" ")[0])
        line[column].href = f"../{page}" if page else ""
    return table


def titled(figure: Figure, title: str) -> Figure:
    return replace(figure, title=title)


def in_order(rows: list[Row]) -> list[Row]:
    """By volume, then codecs and settings in a fixed order."""
    return sorted(rows, key=lambda row: (row.volume, look.row_order(row)))


def narrowed(table: Table, column: int) -> Table:
    """Without a column."""
    return replace(
        table,
        headings=table.headings[:column] + table.headings[column + 1 :],
        lines=[line[:column] + line[column + 1 :] for line in table.lines],
    )
