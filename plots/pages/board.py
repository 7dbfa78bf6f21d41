"""Leaderboards: settings of codecs against rate, speeds and error, over volumes that all of them
have.

A board is of one kind of volumes. Its views differ by whose times they show: one machine and one
number of threads, or none. A view has one part for the means over its common volumes and one for
each volume. The common volumes are those that give the most pairs of a volume and a codec which has
one setting on all of them; a codec or setting that lacks one stands in no mean, and is named.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import estimates as e
import look
from estimates import Estimate, spell
from figures.figure import groups
from pages.measured import YARDSTICK, Clock, Measured, Setting, SettingKey, Volume
from tables import Cell, timed

EXACT_SORT = 1e9  # no error is better than any PSNR


@dataclass(frozen=True)
class Question:
    """`column`: of the figures of a line, by which settings are chosen and lines ordered."""

    name: str
    column: int
    smaller: bool
    unit: str


COLUMNS = (
    "rate, % of original",
    "encode, Mvoxel/s",
    "decode, Mvoxel/s",
    "one voxel, ns",
    "PSNR, dB",
)
RATE, ENCODE, DECODE, ACCESS, PSNR = range(5)
QUESTIONS = (
    Question("Smallest file", RATE, True, "%"),
    Question("Fastest single voxel", ACCESS, True, "ns"),
    Question("Fastest to decode", DECODE, False, "Mvoxel/s"),
    Question("Fastest to encode", ENCODE, False, "Mvoxel/s"),
)


@dataclass
class Line:
    """A setting. `cells`: one for each of COLUMNS."""

    codec: str
    setting: str
    cells: list[Cell]


@dataclass
class Part:
    """`title`: over which volumes; `left_out`: what no mean is made of, and why."""

    title: str
    lines: list[Line]
    volumes: list[str] = field(default_factory=list)
    left_out: str = ""


@dataclass
class View:
    """`clock` None: exact figures alone, of all machines."""

    clock: Clock | None
    parts: list[Part]


@dataclass
class Board:
    kind: str
    views: list[View]


def boards(measured: Measured, clocks: list[Clock]) -> list[Board]:
    """Of the kinds that have any, each with a view for every clock that has rows of it."""
    found = []
    for kind in ("labels", "scalars"):
        volumes = [volume for volume in measured.volumes.values() if volume.kind == kind]
        views = [view for clock in [*clocks, None] if (view := make_view(measured, volumes, clock))]
        if views:
            found.append(Board(kind, views))
    return found


def make_view(measured: Measured, volumes: list[Volume], clock: Clock | None) -> View | None:
    """None where nothing of it was measured."""
    by_page = {volume.page: volume for volume in volumes}
    having: dict[SettingKey, set[str]] = {}
    pages: dict[str, None] = {}
    for volume in volumes:
        for setting in settings_of(volume, clock):
            pages[volume.page] = None
            having.setdefault(setting.key, set())
            if setting.sized is not None:
                having[setting.key].add(volume.page)
    common = common_volumes(having)
    if not common:
        return None
    return View(
        clock,
        [
            means(measured, [by_page[page] for page in common], clock, having),
            *(
                single(measured, by_page[page], clock)
                for page in sorted(pages, key=lambda one: by_page[one].label)
            ),
        ],
    )


def common_volumes(having: dict[SettingKey, set[str]]) -> list[str]:
    """Of settings with the pages of their volumes the volumes with the most pairs; of equal ones
    those with more codecs. Tried are the volumes of each setting, and what two settings share.
    """
    single = {frozenset(pages) for pages in having.values() if pages}
    tried = single | {a & b for a in single for b in single if a & b}

    def worth(volumes: frozenset[str]) -> tuple[int, int, list[str]]:
        codecs = {key[0] for key, pages in having.items() if volumes <= pages}
        return -len(volumes) * len(codecs), -len(codecs), sorted(volumes)

    return sorted(min(tried, key=worth)) if tried else []


def settings_of(volume: Volume, clock: Clock | None) -> list[Setting]:
    """Those that were measured by a clock."""
    return [
        setting
        for key, setting in volume.settings.items()
        if key[0] != YARDSTICK
        and any(
            clock is None
            or (row.machine, row.threads) == (clock.machine, clock.threads)
            and row.stage in ("encode", "decode", "random-access")
            for row in setting.rows
        )
    ]


def times(setting: Setting, clock: Clock | None) -> list[tuple[Estimate, str] | None]:
    """Encode, decode, access with the address of their rows."""
    found: list[tuple[Estimate, str] | None] = []
    for stage, read in (("encode", e.speed), ("decode", e.speed), ("random-access", e.access_ns)):
        row = setting.row(stage, clock.machine, clock.threads) if clock else None
        time = read(row) if row is not None else None
        found.append((time, row) if time is not None and time.value > 0 else None)
    return found


def single(measured: Measured, volume: Volume, clock: Clock | None) -> Part:
    """Of one volume: each figure leads to its row."""
    lines = []
    for setting in settings_of(volume, clock):
        row = setting.sized
        cells = [rate_cell(setting, volume, measured)]
        for found in times(setting, clock):
            cells.append(timed(found[0] if found else None))
            if found:
                cells[-1].href = measured.row_address(found[1])
        cells.append(error_cell([setting]))
        if row is not None and cells[-1].text:
            cells[-1].href = measured.row_address(row)
        lines.append(line(measured, setting.key, cells))
    return Part(volume.label, in_order(lines, QUESTIONS[0]), [volume.page])


def rate_cell(setting: Setting, volume: Volume, measured: Measured) -> Cell:
    row = setting.sized
    if row is not None:
        return Cell(spell(e.rate(row), 4), e.rate(row), href=measured.row_address(row))
    if setting.torn:
        return Cell("conflict", None, "runs disagree", f"dataset/{volume.page}.html#conflicts")
    return Cell("")


def error_cell(settings: list[Setting]) -> Cell:
    """The least PSNR, "exact" where all are."""
    if all(setting.exact for setting in settings):
        return Cell("exact", EXACT_SORT)
    known = [setting.psnr for setting in settings if not setting.exact]
    if any(value is None for value in known):
        return Cell("")
    worst = min(value for value in known if value is not None)
    return Cell(f"{worst:.1f}", worst)


def line(measured: Measured, key: SettingKey, cells: list[Cell]) -> Line:
    return Line(key[0], measured.setting_label(key), cells)


def means(
    measured: Measured,
    common: list[Volume],
    clock: Clock | None,
    having: dict[SettingKey, set[str]],
) -> Part:
    """Over the common volumes, of settings that have a rate on all of them."""
    wanted = {volume.page for volume in common}
    lines: list[Line] = []
    short: dict[str, list[str]] = {}
    for key, pages in having.items():
        if not wanted <= pages:
            short.setdefault(key[0], []).append(measured.setting_label(key))
            continue
        lines.append(
            line(measured, key, mean_cells([volume.settings[key] for volume in common], clock))
        )
    ranked = {one.codec for one in lines}
    left_out = "; ".join(
        codec if codec not in ranked else ", ".join(labels)
        for codec, labels in sorted(short.items(), key=lambda one: look.codec_order(one[0]))
    )
    number = len(common)
    title = (
        f"mean over {number} data sets"
        if number > 1
        else f"the one with most codecs: {common[0].label}"
    )
    return Part(title, in_order(lines, QUESTIONS[0]), [volume.page for volume in common], left_out)


def mean_cells(settings: list[Setting], clock: Clock | None) -> list[Cell]:
    """Geometric means; a time that some of the volumes lack has none."""
    rates = [e.rate(setting.sized) for setting in settings if setting.sized is not None]
    rate = e.geometric_mean([value for value in rates if value])
    cells = [Cell(spell(rate, 4), rate)]
    for column in zip(*(times(setting, clock) for setting in settings)):
        known = [found[0].value for found in column if found]
        if len(known) == len(settings):
            mean = e.geometric_mean(known)
            cells.append(Cell(spell(mean), mean))
        else:
            cells.append(
                Cell("", None, f"on {len(known)} of {len(settings)}") if known else Cell("")
            )
    return [*cells, error_cell(settings)]


def better(question: Question) -> Callable[[Line], tuple[bool, float, float]]:
    """Orders lines: those with the figure first, by it, then by rate."""

    def key(one: Line) -> tuple[bool, float, float]:
        value, rate = one.cells[question.column].sort, one.cells[RATE].sort
        return (
            value is None,
            0.0 if value is None else value if question.smaller else -value,
            float("inf") if rate is None else rate,
        )

    return key


def in_order(lines: list[Line], question: Question) -> list[Line]:
    """The best first; lines that are equal as the list of codecs has them."""
    listed = sorted(lines, key=lambda one: (look.codec_order(one.codec), one.setting))
    return sorted(listed, key=better(question))


def best_settings(lines: list[Line], question: Question) -> list[Line]:
    """The first line of each codec."""
    return [found[0] for found in groups(in_order(lines, question), lambda o: o.codec).values()]
