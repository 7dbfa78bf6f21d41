"""Points and lines with direct labels, which most figures are made of."""

from __future__ import annotations

import re
from dataclasses import dataclass

from matplotlib.axes import Axes

import look
from estimates import Estimate


@dataclass
class Point:
    """`y` None: exact, of a PSNR."""

    label: str
    colour: str
    marker: str
    x: Estimate
    y: Estimate | None
    fill: str = "full"


@dataclass
class Curve:
    label: str
    colour: str
    marker: str
    line: str
    points: list[tuple[Estimate, Estimate | None]]
    fill: str = "full"


def by_numbers(text: str) -> list[tuple[int, str]]:
    """Orders brick=8 before brick=16."""
    return [(int(part), "") if part.isdigit() else (0, part) for part in re.split(r"(\d+)", text)]


def tell_apart(points: list[Point]) -> None:
    """Sorts points by their labels, and tells settings of one codec by how their markers are filled:
    where labels find no room beside the points, colour and marker alone do not say which is which.
    """
    points.sort(key=lambda point: by_numbers(point.label))
    settings: dict[tuple[str, str], list[str]] = {}
    for point in points:
        labels = settings.setdefault((point.colour, point.marker), [])
        if point.label not in labels:
            labels.append(point.label)
        point.fill = look.FILLS[labels.index(point.label) % len(look.FILLS)]


def draw_points(axis: Axes, points: list[Point]) -> None:
    """Points with intervals; logarithmic axes."""
    for point in points:
        assert point.y is not None
        axis.errorbar(
            point.x.value,
            point.y.value,
            xerr=look.error_bars(point.x),
            yerr=look.error_bars(point.y),
            fmt=point.marker,
            color=point.colour,
            fillstyle=point.fill,
            elinewidth=0.8,
            capsize=0,
        )
    axis.margins(0.12)
    look.log_axis(axis, "x")
    look.log_axis(axis, "y")


@dataclass(frozen=True)
class Key:
    """An entry of a legend."""

    label: str
    colour: str
    marker: str
    fill: str = "full"


def name_points(
    axis: Axes, points: list[Point], most: int = 24, keys: list[Key] | None = None
) -> None:
    """Direct labels where there is room for all, else a legend below: of `keys`, by default one for
    each point. The last step of a panel.
    """
    labels = [(p.label, p.colour, p.x.value, p.y.value) for p in points if p.y is not None]
    axis.figure.draw_without_rendering()
    bars = [box for point in points for box in bars_of(axis, point)]
    if len(points) <= most and label_points(axis, labels, bars):
        return
    for key in keys or dict.fromkeys(Key(p.label, p.colour, p.marker, p.fill) for p in points):
        axis.plot([], [], key.marker, color=key.colour, fillstyle=key.fill, label=key.label)
    legend_below(axis)


def bars_of(axis: Axes, point: Point) -> list[look.Box]:
    """What the vertical interval of a point covers."""
    if point.y is None or not point.y.low or not point.y.high:
        return []
    (x, low), (_, high) = (
        look.in_points(axis, point.x.value, y) for y in (point.y.low, point.y.high)
    )
    return [(x - 1, low, x + 1, high)]


def label_points(
    axis: Axes, labels: list[tuple[str, str, float, float]], taken: list[look.Box]
) -> bool:
    """Labels beside points, or none and False where one of them finds no place. `taken`: what they
    must not cover, besides the points.
    """
    axis.figure.draw_without_rendering()
    boxes = taken + [
        (px - 2, py - 2, px + 2, py + 2)
        for px, py in (look.in_points(axis, x, y) for _, _, x, y in labels)
    ]
    found = []
    for text, colour, x, y in sorted(labels, key=lambda one: (-one[3], one[2])):
        place = look.place_label(axis, x, y, text, boxes)
        if place is None:
            return False
        found.append((text, colour, x, y, place))
    look.freeze(axis.figure)
    for text, colour, x, y, (dx, dy, side) in found:
        axis.annotate(
            text,
            (x, y),
            (dx, dy),
            textcoords="offset points",
            ha=side,
            va="bottom",
            fontsize=6,
            color=colour,
            annotation_clip=False,
        )
    return True


def draw_curves(axis: Axes, curves: list[Curve], exact_at: float | None = None) -> None:
    """Curves with intervals; exact points lie at `exact_at`."""
    for curve in curves:
        xs = [x.value for x, _ in curve.points]
        ys = [exact_at if y is None else y.value for _, y in curve.points]
        axis.plot(
            xs,
            ys,
            curve.line,
            marker=curve.marker,
            color=curve.colour,
            label=curve.label,
            markersize=3.4,
            fillstyle=curve.fill,
        )
        for (x, y), height in zip(curve.points, ys):
            axis.errorbar(
                x.value,
                height,
                xerr=look.error_bars(x),
                yerr=None if y is None else look.error_bars(y),
                fmt="none",
                ecolor=curve.colour,
                elinewidth=0.8,
            )


def legend_below(axis: Axes) -> None:
    """A legend under the axes, as wide as the panel; the panel grows by its lines."""
    handles, labels = axis.get_legend_handles_labels()
    if not handles:
        return
    drawing = axis.figure
    columns = max(
        1,
        min(
            3,
            int((72 * look.COLUMN_INCHES - 6) / (look.LETTER_POINTS * max(map(len, labels)) + 26)),
        ),
    )
    inches = look.LEGEND_LINE_INCHES * -(-len(handles) // columns) + 0.05
    height = drawing.get_figheight() + inches
    drawing.set_figheight(height)
    drawing.get_layout_engine().set(rect=(0, inches / height, 1, 1 - inches / height))
    drawing.legend(
        handles,
        labels,
        loc="lower center",
        bbox_to_anchor=(0.5, 0),
        ncol=columns,
        handlelength=2.2,
        columnspacing=1.2,
        borderaxespad=0.2,
    )


def make_room(axis: Axes, letters: int) -> None:
    """Room for labels at the right of a logarithmic x axis."""
    share = min(0.45, (look.LETTER_POINTS * letters + 6) / look.AXIS_POINTS)
    low, high = axis.get_xlim()
    axis.set_xlim(low, high * (high / low) ** (share / (1 - share) * 0.8))


def along(axis: Axes, curve: Curve, exact_at: float | None) -> list[look.Box]:
    """Boxes along the lines of a curve, but for its end, where its label may stand."""
    at = [
        look.in_points(axis, x.value, y.value if y is not None else exact_at or 0.0)
        for x, y in curve.points
    ]
    steps = [
        (x0 + t / 12 * (x1 - x0), y0 + t / 12 * (y1 - y0))
        for (x0, y0), (x1, y1) in zip(at, at[1:])
        for t in range(12)
    ]
    return [(x - 1.5, y - 1.5, x + 1.5, y + 1.5) for x, y in steps]


def label_curves(
    axis: Axes, curves: list[Curve], exact_at: float | None = None, most: int = 6
) -> None:
    """At the last point of each of few curves where there is room, else a legend below. The last
    step of a panel.
    """
    if curves and len(curves) <= most and all(len(curve.label) <= 24 for curve in curves):
        limits = axis.get_xlim()
        make_room(axis, max(len(curve.label) for curve in curves))
        axis.figure.draw_without_rendering()
        ends = [
            (
                c.label,
                c.colour,
                c.points[-1][0].value,
                c.points[-1][1].value if c.points[-1][1] is not None else exact_at or 0.0,
            )
            for c in curves
        ]
        if label_points(
            axis, ends, [box for curve in curves for box in along(axis, curve, exact_at)]
        ):
            return
        axis.set_xlim(limits)
    legend_below(axis)
