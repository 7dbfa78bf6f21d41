"""What figures of scaling share: quantities of rows over something that grows."""

from __future__ import annotations

from collections.abc import Callable

import look
from estimates import Estimate, access_ns, frame_ms, rate, speed
from figures.figure import Panel, file_name, groups, of_stage, positive
from figures.imaged import place
from figures.scatter import Curve, draw_curves, label_curves
from rows import Row, codec_label, varying_parameters

Quantity = tuple[str, str, tuple[str, ...], Callable[[Row], Estimate | None]]

# Name, axis label, stages whose rows have it, reader.
RATE: Quantity = (
    "rate",
    "file size, % of the original",
    ("encode", "decode", "random-access"),
    lambda row: None if rate(row) is None else Estimate(rate(row) or 0),
)
ENCODE: Quantity = ("encode", "encode, Mvoxel/s", ("encode",), speed)
DECODE: Quantity = ("decode", "decode, Mvoxel/s", ("decode",), speed)
ACCESS: Quantity = ("access", "one voxel at random, ns", ("random-access",), access_ns)
FRAME: Quantity = ("frame", "ms per frame", ("render",), lambda row: frame_ms(row)[0])


def scaling_panels(
    rows: list[Row],
    quantities: list[Quantity],
    over: Callable[[Row], float | None],
    axis_label: str,
    where: Callable[[Row], str],
    left_out: set[str],
) -> list[Panel]:
    """A panel for each group of `where` and quantity in which a curve has two or more values of
    `over`. `left_out`: parameters that are not part of a curve's name, since they are what grows.
    """
    panels = []
    for name, label, stages, read in quantities:
        usable = [
            row for row in of_stage(rows, *stages) if over(row) is not None and positive(read(row))
        ]
        for title, found in groups(usable, where).items():
            curves = curves_of(found, over, read, left_out, name == "rate")
            if not curves:
                continue
            drawing, (axis,) = look.new_panel()
            draw_curves(axis, curves)
            look.log_axis(axis, "x")
            ticks = sorted({x.value for c in curves for x, _ in c.points})
            if len(ticks) <= 5:
                look.log_axis_labels(axis, ticks)
            look.log_axis(axis, "y")
            axis.set_xlabel(axis_label)
            axis.set_ylabel(label)
            axis.set_title(title if len(title) < 48 else title[:46] + "..")
            label_curves(axis, curves)
            told = look.describe_points(
                [(c.label, x.value, y.value) for c in curves for x, y in c.points if y],
                axis_label,
                name,
            )
            panels.append(
                Panel(
                    file_name(f"{title}-{name}"),
                    f"{title}: {name}",
                    drawing,
                    told,
                    sum(len(c.points) for c in curves),
                )
            )
    return panels


def curves_of(
    found: list[Row],
    over: Callable[[Row], float | None],
    read: Callable[[Row], Estimate | None],
    left_out: set[str],
    exact: bool,
) -> list[Curve]:
    varying = {codec: names - left_out for codec, names in varying_parameters(found).items()}
    several = (
        len({row.threads for row in found if row.stage != "render"}) > 1
        and "threads" not in left_out
        and not exact
    )

    def label(row: Row) -> str:
        cache = f" {row.text('render/cache')}" if row.stage == "render" else ""
        return (
            codec_label(row, varying)
            + cache
            + (f", {row.threads} thread{'s' * (row.threads != 1)}" if several else "")
        )

    curves = []
    for name, members in groups(found, lambda row: (label(row), settings(row, left_out))).items():
        at = {over(row): read(row) for row in members}
        points = sorted(
            ((Estimate(x), y) for x, y in at.items() if x is not None and y is not None),
            key=lambda one: one[0].value,
        )
        if len(points) < 2:
            continue
        codec, cache = members[0].codec, members[0].text("render/cache")
        marker = look.cache_marker(cache) if cache else look.codec_marker(codec)
        curves.append(
            Curve(
                name[0],
                look.codec_colour(codec),
                marker,
                look.LINES[len(curves) % len(look.LINES)],
                points,
                look.codec_fill(codec) if cache else "full",
            )
        )
    return curves


def settings(row: Row, left_out: set[str]) -> str:
    """Everything else that an image depends on, so that a curve never mixes two settings."""
    if row.stage != "render":
        return ""
    names = (
        "scene",
        "shading",
        "size",
        "cache_mib",
        "lod_bias",
        "ao_samples",
        "ao_roulette",
        "step",
    )
    return (
        "|".join(str(row.get(f"render/{name}")) for name in names if name not in left_out)
        + "|"
        + place(row)[-1]
    )
