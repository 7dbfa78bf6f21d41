"""Scaling with the edge of a brick."""

from __future__ import annotations

from figures.figure import Figure, Panel
from figures.rate_distortion import is_number
from figures.scaling import ACCESS, DECODE, ENCODE, FRAME, RATE, scaling_panels
from rows import Row


def brick(row: Row) -> float | None:
    text = row.parameters.get("brick", "")
    return float(text) if is_number(text) else None


def draw(rows: list[Row]) -> list[Panel]:
    return scaling_panels(
        rows,
        [RATE, ENCODE, DECODE, ACCESS, FRAME],
        brick,
        "brick edge, voxels",
        lambda row: row.volume,
        {"brick"},
    )


FIGURE = Figure(
    "scaling-brick",
    "Scaling",
    "Scaling with brick size",
    "Rates are exact; times are medians with 95 % intervals of the median (from minimum to maximum below six repetitions). Both axes logarithmic.",
    "No codec was measured with two sizes of bricks. configs/paper/table2.yaml and configs/paper/table_s1.yaml do so.",
    draw,
)
