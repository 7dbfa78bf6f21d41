"""The first page: leaderboards with their menus, and lists of data sets, codecs and runs."""

from __future__ import annotations

import json
from typing import Any

from markupsafe import Markup

import look
import provenance
import tables
from figures.figure import groups
from pages import board as boards
from pages.board import Board, Question
from pages.frame import KIND_TITLES, Site
from pages.measured import YARDSTICK, Clock
from summary import PLAIN_ARRAY, count
from tables import Cell, Table

FLOORS = (30, 40, 50, 60)  # dB, of the menu that asks for a least PSNR


def write_index(site: Site) -> None:
    measured = site.measured
    rows = measured.results.runs
    times = sorted(filter(None, (row.text("provenance/time") for row in rows)))
    codecs = [codec for codec in measured.codec_pages]
    site.page(
        "index.html",
        "index.html.j2",
        ("table.js", "board.js"),
        heading=site.title,
        codecs=len(codecs),
        volumes=sum(any(row.ok for row in v.rows) for v in measured.volumes.values()),
        machines=[site.machine_name(machine) for machine in measured.results.machines],
        cells=len(measured.rows),
        without=sum(not row.ok for row in measured.rows),
        first=times[0][:10] if times else "",
        last=times[-1][:10] if times else "",
        clocks=[site.clock_name(clock) for clock in [*site.clocks, None]],
        boards=[shown_board(site, one) for one in site.boards],
        floors=FLOORS,
        data=data(site),
        conflicts=site.conflicts_table(measured.conflicts, ""),
        runs=runs_table(site),
        volumes_table=volumes_table(site),
        codecs_table=codecs_table(site),
        failures=tables.failures(measured.rows),
    )


def columns(site: Site, kind: str) -> int:
    return len(boards.COLUMNS) - (kind == "labels")


def shown_board(site: Site, one: Board) -> dict[str, Any]:
    """As the page shows it before any menu is touched."""
    part = one.views[0].parts[0]
    labels = {volume.page: volume.label for volume in site.measured.volumes.values()}
    return {
        "kind": one.kind,
        "title": KIND_TITLES[one.kind],
        "part": part,
        "volumes": "; ".join(labels[page] for page in part.volumes),
        "columns": boards.COLUMNS[: columns(site, one.kind)],
        "lines": [
            {
                "codec": line.codec,
                "page": site.codec_page(line.codec),
                "rest": line.setting[len(line.codec) :].strip(),
                "access": site.access(line.codec),
                "cells": line.cells[: columns(site, one.kind)],
            }
            for line in boards.best_settings(part.lines, boards.QUESTIONS[0])
        ],
        "answers": [(q.name, answer(site, part.lines, q)) for q in boards.QUESTIONS],
        "accesses": list(
            dict.fromkeys(
                filter(
                    None,
                    (
                        site.access(line.codec)
                        for view in one.views
                        for p in view.parts
                        for line in p.lines
                    ),
                )
            )
        ),
    }


def answer(site: Site, lines: list[boards.Line], question: Question) -> tuple[str, str]:
    """The best codec but the plain array, and its figure."""
    for line in boards.in_order(lines, question):
        cell = line.cells[question.column]
        if line.codec != PLAIN_ARRAY and cell.sort is not None:
            error = line.cells[boards.PSNR].text
            loss = f", {error} dB" if error and error != "exact" else ""
            return line.codec, f"{cell.text} {question.unit}{loss}"
    return "", "not measured"


def data(site: Site) -> Markup:
    """What the menus choose from, as JSON that may stand in a script element."""
    codecs = sorted(site.measured.codec_pages, key=look.codec_order)
    at = {codec: place for place, codec in enumerate(codecs)}
    labels = {volume.page: volume.label for volume in site.measured.volumes.values()}
    clocks: list[Clock | None] = [*site.clocks, None]

    def cells(line: boards.Line, kind: str) -> list[list[Any]]:
        found = []
        for cell in line.cells[: columns(site, kind)]:
            words: list[Any] = [cell.text, cell.sort, cell.detail, cell.href]
            while words and not words[-1] and words[-1] != 0:
                words.pop()
            found.append(words)
        return found

    told = {
        "codecs": [[codec, site.codec_page(codec), site.access(codec)] for codec in codecs],
        "plain": PLAIN_ARRAY,
        "rate": boards.RATE,
        "psnr": boards.PSNR,
        "questions": [[q.name, q.column, q.smaller, q.unit] for q in boards.QUESTIONS],
        "boards": [
            [
                {
                    "clock": clocks.index(view.clock),
                    "parts": [
                        {
                            "title": part.title,
                            "volumes": "; ".join(labels[page] for page in part.volumes),
                            "pages": part.volumes,
                            "left": part.left_out,
                            "lines": [
                                [
                                    at[line.codec],
                                    line.setting[len(line.codec) :].strip(),
                                    cells(line, one.kind),
                                ]
                                for line in part.lines
                            ],
                        }
                        for part in view.parts
                    ],
                }
                for view in one.views
            ]
            for one in site.boards
        ],
    }
    text = json.dumps(told, ensure_ascii=True, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


def runs_table(site: Site) -> Table:
    """A line for each results folder and machine."""
    lines = []
    results = site.measured.results
    for source in results.sources:
        own = [row for row in results.runs if row.folder == source.folder]
        for machine, rows in groups(own, lambda row: row.machine).items():
            facts = dict(provenance.facts(rows))
            stamps = sorted(filter(None, (row.text("provenance/time") for row in rows)))
            ok = sum(row.ok for row in rows)
            lines.append(
                [
                    Cell(source.folder.resolve().name),
                    Cell(site.machine_name(machine)),
                    Cell(tables.names(row.device for row in rows)),
                    Cell(facts.get("Revisions", "")),
                    Cell(stamps[0][:10] if stamps else ""),
                    Cell(str(len(rows)), len(rows)),
                    Cell(str(ok), ok),
                    Cell(", ".join(map(str, source.unreadable[:8]))),
                ]
            )
    return Table(
        "The runs",
        ["run", "machine", "device that drew", "revision", "date", "cells", "ok", "torn lines"],
        lines,
        2,
        [
            f"{count(results.superseded, 'row')} of cells that were measured again on the same machine: the later row counts."
        ]
        if results.superseded
        else [],
    )


def volumes_table(site: Site) -> Table:
    lines = []
    for volume in sorted(site.measured.volumes.values(), key=lambda one: one.label):
        row = volume.any_row
        codecs = {key[0] for key in volume.settings} - {YARDSTICK}
        without = sum(not one.ok for one in volume.rows)
        lines.append(
            [
                Cell(volume.label, href=f"dataset/{volume.page}.html"),
                Cell(volume.kind),
                Cell(row.text("dataset/type")),
                Cell(row.text("dataset/title"), detail=row.text("dataset/label")),
                Cell(str(len(codecs)), len(codecs)),
                Cell(str(len(volume.settings)), len(volume.settings)),
                Cell(str(without), without),
            ]
        )
    return Table(
        "Data sets",
        ["data set", "kind", "type", "what", "codecs", "settings", "cells without result"],
        lines,
    )


def codecs_table(site: Site) -> Table:
    lines = []
    for codec in sorted(site.measured.codec_pages, key=look.codec_order):
        listed = site.measured.listed.get(codec)
        own = [v for v in site.measured.volumes.values() if any(k[0] == codec for k in v.settings)]
        lossless = listed.entry.get("lossless") if listed else None
        lines.append(
            [
                Cell(codec, href=site.codec_page(codec)),
                Cell(listed.text("summary") if listed else ""),
                Cell(site.access(codec)),
                Cell({True: "lossless", False: "lossy"}.get(lossless, "")),
                Cell(str(len(own)), len(own)),
            ]
        )
    return Table("Codecs", ["codec", "what", "access", "loss", "data sets"], lines)
