"""File names of pages, and where links lead.

A name is made of letters, digits and hyphens only, whatever the rows hold. Where the names of two
things would meet, each gets a hash of what it stands for.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable

from figures.figure import file_name

LONGEST = 60
HASH_DIGITS = 10


def safe_name(text: str) -> str:
    return file_name(text[: 4 * LONGEST])[:LONGEST].strip("-") or "unnamed"


def hashed(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", errors="replace")).hexdigest()[:HASH_DIGITS]


def safe_names(texts: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Of pairs of identity and text the name of each identity; identities are distinct."""
    pairs = sorted(set(texts))
    met = Counter(safe_name(text) for _, text in pairs)
    names = {
        identity: safe_name(text)
        if met[safe_name(text)] == 1
        else safe_name(text) + "-" + hashed(identity)
        for identity, text in pairs
    }
    again = Counter(names.values())  # a text may look like another's name with its hash
    return {
        identity: name
        if again[name] == 1
        else "x-" + hashlib.sha256(identity.encode("utf-8", errors="replace")).hexdigest()
        for identity, name in names.items()
    }
