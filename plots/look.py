"""How figures look: colours, markers, sizes, and how they become SVG and PDF.

A panel is one column of a two-column paper wide, 3.3 inches, with type of 7 points. Colours are mid
tones: each stands out by 3 : 1 or more from white and from the page's dark background, and differs
from the others for the colour-blind as Okabe and Ito's do, darkened; what shares a colour differs
by its marker. Text and axes have one placeholder colour, which becomes `currentColor` in the page.
"""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

from matplotlib.axes import Axes  # noqa: E402
from matplotlib.figure import Figure as Drawing  # noqa: E402
from matplotlib.ticker import (  # noqa: E402
    FixedFormatter,
    FixedLocator,
    FuncFormatter,
    LogLocator,
    MaxNLocator,
    NullLocator,
)

from codec_list import Codec  # noqa: E402
from estimates import Estimate, spell  # noqa: E402
from rows import Row  # noqa: E402

COLUMN_INCHES = 3.3
HEIGHT_INCHES = 2.35
INK = "#121314"
LETTER_POINTS = 3.7  # of a label, about
AXIS_POINTS = 200.0  # width of a panel's axes, about
LEGEND_LINE_INCHES = 0.132
GOOD_AS_EXACT_DB = 100.0  # of an image: differences are rounding alone

BLUE, ORANGE, GREEN, PURPLE, RED, GREY, TEAL, PINK = (
    "#2f7fc1",
    "#b87400",
    "#17936c",
    "#8f6bd1",
    "#d1562f",
    "#808080",
    "#12899b",
    "#c2609b",
)

COLOURS = (GREY, ORANGE, PINK, BLUE, GREEN, PURPLE, RED, TEAL)
MARKERS = ("s", "^", "v", "D", "o", "P", "X", "<", ">", "h")
# How markers of a colour are filled, where the marker is the access mode's.
FILLS = ("full", "none", "left", "top", "right", "bottom")
CACHE_MARKERS = {
    "none": "o",
    "voxel": "s",
    "voxel-es": "D",
    "voxel-es-paper": "d",
    "brick": "^",
    "brick-coop": "v",
    "brick-coop-shared": "P",
    "slices": "X",
}
LINES = ("-", "--", ":", "-.")

SETTINGS = {
    "font.family": ["DejaVu Sans"],
    "font.size": 7,
    "axes.titlesize": 7.5,
    "axes.labelsize": 7,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.2,
    "text.color": INK,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": GREY,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.4,
    "lines.linewidth": 1.1,
    "lines.markersize": 4,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
    "svg.fonttype": "none",
    "svg.hashsalt": "cvrbench",
    "pdf.fonttype": 42,
    "text.parse_math": False,
    "legend.frameon": False,
    "axes.axisbelow": True,
    "figure.constrained_layout.use": True,
}
matplotlib.rcParams.update(SETTINGS)


@dataclass(frozen=True)
class Look:
    """`fill` takes the marker's place where the marker is the access mode's."""

    colour: str
    marker: str
    fill: str


class Palette:
    """What each codec looks like, by its place in a list: a family has a colour of its own while
    there is one, then the one that the fewest codecs have; what shares a colour differs by marker
    and fill. Two codecs have two looks, up to as many as there are colours and markers.
    """

    def __init__(self, codecs: Iterable[Codec] = ()) -> None:
        self.looks: dict[str, Look] = {}
        self.colours: dict[str, str] = {}
        self.used = Counter({colour: 0 for colour in COLOURS})
        for codec in codecs:
            self.add(codec)

    def add(self, codec: Codec) -> None:
        if codec.id in self.looks:
            return
        colour = self.colours.get(codec.family)
        if colour is None or self.used[colour] >= len(FILLS):
            colour = self.colours[codec.family] = min(COLOURS, key=lambda one: self.used[one])
        at = self.used[colour]
        self.used[colour] += 1
        self.looks[codec.id] = Look(colour, MARKERS[at % len(MARKERS)], FILLS[at % len(FILLS)])

    def of(self, codec: str) -> Look:
        self.add(Codec(codec, codec))
        return self.looks[codec]

    def order(self, codec: str) -> int:
        self.of(codec)
        return list(self.looks).index(codec)


palette = Palette()


def use_codecs(listed: Iterable[Codec], others: Iterable[str]) -> None:
    """Looks for the codecs of a list, then for others by their names."""
    global palette
    palette = Palette([*listed, *(Codec(name, name) for name in sorted(set(others)))])


def codec_colour(codec: str) -> str:
    return palette.of(codec).colour


def codec_marker(codec: str) -> str:
    return palette.of(codec).marker


def codec_fill(codec: str) -> str:
    return palette.of(codec).fill


def codec_order(codec: str) -> int:
    """The place in the list, behind it that by name."""
    return palette.order(codec)


def row_order(row: Row) -> tuple:
    """Rows of a volume by codec, parameters as numbers where they are, threads, access mode."""
    modes = list(CACHE_MARKERS)
    cache = row.text("render/cache")
    return (
        codec_order(row.codec),
        tuple(
            (name, leading_numbers(value), value) for name, value in sorted(row.parameters.items())
        ),
        row.threads,
        modes.index(cache) if cache in modes else len(modes),
        cache,
    )


def leading_numbers(text: str) -> tuple[float, ...]:
    return tuple(float(part) for part in re.findall(r"\d+(?:\.\d+)?", text))


def cache_marker(cache: str) -> str:
    """Of a mode that has none of its own one that depends on its name alone."""
    return CACHE_MARKERS.get(cache) or MARKERS[sum(cache.encode()) % len(MARKERS)]


def new_panel(height: float = HEIGHT_INCHES, stacked: int = 1) -> tuple[Drawing, list[Axes]]:
    """An empty panel of `stacked` axes over one another that share x."""
    drawing = Drawing(figsize=(COLUMN_INCHES, height))
    return drawing, list(drawing.subplots(stacked, 1, sharex=True, squeeze=False)[:, 0])


def log_axis(axis: Axes, which: str) -> None:
    """A logarithmic axis with plain numbers; 2 and 5 are labelled too where the range is short,
    even steps where it is within a decade.
    """
    getattr(axis, f"set_{which}scale")("log")
    low, high = getattr(axis, f"get_{which}lim")()
    target = getattr(axis, f"{which}axis")
    span = high / low if low > 0 else 1e9
    target.set_major_locator(
        MaxNLocator(5, steps=[1, 2, 5, 10])
        if span < 6
        else LogLocator(subs=(1, 2, 5) if span < 300 else (1,), numticks=12)
    )
    target.set_major_formatter(
        FuncFormatter(lambda value, _: f"{value:g}" if 1e-4 <= value < 1e6 else f"{value:.0e}")
    )
    target.set_minor_locator(NullLocator())


def error_bars(found: Estimate) -> list[list[float]] | None:
    """The interval as matplotlib wants it."""
    if found.low is None or found.high is None:
        return None
    return [[max(0.0, found.value - found.low)], [max(0.0, found.high - found.value)]]


Box = tuple[float, float, float, float]
PLACES = (
    (4, -2.2, "left"),
    (-4, -2.2, "right"),
    (4, 5, "left"),
    (4, -9.5, "left"),
    (-4, 5, "right"),
    (-4, -9.5, "right"),
    (4, 12, "left"),
    (4, -16, "left"),
    (-4, 12, "right"),
    (-4, -16, "right"),
)


def in_points(axis: Axes, x: float, y: float) -> tuple[float, float]:
    """Where a value lies, in points of the panel."""
    px, py = axis.transData.transform((x, y))
    return px * 72 / axis.figure.dpi, py * 72 / axis.figure.dpi


def place_label(
    axis: Axes, x: float, y: float, text: str, taken: list[Box]
) -> tuple[float, float, str] | None:
    """The first place beside a point where a label overlaps neither what is taken nor the edge;
    None where there is none.
    """
    width, height = LETTER_POINTS * len(text), 7.0
    px, py = in_points(axis, x, y)
    left, bottom, right, top = (v * 72 / axis.figure.dpi for v in axis.get_window_extent().extents)
    for dx, dy, side in PLACES:
        x0 = px + dx - (width if side == "right" else 0)
        box = (x0, py + dy, x0 + width, py + dy + height)
        inside = (
            box[0] >= left - 2
            and box[2] <= right + 8
            and box[1] >= bottom - 2
            and box[3] <= top + 6
        )
        if inside and not any(
            box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in taken
        ):
            taken.append(box)
            return dx, dy, side
    return None


def freeze(drawing: Drawing) -> None:
    """Lays the panel out once: afterwards nothing moves, and saving it in several formats costs no
    further layout.
    """
    if drawing.get_layout_engine() is not None:
        drawing.draw_without_rendering()
        drawing.set_layout_engine("none")


def number_ids(svg: str, prefix: str) -> str:
    """Ids in the order of their appearance: matplotlib makes some of addresses in memory, which no
    two runs share. Those that nothing refers to go.
    """
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', svg))
    names: dict[str, str] = {}

    def renamed(name: str) -> str:
        return names.setdefault(name, f"{prefix}-{len(names)}")

    svg = re.sub(
        r' id="([^"]*)"',
        lambda m: f' id="{renamed(m.group(1))}"' if m.group(1) in used else "",
        svg,
    )
    return re.sub(r'(href="#|url\(#)([^")]+)', lambda m: m.group(1) + renamed(m.group(2)), svg)


def to_svg(drawing: Drawing, prefix: str, label: str, description: str) -> str:
    """The panel as an inline SVG element: its ids begin with `prefix`, and title and desc say what
    it shows.
    """
    freeze(drawing)
    text = io.StringIO()
    drawing.savefig(
        text, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None}
    )
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>\s*", "", svg, flags=re.S)
    svg = number_ids(svg, prefix)
    svg = svg.replace("xlink:href=", "href=").replace(INK, "currentColor")
    svg = re.sub(r' xmlns:xlink="[^"]*"', "", svg)
    svg = re.sub(r"(\d+\.\d{2})\d+", r"\1", svg)
    opening = re.match(r"<svg[^>]*>", svg)
    assert opening is not None
    box = re.search(r'viewBox="([^"]*)"', opening.group(0))
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box.group(1) if box else "0 0 238 170"}" role="img" '
        f'aria-labelledby="{prefix}-title {prefix}-desc"><title id="{prefix}-title">{escape(label)}</title>'
        f'<desc id="{prefix}-desc">{escape(description)}</desc>'
    )
    return head + svg[opening.end() :]


def escape(text: str) -> str:
    return (
        text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")
    )


def write_files(drawing: Drawing, stem: Path) -> None:
    """STEM.pdf and STEM.svg as they go into a paper: black text, transparent background."""
    drawing.savefig(
        stem.with_name(stem.name + ".pdf"),
        metadata={"CreationDate": None, "ModDate": None, "Creator": None, "Producer": None},
    )
    with matplotlib.rc_context({"svg.fonttype": "path"}):
        text = io.StringIO()
        drawing.savefig(text, format="svg", metadata={"Date": None})
    stem.with_name(stem.name + ".svg").write_text(
        number_ids(text.getvalue(), "c"), encoding="utf-8"
    )


def axis_with_exact(values: list[float | None], axis: Axes, word: str = "exact") -> float:
    """Where exact points (None) lie on a PSNR axis: above all others, with a line that says so. The
    y of that line.
    """
    known = [v for v in values if v is not None]
    low, high = (min(known), max(known)) if known else (30.0, 40.0)
    top = high + max(3.0, 0.2 * (high - low))
    if any(v is None for v in values):
        axis.axhline(top, color=GREY, linewidth=0.6, linestyle=":")
        axis.annotate(
            word,
            (0, top),
            (2, 2),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            fontsize=6,
        )
    return top


def describe_points(
    points: list[tuple[str, float, float]], x_name: str, y_name: str, most: int = 12
) -> str:
    """What a reader who cannot see the panel needs: each point, up to `most` of them."""
    told = "; ".join(
        f"{label}: {x_name} {spell(x)}, {y_name} {spell(y)}" for label, x, y in points[:most]
    )
    return told + (f"; and {len(points) - most} more" if len(points) > most else "")


def log_axis_labels(axis: Axes, ticks: list[float]) -> None:
    """Few values of a logarithmic x axis labelled one by one, large ones as powers."""
    axis.xaxis.set_major_locator(FixedLocator(ticks))
    axis.xaxis.set_major_formatter(
        FixedFormatter([spell(tick) if tick >= 1e4 else f"{tick:g}" for tick in ticks])
    )
