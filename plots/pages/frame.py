"""What all pages of a site share: its frame, names and addresses."""

from __future__ import annotations

import base64
import hashlib
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

import provenance
import tables
from pages import board as boards
from pages.folder import SiteFolder
from pages.measured import Clock, Conflict, Measured
from rows import Row
from summary import count
from tables import Cell, Table

HERE = Path(__file__).resolve().parent
PLOTS = HERE.parent
KIND_TITLES = {"labels": "Label volumes", "scalars": "Scalar volumes"}


class Site:
    """Renders pages into a folder."""

    def __init__(self, measured: Measured, title: str, folder: SiteFolder) -> None:
        self.measured = measured
        self.title = title
        self.folder = folder
        self.clocks = measured.clocks(measured.rows)
        self.boards = boards.boards(measured, self.clocks)
        self.environment = jinja2.Environment(
            loader=jinja2.FileSystemLoader([HERE, PLOTS]),
            autoescape=True,
            trim_blocks=True,
            lstrip_blocks=True,
            undefined=jinja2.StrictUndefined,
        )
        style = [PLOTS / "style.css", HERE / "site.css"]
        self.style = Markup("".join(path.read_text(encoding="utf-8") for path in style))
        self.scripts = {
            name: (PLOTS / name if name == "table.js" else HERE / name).read_text(encoding="utf-8")
            for name in ("table.js", "board.js")
        }

    def page(self, name: str, template: str, script: tuple[str, ...], **values: Any) -> None:
        text = "\n" + "".join(self.scripts[one] for one in script)
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        page = self.environment.get_template(template).render(
            site=self.title,
            root="../" if "/" in name else "",
            style=self.style,
            script=Markup(text) if script else "",
            digest=digest,
            **values,
        )
        self.folder.write(name, page.strip() + "\n")

    def machine_name(self, machine: str) -> str:
        rows = self.measured.results.of(machine)
        return provenance.machine_title(rows, machine) if rows else machine

    def clock_name(self, clock: Clock | None) -> str:
        if clock is None:
            return "none: exact figures of all machines"
        return f"{count(clock.threads, 'thread')} of {self.machine_name(clock.machine)}"

    def codec_page(self, codec: str) -> str:
        page = self.measured.codec_pages.get(codec)
        return f"codec/{page}.html" if page else ""

    def access(self, codec: str) -> str:
        """What it decodes at once, as the list of codecs says it."""
        listed = self.measured.listed.get(codec)
        return listed.text("access") if listed else ""

    def link(self, row: Row) -> str:
        return "../" + self.measured.row_address(row)

    def conflicts_table(self, found: list[Conflict], root: str) -> Table | None:
        """Exact figures that runs do not agree about."""
        lines = []
        for one in found:
            setting = (
                self.measured.setting_label(one.setting) if one.setting else "the volume itself"
            )
            for value, rows in one.stated:
                row = rows[0]
                lines.append(
                    [
                        Cell(one.volume.label, href=f"{root}dataset/{one.volume.page}.html"),
                        Cell(setting),
                        Cell(one.name),
                        Cell(value, href=root + self.measured.row_address(row)),
                        Cell(str(len(rows)), len(rows)),
                        Cell(tables.names(r.folder.resolve().name for r in rows)),
                        Cell(tables.names(r.text("provenance/revision") for r in rows)),
                        Cell(tables.names(self.machine_name(r.machine) for r in rows)),
                    ]
                )
        headings = [
            "data set",
            "setting",
            "figure",
            "stated",
            "rows",
            "runs",
            "revisions",
            "machines",
        ]
        return (
            Table("Exact figures that runs disagree about", headings, lines, 3) if lines else None
        )
