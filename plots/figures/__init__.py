"""The figures of the report: one file a figure, in the order of the page.

A figure is a module with `FIGURE`, a `Figure` of its own. To add one: write the file, add it to the
list below.
"""

from __future__ import annotations

from figures import (
    frame_error,
    jump,
    memory,
    rate_access,
    rate_distortion,
    rate_speed,
    rates,
    scaling_brick,
    scaling_threads,
    scaling_volume,
)
from figures.figure import Figure

REGISTRY: list[Figure] = [
    module.FIGURE
    for module in (
        rates,
        rate_access,
        rate_speed,
        rate_distortion,
        frame_error,
        jump,
        memory,
        scaling_brick,
        scaling_volume,
        scaling_threads,
    )
]
