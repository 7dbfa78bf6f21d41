"""Rate of every lossless codec by data set."""

from __future__ import annotations

import look
from estimates import is_exact, rate
from figures.figure import Figure, Panel, groups, of_stage
from figures.scatter import legend_below
from rows import Row

MOST_VOLUMES = 12  # of a panel


def draw(rows: list[Row]) -> list[Panel]:
    usable = [
        row
        for row in of_stage(rows, "encode", "decode", "random-access")
        if is_exact(row) and rate(row) and row.get("dataset/kind") == "labels"
    ]
    by_volume = groups(usable, lambda row: row.volume)
    names = list(by_volume)
    parts = [names[at : at + MOST_VOLUMES] for at in range(0, len(names), MOST_VOLUMES)]
    return [panel(part, by_volume, number, len(parts)) for number, part in enumerate(parts, 1)]


def panel(volumes: list[str], by_volume: dict[str, list[Row]], number: int, of: int) -> Panel:
    drawing, (axis,) = look.new_panel(0.75 + 0.2 * len(volumes))
    seen: set[str] = set()
    told = []
    for height, volume in enumerate(volumes):
        best = {
            codec: min(filter(None, map(rate, rows)))
            for codec, rows in groups(by_volume[volume], lambda row: row.codec).items()
        }
        for codec, percent in best.items():
            axis.plot([percent], [height], look.codec_marker(codec), color=look.codec_colour(codec))
            seen.add(codec)
        told.append(
            f"{volume}: "
            + ", ".join(
                f"{codec} {percent:.3g} %"
                for codec, percent in sorted(best.items(), key=lambda one: one[1])
            )
        )
    for codec in sorted(seen, key=look.codec_order):
        axis.plot([], [], look.codec_marker(codec), color=look.codec_colour(codec), label=codec)
    axis.set_yticks(range(len(volumes)), [volume.split(", ")[0] for volume in volumes])
    axis.set_ylim(len(volumes) - 0.5, -0.5)
    look.log_axis(axis, "x")
    axis.set_xlabel("file size, % of the original")
    legend_below(axis)
    title = "Rate by data set" + (f", {number} of {of}" if of > 1 else "")
    return Panel(f"{number}" if of > 1 else "all", title, drawing, "; ".join(told), len(told))


FIGURE = Figure(
    "rates",
    "Size",
    "Rate of lossless codecs",
    "Bytes of the whole file over bytes of the original in its stored type, logarithmic; of several parameters of a codec the smallest. "
    "Exact figures: no interval. Left is better.",
    "No row of a lossless codec on labels that is ok. configs/quick.yaml has them.",
    draw,
)
