"""Points and lines with direct labels, which most figures are made of."""

from __future__ import annotations

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


@dataclass
class Curve:
    label: str
    colour: str
    marker: str
    line: str
    points: list[tuple[Estimate, Estimate | None]]


def draw_points(axis: Axes, points: list[Point], label: bool = True) -> None:
    """Points with intervals; logarithmic axes. Labels are direct."""
    for point in points:
        assert point.y is not None
        axis.errorbar(point.x.value, point.y.value, xerr=look.error_bars(point.x), yerr=look.error_bars(point.y), fmt=point.marker,
                      color=point.colour, elinewidth=0.8, capsize=0)
    look.log_axis(axis, "x")
    look.log_axis(axis, "y")
    axis.margins(0.12)
    if label:
        label_points(axis, [(p.label, p.colour, p.x.value, p.y.value) for p in points if p.y is not None])


def label_points(axis: Axes, labels: list[tuple[str, str, float, float]]) -> None:
    """Once the limits stand."""
    axis.figure.draw_without_rendering()
    to_points = 72 / axis.figure.dpi
    placed = []
    for _, _, x, y in labels:
        px, py = (v * to_points for v in axis.transData.transform((x, y)))
        placed.append((px - 2, py - 2, px + 2, py + 2))
    for text, colour, x, y in sorted(labels, key=lambda one: (-one[3], one[2])):
        look.direct_label(axis, x, y, text, colour, placed)


def draw_curves(axis: Axes, curves: list[Curve], exact_at: float | None = None) -> None:
    """Curves with intervals; exact points lie at `exact_at`."""
    for curve in curves:
        xs = [x.value for x, _ in curve.points]
        ys = [exact_at if y is None else y.value for _, y in curve.points]
        axis.plot(xs, ys, curve.line, marker=curve.marker, color=curve.colour, label=curve.label, markersize=3.4)
        for (x, y), height in zip(curve.points, ys):
            axis.errorbar(x.value, height, xerr=look.error_bars(x), yerr=None if y is None else look.error_bars(y), fmt="none",
                          ecolor=curve.colour, elinewidth=0.8)


def legend_below(axis: Axes, columns: int = 2) -> None:
    """A legend under the axis; the panel grows by its lines."""
    handles, labels = axis.get_legend_handles_labels()
    if not handles:
        return
    columns = 1 if max(map(len, labels)) > 34 else columns
    axis.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, -0.28 if len(axis.figure.axes) < 2 else -0.5), ncol=columns,
                handlelength=2.2, columnspacing=1.2, borderaxespad=0)
    axis.figure.set_figheight(axis.figure.get_figheight() + 0.13 * -(-len(handles) // columns))


def label_curves(axis: Axes, curves: list[Curve], exact_at: float | None = None, most: int = 6) -> None:
    """At the last point of each of few curves, else a legend below."""
    if len(curves) > most or any(len(curve.label) > 24 for curve in curves):
        legend_below(axis)
        return
    axis.margins(x=0.18)
    ends = []
    for curve in curves:
        x, y = curve.points[-1]
        height = exact_at if y is None else y.value
        if height is not None:
            ends.append((curve.label, curve.colour, x.value, height))
    label_points(axis, ends)
