"""Scaling with the number of threads."""

from __future__ import annotations

from figures.figure import Figure, Panel
from figures.scaling import DECODE, ENCODE, scaling_panels
from rows import Row


def threads(row: Row) -> float | None:
    return float(row.threads) if row.threads > 0 else None


def draw(rows: list[Row]) -> list[Panel]:
    return scaling_panels(
        rows, [ENCODE, DECODE], threads, "threads", lambda row: row.volume, {"threads"}
    )


FIGURE = Figure(
    "scaling-threads",
    "Scaling",
    "Scaling with threads",
    "Wall time, medians with 95 % intervals of the median (from minimum to maximum below six rounds). Both axes logarithmic.",
    "No cell was measured with two numbers of threads. `threads: [1, all]` in a block of a config does so.",
    draw,
)
