"""Where a codec stands on each volume: its places among all codecs, and whether one of its settings
is on the front, that is, whether no other is better in one of two figures and at least as good in
the other.
"""

from __future__ import annotations

from pages.board import (
    ACCESS,
    DECODE,
    ENCODE,
    PSNR,
    QUESTIONS,
    RATE,
    Board,
    Line,
    Part,
    best_settings,
)
from tables import Cell, Table

FRONTS = {
    "labels": ((DECODE, "front of rate and decode"), (ACCESS, "front of rate and one voxel")),
    "scalars": ((PSNR, "front of rate and PSNR"),),
}
LARGER_IS_BETTER = {ENCODE, DECODE, PSNR}


def standing_tables(board: Board, codec: str, names: dict[str, str]) -> list[tuple[int, Table]]:
    """Numbers of views and tables; `names`: labels of volumes by their pages."""
    found = []
    for number, view in enumerate(board.views):
        lines = [
            places(part, board.kind, codec, names)
            for part in view.parts[1:]
            if any(line.codec == codec for line in part.lines)
        ]
        if lines:
            headings = ["data set", *(question.name.lower() for question in QUESTIONS)]
            headings += [name for _, name in FRONTS[board.kind]]
            found.append((number, Table("", headings, lines, 1)))
    return found


def places(part: Part, kind: str, codec: str, names: dict[str, str]) -> list[Cell]:
    page = part.volumes[0]
    cells = [Cell(names[page], None, href=f"../dataset/{page}.html")]
    for question in QUESTIONS:
        ranked = [
            line
            for line in best_settings(part.lines, question)
            if line.cells[question.column].sort is not None
        ]
        values = [line.cells[question.column].sort for line in ranked]
        own = next((v for line, v in zip(ranked, values) if line.codec == codec), None)
        place = values.index(own) + 1 if own is not None else None
        cells.append(Cell(f"{place} of {len(ranked)}", place) if place else Cell(""))
    for column, _ in FRONTS[kind]:
        usable = [line for line in part.lines if line.codec == codec and both(line, column)]
        if not usable:
            cells.append(Cell(""))
            continue
        on = [line for line in usable if not any(beats(o, line, column) for o in part.lines)]
        words = ", ".join(dict.fromkeys(line.setting for line in on))
        cells.append(Cell("yes" if on else "no", None, words if words != codec else ""))
    return cells


def both(line: Line, column: int) -> tuple[float, float] | None:
    """Rate and another figure, smaller is better."""
    rate, other = line.cells[RATE].sort, line.cells[column].sort
    if rate is None or other is None:
        return None
    return rate, -other if column in LARGER_IS_BETTER else other


def beats(one: Line, other: Line, column: int) -> bool:
    a, b = both(one, column), both(other, column)
    return a is not None and b is not None and a != b and a[0] <= b[0] and a[1] <= b[1]
