"""Figures as pages show them: their panels as SVG for each machine, and as files of their own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from markupsafe import Markup

import look
from figures.figure import Figure
from rows import Row


def draw_figure(
    figure: Figure, machines: list[tuple[str, str, list[Row]]], folder: Path | None
) -> dict[str, Any]:
    """The panels of a figure for each machine that has any, as SVG; with a folder also as files of
    their own.
    """
    drawn = []
    for number, (_, title, rows) in enumerate(machines, 1):
        panels = []
        stems: set[str] = set()
        for panel in figure.draw(rows):
            stem = f"{figure.name}-{panel.name}" + (
                f"-machine{number}" if len(machines) > 1 else ""
            )
            while stem in stems:
                stem += "-again"
            stems.add(stem)
            identity = f"figure-{stem}-m{number}"
            svg = look.to_svg(
                panel.drawing, identity, f"{figure.title}: {panel.title}", panel.description
            )
            if folder is not None:
                look.write_files(panel.drawing, folder / stem)
            panels.append(
                {
                    "id": identity,
                    "svg": Markup(svg),
                    "title": panel.title,
                    "note": panel.note,
                    "points": panel.points,
                }
            )
        if panels:
            drawn.append({"title": title, "panels": panels})
    return {
        "name": figure.name,
        "title": figure.title,
        "caption": figure.caption,
        "needs": figure.needs,
        "machines": drawn,
    }
