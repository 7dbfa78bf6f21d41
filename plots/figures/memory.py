"""GPU memory against frame time."""

from __future__ import annotations

import look
from estimates import Estimate, frame_ms, gpu_mib
from figures.figure import Figure, Panel, file_name, groups, of_stage, positive
from figures.imaged import mode_label, place, place_title, short_title, software_note, swept
from figures.scatter import Key, Point, draw_points, name_points
from rows import Row, varying_parameters

MOST_LABELS = 18


def draw(rows: list[Row]) -> list[Panel]:
    usable = [
        row
        for row in of_stage(rows, "render")
        if gpu_mib(row)
        and positive(frame_ms(row)[0])
        and not row.number("render/lod_bias")
        and (row.number("render/ao_samples") or 1) == 1
        and row.get("render/step") is None
    ]
    panels = []
    for (where, kind), found in groups(usable, lambda row: (place(row), frame_ms(row)[1])).items():
        varying, sweeps = varying_parameters(found), swept(found)
        points = [
            Point(
                mode_label(row, varying, sweeps),
                look.codec_colour(row.codec),
                look.cache_marker(row.text("render/cache")),
                Estimate(gpu_mib(row) or 0),
                frame_ms(row)[0],
                look.codec_fill(row.codec),
            )
            for row in found
        ]
        drawing, (axis,) = look.new_panel()
        draw_points(axis, points)
        axis.set_xlabel("device memory, MiB")
        axis.set_ylabel(f"ms per frame, {kind}")
        axis.set_title(short_title(where))
        name_points(axis, points, MOST_LABELS, keys_of(found))
        told = look.describe_points(
            [(p.label, p.x.value, p.y.value) for p in points if p.y], "MiB", "ms"
        )
        panels.append(
            Panel(
                file_name(" ".join(where[:4]) + f" {kind}"),
                f"{place_title(where)}; {kind}",
                drawing,
                told,
                len(points),
                software_note(found),
            )
        )
    return panels


def keys_of(rows: list[Row]) -> list[Key]:
    """Codecs by colour and fill, then access modes by marker."""
    codecs = [
        Key(codec, look.codec_colour(codec), "o", look.codec_fill(codec))
        for codec in dict.fromkeys(row.codec for row in rows)
    ]
    modes = [
        Key(mode, look.GREY, look.cache_marker(mode))
        for mode in dict.fromkeys(row.text("render/cache") for row in rows)
    ]
    return codecs + modes


FIGURE = Figure(
    "memory",
    "Frames",
    "Device memory against frame time",
    "All buffers of the device, caches included, against the device time of a frame (held: one view, the cache filled; path: from an empty cache). The "
    "colour is the codec's, the marker the access mode's. Times with the interval of the median of their repetitions (95 % from six on, none below three). "
    "Lower left is better.",
    "No row of stage render that is ok. configs/fixed_view.yaml has them; configs/quick.yaml has a few.",
    draw,
)
