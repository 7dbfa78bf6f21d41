"""Rate against the speed of encoding and decoding."""

from __future__ import annotations

import look
from estimates import Estimate, rate, speed
from figures.figure import Figure, Panel, file_name, groups, of_stage
from figures.scatter import Point, draw_points, name_points, tell_apart
from rows import Row, codec_label, varying_parameters


def draw(rows: list[Row]) -> list[Panel]:
    panels = []
    usable = [row for row in of_stage(rows, "encode", "decode") if rate(row) and speed(row)]
    for (volume, stage, threads), found in groups(
        usable, lambda row: (row.volume, row.stage, row.threads)
    ).items():
        varying = varying_parameters(found)
        points = [
            Point(
                codec_label(row, varying),
                look.codec_colour(row.codec),
                look.codec_marker(row.codec),
                Estimate(rate(row) or 0),
                speed(row),
            )
            for row in found
        ]
        drawing, (axis,) = look.new_panel()
        tell_apart(points)
        draw_points(axis, points)
        axis.set_xlabel("file size, % of the original")
        axis.set_ylabel(f"{stage}, Mvoxel/s")
        axis.set_title(volume)
        name_points(axis, points)
        told = look.describe_points(
            [(p.label, p.x.value, p.y.value) for p in points if p.y],
            "rate %",
            "million voxels per second",
        )
        title = f"{volume}, {stage}, {threads} thread{'s' * (threads != 1)}"
        panels.append(
            Panel(file_name(f"{volume}-{stage}-{threads}t"), title, drawing, told, len(points))
        )
    return panels


FIGURE = Figure(
    "rate-speed",
    "Encoding and decoding",
    "Rate against encoding and decoding speed",
    "Wall time, medians with 95 % intervals of the median (from minimum to maximum below six rounds). Both axes logarithmic; upper left is better.",
    "No row of stage encode or decode that is ok. configs/quick.yaml has both.",
    draw,
)
