"""Verdicts on claims: DIR/claims/*.jsonl, one object for each group of each claim
(experiments/analysis/claims.hpp).
"""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from estimates import spell
from rows import finite

HOLDS, FAILS, UNDECIDED, UNCHECKED = "holds", "does not hold", "undecided", "not testable here"
SIGNS = {HOLDS: "\u2713", FAILS: "\u2717", UNDECIDED: "?", UNCHECKED: "\u2013"}


@dataclass
class Group:
    label: str
    verdict: str
    reason: str
    value: float | None
    fitted: bool = False  # its volume was made to meet the published figure: it proves nothing


@dataclass
class Claim:
    name: str
    says: str
    source: str
    verdict: str
    bounds: str
    file: Path
    groups: list[Group] = field(default_factory=list)

    @property
    def sign(self) -> str:
        return SIGNS.get(self.verdict, "?")

    def count(self, verdict: str) -> int:
        return sum(group.verdict == verdict and not group.fitted for group in self.groups)

    @property
    def range(self) -> str:
        """Least and largest figure of the groups."""
        values = [
            group.value for group in self.groups if group.value is not None and not group.fitted
        ]
        if not values:
            return ""
        low, high = spell(min(values)), spell(max(values))
        return low if low == high else f"{low} .. {high}"


def bounds_of(data: dict[str, Any]) -> str:
    """ "published_rate, ratio, at least 0.95, at most 1.05"."""
    words = [str(data.get("metric", "")), str(data.get("compare", ""))]
    for key, word in (("at_least", "at least"), ("at_most", "at most")):
        bound = finite(data.get(key))
        if bound is not None:
            words.append(f"{word} {bound:g}")
    if finite(data.get("tolerance")):
        words.append(f"tolerance {data['tolerance']:g}")
    return ", ".join(word for word in words if word)


def group_of(data: dict[str, Any]) -> Group:
    labels = data.get("group")
    compared = data.get("compared")
    first = (
        compared[0]
        if isinstance(compared, list) and compared and isinstance(compared[0], dict)
        else {}
    )
    label = (
        ", ".join(f"{key} {value}" for key, value in labels.items())
        if isinstance(labels, dict)
        else ""
    )
    return Group(
        label,
        str(data.get("verdict", UNCHECKED)),
        str(data.get("reason", "")),
        finite(first.get("value")),
        data.get("fitted") is True,
    )


def read_claims(folder: Path) -> list[Claim]:
    """Claims of a results folder in the order of their files; lines that are no object are left
    out.
    """
    found: dict[tuple[Path, str], Claim] = {}
    for path in sorted((folder / "claims").glob("*.jsonl")):
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            try:
                data = json.loads(line)
            except ValueError:
                continue
            if not isinstance(data, dict) or "claim" not in data:
                continue
            key = (path, str(data["claim"]))
            if key not in found:
                found[key] = Claim(
                    str(data["claim"]),
                    str(data.get("says", "")),
                    str(data.get("source", "")),
                    str(data.get("claim_verdict", UNCHECKED)),
                    bounds_of(data),
                    path,
                )
            found[key].groups.append(group_of(data))
    return list(found.values())


def verdict_counts(claims: list[Claim]) -> Counter[str]:
    return Counter(claim.verdict for claim in claims)
