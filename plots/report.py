#!/usr/bin/env python3
"""Makes one self-contained HTML page of results folders; `cvrbench report` calls it.

    report.py --results DIR [--results DIR ...] -o report.html [--figures DIR] [--title TEXT]
              [--program CVRBENCH --store DIR]

The page loads nothing from anywhere. Equal results give equal bytes. Exit codes: 0 ok, 1 where no
row is ok, 2 usage or input, 3 environment.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

import codec_list
import history
import images
import look
import provenance
import remarks
import summary
import tables
from claims import FAILS, HOLDS, UNCHECKED, UNDECIDED, Claim, read_claims
from figures import REGISTRY
from panels import draw_figure
from rows import Results, Row, Unreadable, load
from tables import Cell, Table

HERE = Path(__file__).resolve().parent
MOST_OPEN = 12  # panels of a figure that are not folded
EXIT_OK, EXIT_NOTHING, EXIT_USAGE, EXIT_ENVIRONMENT = 0, 1, 2, 3


def claim_groups(claims: Sequence[Claim]) -> Table:
    lines = [
        [
            Cell(claim.name),
            Cell(group.label),
            Cell(group.verdict + (", fitted" if group.fitted else "")),
            Cell(group.reason),
        ]
        for claim in claims
        for group in claim.groups
    ]
    return Table("Groups of claims", ["claim", "group", "verdict", "figures"], lines, 2)


def figure_sections(
    machines: list[tuple[str, str, list[Row]]], folder: Path | None
) -> list[dict[str, Any]]:
    """Figures under their headings, in the order of the registry."""
    sections: dict[str, list[dict[str, Any]]] = {}
    for figure in REGISTRY:
        sections.setdefault(figure.section, []).append(draw_figure(figure, machines, folder))
    return [
        {"id": name.lower().replace(" ", "-"), "name": name, "figures": drawn}
        for name, drawn in sections.items()
    ]


def machine_part(
    machine: str, title: str, rows: list[Row], claims: list[Claim], steps: list[dict[str, Any]]
) -> dict[str, Any]:
    """What the page says of one machine."""
    shown, note = images.collect(rows)
    found = summary.findings(rows, claims)
    failures = tables.failures(rows)
    cells = [failures, tables.voxel_cells(rows), tables.image_cells(rows)]
    origins = [provenance.volumes_table(rows), provenance.versions_table(rows)]
    return {
        "title": title,
        "run": remarks.what_was_run(rows),
        "findings": found,
        "unanswered": summary.unanswered(found),
        "stands_out": remarks.stands_out(rows),
        "failures": failures,
        "tables": [table for table in cells if table is not None],
        "images": shown,
        "images_note": note,
        "steps": history.steps_table(steps, machine),
        "facts": provenance.facts(rows),
        "provenance_tables": [table for table in origins if table is not None],
    }


def short_answers(parts: Sequence[dict[str, Any]]) -> list[str]:
    """A table of each machine's questions and answers, for the terminal."""
    lines = []
    for part in parts:
        asked = [(finding.question, finding.headline) for finding in part["findings"]]
        if not asked:
            continue
        if len(parts) > 1:
            lines += [part["title"], ""]
        widths = [max(len(texts[side]) for texts in asked) for side in (0, 1)]
        lines += [
            f"| {question:{widths[0]}} | {answer:{widths[1]}} |" for question, answer in asked
        ]
        lines[-len(asked) : -len(asked)] = [
            f"| {'question':{widths[0]}} | {'answer':{widths[1]}} |",
            f"|:{'-' * (widths[0] + 1)}|:{'-' * (widths[1] + 1)}|",
        ]
        lines.append("")
    return lines


def ask_history(program: str, store: Path | None) -> tuple[list[dict[str, Any]], str]:
    """Steps, and what to say where there are none."""
    if not program or store is None or not store.is_dir():
        return (
            [],
            "No history is kept here. `cvrbench history add DIR` after each run begins one; steps in its figures then stand here.",
        )
    try:
        return (
            history.ask(program, store),
            f"The history in {store} has no step on the machines of this report.",
        )
    except (OSError, history.subprocess.SubprocessError) as error:
        return [], f"The history in {store} could not be read: {error}"


def home(claim: Claim, machines: list[tuple[str, str, list[Row]]]) -> str:
    """The machine that most rows of the claim's folder are of."""
    folder = claim.file.parent.parent
    return max(
        machines, key=lambda one: sum(row.folder == folder for row in one[2]), default=("", "", [])
    )[0]


def in_order(rows: list[Row]) -> list[Row]:
    """Volumes as they were measured, within each the codecs in a fixed order: rounds are
    interleaved, so rows come in any.
    """
    volumes = {volume: at for at, volume in enumerate(dict.fromkeys(row.volume for row in rows))}
    return sorted(rows, key=lambda row: (volumes[row.volume], look.row_order(row)))


def build_page(
    results: Results,
    folders: Sequence[Path],
    title: str,
    figures: Path | None,
    steps: list[dict[str, Any]],
    history_note: str,
) -> tuple[str, list[str]]:
    """The whole page, and its answers in short; codecs look as `look.use_codecs` was told."""
    machines = [
        (machine, provenance.machine_title(rows, machine), rows)
        for machine in results.machines
        if (rows := in_order(results.of(machine)))
    ]
    claims = [claim for folder in folders for claim in read_claims(folder)]
    parts = [
        machine_part(
            machine,
            name,
            rows,
            [claim for claim in claims if home(claim, machines) == machine],
            steps,
        )
        for machine, name, rows in machines
    ]
    drawn = figure_sections(machines, figures)
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    sections = [
        ("summary", "Summary"),
        ("claims", "Claims"),
        ("tables", "Tables"),
        *((s["id"], s["name"]) for s in drawn),
        ("images", "Images"),
        ("cells", "All cells"),
        ("history", "History"),
        ("provenance", "Provenance"),
    ]
    page = environment.get_template("template.html.j2").render(
        title=title,
        parts=parts,
        several=len(parts) > 1,
        sections=sections,
        claims=claims,
        claim_groups=claim_groups(claims),
        claims_sentence=summary.claims_sentence(claims),
        verdicts=(HOLDS, FAILS, UNDECIDED, UNCHECKED),
        verdict_class={HOLDS: "holds", FAILS: "fails", UNDECIDED: "undecided"},
        config_tables=[table for folder in folders for table in tables.config_tables(folder)],
        figure_sections=drawn,
        most_open=MOST_OPEN,
        any_images=any(part["images"] for part in parts),
        any_steps=any(part["steps"] for part in parts),
        history_note=history_note,
        sources=provenance.sources_table(results),
        style=Markup((HERE / "style.css").read_text(encoding="utf-8")),
        script=Markup((HERE / "table.js").read_text(encoding="utf-8")),
    )
    return page.strip() + "\n", short_answers(parts)


def write_whole(path: Path, text: str) -> None:
    """Under a temporary name beside the file itself, then renamed: a symbolic link stays one."""
    path = path.resolve()
    unfinished = path.with_name(f"{path.name}.part{os.getpid()}")
    try:
        unfinished.write_text(text, encoding="utf-8")
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="One self-contained HTML page of results folders")
    parser.add_argument(
        "--results",
        type=Path,
        action="append",
        required=True,
        help="folder with rows.jsonl; may be repeated",
    )
    parser.add_argument("-o", "--output", type=Path, required=True, help="the page")
    parser.add_argument("--figures", type=Path, help="folder for each panel as PDF and SVG")
    parser.add_argument(
        "--title", default="Compressed volumes: size, speed and error", help="heading of the page"
    )
    parser.add_argument(
        "--program",
        default="",
        help="cvrbench, asked for the history, and for its codecs where no folder lists them",
    )
    parser.add_argument("--store", type=Path, help="folder of the history")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    choices = parse(arguments)
    signal.signal(
        signal.SIGTERM, lambda number, frame: sys.exit(128 + number)
    )  # leaves by way of `finally`, as Ctrl-C does
    for folder in choices.results:
        if not folder.is_dir():
            print(f"report.py: {folder}: expected a results folder, found none", file=sys.stderr)
            return EXIT_USAGE
    folders = list(dict.fromkeys(choices.results))
    try:
        if choices.figures is not None:
            choices.figures.mkdir(parents=True, exist_ok=True)
        steps, history_note = ask_history(choices.program, choices.store)
        results = load(folders)
        look.use_codecs(
            codec_list.listed(folders, choices.program), (row.codec for row in results.rows)
        )
        page, answers = build_page(
            results, folders, choices.title, choices.figures, steps, history_note
        )
        write_whole(choices.output, page)
        print("\n".join([*answers, f"Report: {choices.output}"]), flush=True)
    except Unreadable as error:
        print(f"report.py: {error}", file=sys.stderr)
        return EXIT_USAGE
    except OSError as error:
        print(f"report.py: {error}", file=sys.stderr)
        return EXIT_ENVIRONMENT
    except Exception:  # Python's own exit code for it is 1, which says that nothing was measured
        traceback.print_exc()
        return EXIT_ENVIRONMENT
    if not any(row.ok for row in results.rows):
        print(
            "report.py: nothing was measured: no row of these folders is ok, and the page says why",
            file=sys.stderr,
        )
        return EXIT_NOTHING
    return EXIT_OK


if __name__ == "__main__":
    sys.exit(main())
