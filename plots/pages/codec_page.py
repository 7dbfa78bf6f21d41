"""The page of a codec: what it is, where it stands, what was measured, and what its parameters
change.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import look
import tables
from figures import rate_access, rate_distortion, rate_speed
from figures.figure import groups
from pages.details import cells_of, drawn_figure, images_of, in_order, titled
from pages.frame import KIND_TITLES, Site
from pages.standing import standing_tables
from rows import Row
from tables import Cell, Table

MOST_SWEEPS = 2  # panels


def write_codec(site: Site, codec: str) -> None:
    measured = site.measured
    listed = measured.listed.get(codec)
    rows = [row for row in measured.rows if row.codec == codec]
    names = {volume.page: volume.label for volume in measured.volumes.values()}
    standing = []
    for one in site.boards:
        for view, table in standing_tables(one, codec, names):
            table.caption = (
                f"{KIND_TITLES[one.kind]}; times: {site.clock_name(one.views[view].clock)}"
            )
            if one.views[view].clock is not None:
                standing.append(table)
    parts = []
    for machine in measured.results.machines:
        own = in_order([row for row in rows if row.machine == machine])
        if not own:
            continue
        table = cells_of(site, own, "Every data set and setting", leave_out=None)
        for line in table.lines if table else []:
            line[0].href = ""
        parts.append(
            {
                "title": site.machine_name(machine),
                "id": f"machine-{len(parts) + 1}",
                "tables": [*([table] if table else []), *images_of(site, own)],
                "figures": sweeps(site, own, len(parts)),
            }
        )
    conflicts = [one for one in measured.conflicts if one.setting and one.setting[0] == codec]
    site.page(
        site.codec_page(codec),
        "codec.html.j2",
        ("table.js",),
        heading=codec,
        listed=listed,
        facts=codec_facts(listed.entry) if listed else [],
        parameters=parameters_table(listed.parameters, rows) if listed else None,
        conflicts=site.conflicts_table(conflicts, "../"),
        standing=standing,
        parts=parts,
        failures=tables.failures(rows),
    )


def sweeps(site: Site, rows: list[Row], number: int) -> list[dict[str, Any]]:
    """What changes with the parameters, on the volumes with the most settings."""
    settings = {
        volume: len({tuple(sorted(row.parameters.items())) for row in own if row.ok})
        for volume, own in groups(rows, lambda row: row.volume).items()
    }
    widest = [v for v in sorted(settings, key=lambda one: (-settings[one], one)) if settings[v] > 1]
    found = []
    for at, volume in enumerate(widest[:MOST_SWEEPS]):
        own = [row for row in rows if row.volume == volume]
        encoding = [row for row in own if row.stage == "encode"]
        for figure, used in (
            (rate_distortion.FIGURE, own),
            (rate_access.FIGURE, own),
            (titled(rate_speed.FIGURE, "Rate against encoding speed"), encoding),
        ):
            drawn = drawn_figure(site, figure, used, f"m{number}-{at}")
            if drawn:
                found.append(drawn)
                break
    return found


def codec_facts(entry: dict[str, Any]) -> list[tuple[str, str]]:
    """Traits of the list of codecs in words."""
    types = entry.get("types")
    yes = [
        words
        for name, words in (
            ("levels_of_detail", "levels of detail"),
            ("gpu_decodable", "labels are drawn from it on a GPU"),
            ("gpu_scalars", "scalars are drawn from it on a GPU"),
        )
        if entry.get(name) is True
    ]
    lossless = {True: "lossless", False: "lossy"}.get(entry.get("lossless"), "")
    facts = [
        ("Loss", lossless),
        ("Access", str(entry.get("access", ""))),
        ("Types", ", ".join(map(str, types)) if isinstance(types, list) else ""),
        ("Can", ", ".join(yes)),
        ("Family", str(entry.get("family", ""))),
        ("Version of the format", str(entry.get("version", ""))),
    ]
    return [(name, value) for name, value in facts if value]


def parameters_table(parameters: list[dict[str, str]], rows: list[Row]) -> Table | None:
    """With the values that were measured."""
    measured = Counter((n, v) for row in rows for n, v in row.parameters.items())
    lines = []
    for one in parameters:
        name = one.get("name", "")
        values = sorted(
            {v for n, v in measured if n == name}, key=lambda v: (look.leading_numbers(v), v)
        )
        lines.append(
            [Cell(name), Cell(one.get("description", ""))]
            + [Cell(one.get(key, "")) for key in ("range", "default")]
            + [Cell(", ".join(values[:40]))]
        )
    headings = ["parameter", "what", "range", "default", "measured"]
    return Table("Parameters", headings, lines, 5) if lines else None
