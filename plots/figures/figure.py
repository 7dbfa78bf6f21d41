"""What a figure is: a name, words, and a function from rows of one machine to panels."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from matplotlib.figure import Figure as Drawing

from estimates import Estimate
from rows import Row

T = TypeVar("T")


@dataclass
class Panel:
    """One drawing of 3.3 inches. `name` is part of file names, unique within the figure; `points`:
    how many values it shows.
    """

    name: str
    title: str
    drawing: Drawing
    description: str
    points: int
    note: str = ""


@dataclass(frozen=True)
class Figure:
    """`section`: heading of the page that it stands under. `needs`: what is missing where there is
    no panel, and the run that fills it.
    """

    name: str
    section: str
    title: str
    caption: str
    needs: str
    draw: Callable[[list[Row]], list[Panel]]


def groups(rows: Iterable[T], key: Callable[[T], object]) -> dict:
    """Rows by key, keys in the order in which they come."""
    found: dict = {}
    for row in rows:
        found.setdefault(key(row), []).append(row)
    return found


def of_stage(rows: Iterable[Row], *stages: str) -> list[Row]:
    """Rows that are ok, of stages, without the yardstick memcpy."""
    return [row for row in rows if row.ok and row.stage in stages and row.codec != "memcpy"]


def positive(found: Estimate | None) -> bool:
    """Whether a logarithmic axis can show it."""
    return found is not None and found.value > 0


def file_name(text: str) -> str:
    """Letters, digits and hyphens."""
    kept = "".join(c if c.isalnum() and c.isascii() else "-" for c in text.lower())
    while "--" in kept:
        kept = kept.replace("--", "-")
    return kept.strip("-")
