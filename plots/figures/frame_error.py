"""Frame time against image error."""

from __future__ import annotations

import look
from estimates import Estimate, frame_ms
from figures.figure import Figure, Panel, file_name, groups, of_stage, positive
from figures.imaged import mode_label, place, place_title, short_title, software_note, swept
from figures.scatter import Curve, draw_curves, label_curves
from rows import Row, varying_parameters


def draw(rows: list[Row]) -> list[Panel]:
    usable = [
        row
        for row in of_stage(rows, "render")
        if isinstance(row.get("picture_error"), dict) and positive(frame_ms(row)[0])
    ]
    panels = []
    for where, found in groups(usable, place).items():
        kinds = {frame_ms(row)[1] for row in found}
        for kind in sorted(kinds):
            panels.append(
                panel(
                    where, kind, [row for row in found if frame_ms(row)[1] == kind], len(kinds) > 1
                )
            )
    return panels


def panel(where: tuple[str, str, str, str, str], kind: str, found: list[Row], named: bool) -> Panel:
    varying = varying_parameters(found)
    sweeps = swept(found)
    curves = [
        curve(label, members, sweeps)
        for label, members in groups(found, lambda row: mode_label(row, varying)).items()
    ]
    drawing, (axis,) = look.new_panel()
    exact_at = look.axis_with_exact(
        [None if y is None else y.value for c in curves for _, y in c.points],
        axis,
        f"exact or above {look.GOOD_AS_EXACT_DB:.0f} dB",
    )
    draw_curves(axis, curves, exact_at)
    look.log_axis(axis, "x")
    axis.set_xlabel(
        f"ms per frame, {'fixed view, cache filled' if kind == 'held' else 'path from an empty cache'}"
    )
    axis.set_ylabel("PSNR of the image, dB")
    axis.set_title(short_title(where))
    label_curves(axis, curves, exact_at, 4)
    told = look.describe_points(
        [(c.label, x.value, y.value) for c in curves for x, y in c.points if y], "ms", "dB"
    )
    note = (f"Along a line: {', '.join(sweeps)}. " if sweeps else "") + software_note(found)
    name = file_name(" ".join(where[:4]) + (f" {kind}" if named else ""))
    return Panel(name, place_title(where) + f"; {kind}", drawing, told, len(found), note)


def curve(label: str, rows: list[Row], sweeps: list[str]) -> Curve:
    def order(row: Row) -> list[float]:
        return [
            row.number(f"render/{name}") if row.number(f"render/{name}") is not None else 99.0
            for name in sweeps
        ]

    points = []
    for row in sorted(rows, key=order):
        psnr = row.number("picture_error/psnr_db")
        time = frame_ms(row)[0]
        if time is not None:
            points.append(
                (time, None if psnr is None or psnr >= look.GOOD_AS_EXACT_DB else Estimate(psnr))
            )
    codec, cache = rows[0].codec, rows[0].text("render/cache")
    line = "-" if sweeps else ""
    return Curve(
        label,
        look.codec_colour(codec),
        look.cache_marker(cache),
        line,
        points,
        look.codec_fill(codec),
    )


FIGURE = Figure(
    "frame-error",
    "Frames",
    "Frame time against image error",
    "Device time of a frame against the PSNR of the image, of labels to level bias 0 and many samples, of scalars to the original. The colour is the "
    "codec's, the marker the access mode's. Times with the interval of the median of their repetitions (95 % from six on, none below three). Upper left is better.",
    "No row of stage render with image_error. configs/sweeps.yaml (labels) and configs/paper/tvq_steps.yaml (scalars) have it.",
    draw,
)
