"""Codecs ranked: the best of each on each volume, and their means over the volumes that have all of
them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import estimates as e
from estimates import Estimate, spell
from rows import Row


def best_by_volume(
    rows: list[Row], read: Callable[[Row], Estimate | None], smaller: bool = True
) -> dict[str, dict[str, Estimate]]:
    """Volume -> codec -> its best estimate over parameters and threads."""
    found: dict[str, dict[str, Estimate]] = {}
    for row in rows:
        value = read(row)
        if value is None or value.value <= 0:
            continue
        codecs = found.setdefault(row.volume, {})
        before = codecs.get(row.codec)
        if before is None or (value.value < before.value) == smaller:
            codecs[row.codec] = value
    return found


@dataclass
class Ranking:
    """`order`: codecs by geometric mean over `volumes`, the best first."""

    order: list[tuple[str, float]]
    wins: Counter[str]
    volumes: list[str]
    left_out: list[str]
    best: dict[str, dict[str, Estimate]]

    def mean(self, codec: str) -> float:
        return dict(self.order)[codec]


def rank(best: dict[str, dict[str, Estimate]], smaller: bool = True) -> Ranking | None:
    """Over a set of codecs and the volumes that have them all: of the sets that single volumes
    have, the one with the most pairs of both.
    """
    if not best:
        return None
    seen = Counter(codec for codecs in best.values() for codec in codecs)
    sets = [set(codecs) for codecs in best.values()]
    chosen = max(sets, key=lambda one: (len(one) * sum(one <= other for other in sets), len(one)))
    volumes = [volume for volume, codecs in best.items() if chosen <= set(codecs)]
    ranked = [codec for codec in seen if codec in chosen]
    means = [
        (codec, e.geometric_mean([best[volume][codec].value for volume in volumes]) or 0.0)
        for codec in ranked
    ]
    means.sort(key=lambda one: one[1] if smaller else -one[1])
    pick = min if smaller else max
    wins = Counter(pick(ranked, key=lambda codec: best[volume][codec].value) for volume in volumes)
    return Ranking(means, wins, volumes, sorted(set(seen) - set(ranked)), best)


def standing(ranking: Ranking, unit: str, most: int = 5) -> str:
    """ "lzma 1.06 %, compresso-lzma 1.14 %"."""
    return ", ".join(f"{codec} {spell(value)} {unit}" for codec, value in ranking.order[:most])


def wins_sentence(ranking: Ranking, word: str) -> str:
    """ "Smallest on single volumes: lzma 2, csgv-rans 4."."""
    return (
        f"{word} on single volumes: "
        + ", ".join(f"{codec} on {number}" for codec, number in ranking.wins.most_common())
        + "."
    )


def not_ranked(ranking: Ranking) -> str:
    return (
        f" Not ranked, since not measured on all of these volumes: {', '.join(ranking.left_out)}."
        if ranking.left_out
        else ""
    )


def clearly_first(ranking: Ranking, volume: str) -> str:
    """The fastest codec of a volume if its interval is apart from the next one's."""
    order = sorted((c for c, _ in ranking.order), key=lambda c: ranking.best[volume][c].value)
    if len(order) == 1 or not ranking.best[volume][order[0]].apart(ranking.best[volume][order[1]]):
        return ""
    return order[0]
