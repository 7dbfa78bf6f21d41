#!/usr/bin/env python3
"""The figures of a run of results/evidence, for the page that Markdown shows of it.

    evidence_figures.py RUN FOLDER     writes FOLDER/FIGURE.svg, one for each figure that has a panel

Of each figure the first panel, as an SVG that follows the reader's light or dark scheme. scripts/evidence
calls it; the pages show what lies in FOLDER. Equal rows give equal bytes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import codec_list
import look
from figures import REGISTRY
from rows import load

STYLE = (
    "<style>svg { color: #1b1d20 } "
    "@media (prefers-color-scheme: dark) { svg { color: #e6e7e9 } }</style>"
)


def main(run: Path, folder: Path) -> int:
    results = load([run])
    look.use_codecs(codec_list.listed([run], ""), (row.codec for row in results.rows))
    rows = [row for row in results.rows if row.ok]
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.svg"):
        old.unlink()
    for figure in REGISTRY:
        for panel in figure.draw(rows)[:1]:
            label = f"{figure.title}: {panel.title}"
            svg = look.to_svg(panel.drawing, figure.name, label, panel.description)
            opening = svg.index(">") + 1
            svg = svg[:opening] + STYLE + svg[opening:]
            (folder / f"{figure.name}.svg").write_text(svg.strip() + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
