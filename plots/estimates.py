"""Quantities of rows: a value, the interval of a time, and the number of repetitions behind it.

Intervals are those of the median by order statistics, as the harness defines them
(experiments/analysis/statistics.hpp): of at least 95 % from six repetitions on; below that they are
minimum and maximum, and below three there is none (experiments/analysis/reading.hpp).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rows import Row, finite

LEAST_REPETITIONS = 3
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """`low` and `high` are None for exact figures and for times that were repeated too seldom; n is
    0 for exact figures.
    """

    value: float
    low: float | None = None
    high: float | None = None
    n: int = 0

    def scaled(self, factor: float) -> Estimate:
        return Estimate(
            *(None if x is None else x * factor for x in (self.value, self.low, self.high)), self.n
        )

    def inverted(self, work: float) -> Estimate:
        """Work a second of a time."""
        ends = None if not self.low or not self.high else (work / self.high, work / self.low)
        return Estimate(work / self.value, *(ends or (None, None)), self.n)

    def apart(self, other: Estimate) -> bool:
        """Whether both have an interval and these do not overlap."""
        if self.low is None or self.high is None or other.low is None or other.high is None:
            return False
        return self.high < other.low or other.high < self.low


def interval_rank(n: int) -> int:
    """1-based rank of the lower end of the 95 % interval of the median of n samples; 1 where no
    rank reaches it.
    """
    tail, rank = 0.0, 0
    while rank < (n + 1) // 2:
        tail += math.comb(n, rank) / 2**n
        if 1 - 2 * tail < CONFIDENCE:
            break
        rank += 1
    return max(1, rank)


def median_of(samples: Iterable[Any]) -> Estimate | None:
    """Median and its interval."""
    ascending = sorted(x for x in map(finite, samples) if x is not None)
    n = len(ascending)
    if n == 0:
        return None
    median = (ascending[(n - 1) // 2] + ascending[n // 2]) / 2
    if n < LEAST_REPETITIONS:
        return Estimate(median, n=n)
    rank = interval_rank(n)
    return Estimate(median, ascending[rank - 1], ascending[n - rank], n)


def estimate(statistics: Any) -> Estimate | None:
    """Of an object of the schema's `statistics`."""
    if not isinstance(statistics, dict):
        return None
    samples = statistics.get("samples")
    found = median_of(samples) if isinstance(samples, list) else None
    if found is not None:
        return found
    median = finite(statistics.get("median"))
    return None if median is None else Estimate(median)


def seconds(row: Row) -> Estimate | None:
    return estimate(row.get("time/seconds"))


def speed(row: Row) -> Estimate | None:
    """10^6 voxels per second of an encode or decode row, by wall time."""
    time, voxels = seconds(row), row.number("dataset/voxels")
    return None if time is None or time.value <= 0 or not voxels else time.inverted(voxels / 1e6)


def access_ns(row: Row, points: str = "uniform", lod: int = 0) -> Estimate | None:
    """Nanoseconds a voxel at random."""
    for series in row.objects("access"):
        if series.get("points") == points and series.get("lod") == lod:
            return estimate(series.get("ns_per_voxel"))
    return None


def counted_rounds(row: Row, series: str) -> list[list[float]]:
    """Milliseconds of the frames of each round after the first; of a single round where there is
    but one.
    """
    rounds = row.get(f"{series}/ms", [])
    kept = (
        [[x for x in map(finite, one) if x is not None] for one in rounds if isinstance(one, list)]
        if isinstance(rounds, list)
        else []
    )
    kept = [one for one in kept if one]
    return kept[1:] if len(kept) > 1 else kept


def warm_ms(row: Row) -> Estimate | None:
    """Median device time of a frame of the fixed view, the cache filled; each frame is a repetition."""
    value = row.number("held/median_ms")
    if value is None:
        return None
    return with_value(
        value, median_of(ms for frames in counted_rounds(row, "held") for ms in frames)
    )


def path_ms(row: Row) -> Estimate | None:
    """Mean device time of a frame of the path, which begins with an empty cache; each round is a
    repetition.
    """
    value = row.number("frames/mean_ms")
    if value is None:
        return None
    return with_value(
        value, median_of(sum(frames) / len(frames) for frames in counted_rounds(row, "frames"))
    )


def first_frame_ms(row: Row) -> Estimate | None:
    """Device time of the path's first frame, from an empty cache."""
    value = row.number("frames/first_frame_ms")
    if value is None:
        return None
    return with_value(value, median_of(frames[0] for frames in counted_rounds(row, "frames")))


def with_value(value: float, repeated: Estimate | None) -> Estimate:
    """The row's own figure with the interval of its repetitions, widened to hold the figure."""
    if repeated is None:
        return Estimate(value)
    if repeated.low is None or repeated.high is None:
        return Estimate(value, n=repeated.n)
    return Estimate(value, min(value, repeated.low), max(value, repeated.high), repeated.n)


def frame_ms(row: Row) -> tuple[Estimate | None, str]:
    """The fixed view's time where there is one, else the path's, and which of the two."""
    held = warm_ms(row)
    return (held, "held") if held is not None else (path_ms(row), "path")


def bits_per_voxel(row: Row) -> float | None:
    return row.number("size/bits_per_voxel")


def rate(row: Row) -> float | None:
    """Percent of the original's bytes, the whole file."""
    return row.number("size/rate")


def gpu_mib(row: Row) -> float | None:
    found = row.number("memory/gpu_bytes")
    return None if found is None else found / 2**20


def is_exact(row: Row) -> bool:
    """Whether not one voxel of the decoded volume differs."""
    return row.number("verification/mismatches") == 0 and bool(
        row.number("verification/voxels_compared")
    )


def geometric_mean(values: Sequence[float]) -> float | None:
    """None where there is no value or one that is not positive."""
    if not values or min(values) <= 0:
        return None
    return math.exp(sum(map(math.log, values)) / len(values))


def spell(number: float | None, digits: int = 3) -> str:
    """Significant digits, all of an integer part, without an exponent up to 10^7; nothing for None."""
    if number is None:
        return ""
    if number == 0 or not 1e-4 <= abs(number) < 1e7:
        return f"{number:.{digits}g}"
    decimals = digits - 1 - math.floor(math.log10(abs(number)))
    return f"{number:,.{max(0, decimals)}f}"


def spell_estimate(found: Estimate | None, unit: str = "") -> str:
    """ "14.2 ns [13.0, 15.1], n = 9"."""
    if found is None:
        return ""
    text = spell(found.value) + (f" {unit}" if unit else "")
    if found.low is not None:
        text += f" [{spell(found.low)}, {spell(found.high)}]"
    return f"{text}, n = {found.n}" if found.n else text
