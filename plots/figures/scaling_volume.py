"""Scaling with the size of a volume."""

from __future__ import annotations

from figures.figure import Figure, Panel
from figures.scaling import ACCESS, DECODE, ENCODE, FRAME, RATE, scaling_panels
from rows import Row


def voxels(row: Row) -> float | None:
    return row.number("dataset/voxels")


def draw(rows: list[Row]) -> list[Panel]:
    return scaling_panels(
        rows,
        [RATE, ENCODE, DECODE, ACCESS, FRAME],
        voxels,
        "voxels",
        lambda row: row.text("dataset/title", row.dataset),
        set(),
    )


FIGURE = Figure(
    "scaling-volume",
    "Scaling",
    "Scaling with volume size",
    "Volumes of one description and several extents. Times are medians with 95 % intervals of the median (from minimum to maximum below six "
    "repetitions). Both axes logarithmic.",
    "No data set was measured in two extents. configs/paper/tvq_fig9.yaml does so; a config may list a data set with several values of scale.",
    draw,
)
