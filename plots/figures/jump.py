"""The first frames after a camera jump."""

from __future__ import annotations

import look
from estimates import Estimate
from figures.figure import Figure, Panel, file_name, groups, of_stage
from figures.imaged import mode_label, place, place_title, short_title, software_note, swept
from figures.scatter import Curve, draw_curves, legend_below
from rows import Row, finite, varying_parameters


def draw(rows: list[Row]) -> list[Panel]:
    usable = [
        row
        for row in of_stage(rows, "render")
        if row.objects("jump/frames") and not row.number("render/lod_bias")
    ]
    return [panel(where, found) for where, found in groups(usable, place).items()]


def panel(where: tuple[str, str, str, str, str], found: list[Row]) -> Panel:
    varying, sweeps = varying_parameters(found), swept(found)
    errors, times = [], []
    told, pixels = [], 0.0
    for number, row in enumerate(found):
        frames = row.objects("jump/frames")
        pixels = max(pixels, row.number("jump/pixels") or 0)
        colour, marker = look.codec_colour(row.codec), look.cache_marker(row.text("render/cache"))
        fill = look.codec_fill(row.codec)
        label, line = mode_label(row, varying, sweeps), look.LINES[number % len(look.LINES)]
        wrong = [finite(frame.get("label_mismatches")) for frame in frames]
        ms = [finite(frame.get("ms")) for frame in frames]
        errors.append(
            Curve(
                label,
                colour,
                marker,
                line,
                [(Estimate(i), Estimate(w)) for i, w in enumerate(wrong) if w is not None],
                fill,
            )
        )
        times.append(
            Curve(
                label,
                colour,
                marker,
                line,
                [(Estimate(i), Estimate(t)) for i, t in enumerate(ms) if t is not None],
                fill,
            )
        )
        psnr = finite(frames[0].get("psnr_db"))
        told.append(
            f"{label}: first frame {'exact' if psnr is None else f'{psnr:.1f} dB'}, {wrong[0] or 0:.0f} wrong pixels"
        )
    drawing, (upper, lower) = look.new_panel(2.9, 2)
    draw_curves(upper, [c for c in errors if c.points])
    upper.set_yscale("symlog", linthresh=1)
    upper.yaxis.set_major_formatter("{x:g}")
    upper.set_ylim(bottom=-0.3)
    upper.set_ylabel("wrong pixels")
    draw_curves(lower, [c for c in times if c.points])
    look.log_axis(lower, "y")
    lower.set_ylabel("ms per frame")
    lower.set_xlabel("frame after the jump")
    lower.xaxis.get_major_locator().set_params(integer=True)
    upper.set_title(short_title(where))
    legend_below(lower)
    note = f"Of {pixels:.0f} pixels. " + software_note(found)
    return Panel(
        file_name(" ".join(where[:4])),
        place_title(where),
        drawing,
        "; ".join(told),
        len(found),
        note,
    )


FIGURE = Figure(
    "jump",
    "Frames",
    "First frames after a camera jump",
    "Above: pixels with a wrong label, 0 where the image is exact (the axis is linear up to 1, then logarithmic). Below: device time, one measurement "
    "a frame, so no interval. Modes that show placeholders have wrong pixels at first; those that decode on demand pay in time.",
    "No row of stage render with jump_frames. configs/paper/fig8.yaml has them.",
    draw,
)
