"""Rate against the time of one voxel at random."""

from __future__ import annotations

import look
from estimates import Estimate, access_ns, is_exact, rate
from figures.figure import Figure, Panel, file_name, groups, of_stage, positive
from figures.scatter import Point, draw_points, name_points, tell_apart
from rows import Row, codec_label, varying_parameters


def draw(rows: list[Row]) -> list[Panel]:
    panels = []
    by_volume = groups(
        (r for r in of_stage(rows, "random-access") if rate(r) and positive(access_ns(r))),
        lambda row: (row.volume, row.threads),
    )
    for (volume, threads), found in by_volume.items():
        varying = varying_parameters(found)
        points = []
        for row in found:
            time, percent = access_ns(row), rate(row)
            if time is not None and percent is not None:
                points.append(
                    Point(
                        codec_label(row, varying),
                        look.codec_colour(row.codec),
                        look.codec_marker(row.codec),
                        Estimate(percent),
                        time,
                    )
                )
        drawing, (axis,) = look.new_panel()
        tell_apart(points)
        draw_points(axis, points)
        axis.set_xlabel("file size, % of the original")
        axis.set_ylabel("one voxel at random, ns")
        axis.set_title(volume)
        name_points(axis, points)
        told = look.describe_points(
            [(p.label, p.x.value, p.y.value) for p in points if p.y], "rate %", "ns"
        )
        lossy = (
            ""
            if all(map(is_exact, found))
            else "Lossy codecs: their error is in the figure of rate and distortion."
        )
        panels.append(
            Panel(
                file_name(f"{volume}-{threads}t"),
                f"{volume}, {threads} thread{'s' * (threads != 1)}",
                drawing,
                told,
                len(points),
                lossy,
            )
        )
    return panels


FIGURE = Figure(
    "rate-access",
    "Random access",
    "Rate against random-access time",
    "Uniform points, finest level; medians with 95 % intervals of the median (from minimum to maximum below six rounds). Both axes logarithmic; "
    "lower left is better. raw is a plain array. Codecs without access to single voxels are absent.",
    "No row of stage random-access that is ok. configs/quick.yaml has that stage.",
    draw,
)
