"""Rate against distortion of lossy codecs."""

from __future__ import annotations

import look
from estimates import Estimate, bits_per_voxel, is_exact
from figures.figure import Figure, Panel, file_name, groups, of_stage
from figures.scatter import Curve, draw_curves, label_curves
from rows import Row, codec_label, varying_parameters


def is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def curve_parameters(rows: list[Row]) -> dict[str, set[str]]:
    """Of each codec the parameters that vary and are words: they tell curves apart, numbers are
    points of one curve.
    """
    varying = varying_parameters(rows)
    return {
        codec: {
            name
            for name in names
            if not all(
                is_number(row.parameters[name])
                for row in rows
                if row.codec == codec and name in row.parameters
            )
            and ","
            not in next(
                row.parameters[name]
                for row in rows
                if row.codec == codec and name in row.parameters
            )
        }
        for codec, names in varying.items()
    }


def draw(rows: list[Row]) -> list[Panel]:
    usable = [
        row
        for row in of_stage(rows, "encode", "decode", "random-access")
        if row.get("dataset/kind") == "scalars"
        and bits_per_voxel(row)
        and (is_exact(row) or row.number("error/psnr_db") is not None)
    ]
    panels = []
    for volume, found in groups(usable, lambda row: row.volume).items():
        names = curve_parameters(found)
        curves = [
            curve(label, members)
            for label, members in groups(found, lambda row: codec_label(row, names)).items()
        ]
        tell_apart(curves)
        drawing, (axis,) = look.new_panel()
        exact_at = look.axis_with_exact(
            [None if y is None else y.value for c in curves for _, y in c.points], axis
        )
        draw_curves(axis, curves, exact_at)
        look.log_axis(axis, "x")
        axis.set_xlabel("bits/voxel of the file")
        axis.set_ylabel("PSNR, dB")
        axis.set_title(volume)
        label_curves(axis, curves, exact_at)
        points = [(c.label, x.value, y.value) for c in curves for x, y in c.points if y]
        panels.append(
            Panel(
                file_name(volume),
                volume,
                drawing,
                look.describe_points(points, "bits per voxel", "dB"),
                sum(len(c.points) for c in curves),
            )
        )
    return panels


def curve(label: str, rows: list[Row]) -> Curve:
    """Distinct points by rate: encoding and decoding rows of a cell state the same."""
    distinct = {(bits_per_voxel(row) or 0.0, row.number("error/psnr_db")) for row in rows}
    ordered = sorted(distinct, key=lambda one: one[0])
    codec = rows[0].codec
    return Curve(
        label,
        look.codec_colour(codec),
        look.codec_marker(codec),
        "-",
        [(Estimate(x), None if y is None else Estimate(y)) for x, y in ordered],
    )


def tell_apart(curves: list[Curve]) -> None:
    """Curves of one codec share colour and marker and differ by lines and by how markers are
    filled.
    """
    for same in groups(curves, lambda one: one.colour + one.marker).values():
        for number, one in enumerate(same):
            one.line = look.LINES[number % len(look.LINES)]
            one.fill = look.FILLS[number // len(look.LINES) % len(look.FILLS)]


FIGURE = Figure(
    "rate-distortion",
    "Error of lossy codecs",
    "Rate against distortion",
    "Peak signal-to-noise ratio of the decoded volume (peak 255 for u8, else the range of the original) over bits per voxel of the whole file, "
    "logarithmic. Exact figures: no interval. Upper left is better. A line joins what one codec gives with other numbers as parameters.",
    "No row of a lossy codec on scalars that is ok. configs/quick.yaml has a few, configs/paper/rate_distortion.yaml sweeps them.",
    draw,
)
