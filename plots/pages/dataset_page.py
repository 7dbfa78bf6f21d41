"""The page of a data set: every codec on it, figures, frames, cells without a result."""

from __future__ import annotations

from typing import Any

import tables
from figures import rate_access, rate_distortion, rate_speed
from figures.figure import Figure
from pages.details import (
    cells_of,
    drawn_figure,
    images_of,
    in_order,
    narrowed,
    titled,
    with_codec_links,
)
from pages.frame import Site
from pages.measured import Volume
from rows import Row
from tables import whole


def write_dataset(site: Site, volume: Volume) -> None:
    measured = site.measured
    counted = {id(row) for row in measured.rows}
    rows = [row for row in volume.rows if id(row) in counted]
    parts = []
    for machine in measured.results.machines:
        own = in_order([row for row in rows if row.machine == machine])
        if own:
            parts.append(dataset_part(site, volume, machine, own, len(parts)))
    row = volume.any_row
    facts = [
        ("Title", row.text("dataset/title")),
        ("Not the original", row.text("dataset/label")),
        ("Extent", row.extent),
        ("Type", row.text("dataset/type")),
        ("Kind", volume.kind),
        ("Voxels", whole(row.number("dataset/voxels")).text),
        ("Labels", whole(row.number("dataset/labels")).text),
        ("Hash of the voxels", row.text("dataset/content_hash")),
        ("Identity", row.text("dataset/identity")),
    ]
    conflicts = [one for one in measured.conflicts if one.volume is volume]
    site.page(
        f"dataset/{volume.page}.html",
        "dataset.html.j2",
        ("table.js",),
        heading=volume.label,
        facts=[(name, value) for name, value in facts if value],
        page=volume.page,
        number=len(volume.rows),
        conflicts=site.conflicts_table(conflicts, "../"),
        parts=parts,
        failures=tables.failures(rows),
    )


def dataset_part(
    site, volume: Volume, machine: str, rows: list[Row], number: int
) -> dict[str, Any]:
    """What one machine measured of a volume."""
    table = cells_of(site, rows, "Every codec on this data set", leave_out=0)
    decoding = [row for row in rows if row.stage == "decode"]
    chosen: list[tuple[Figure, list[Row]]] = [
        (titled(rate_speed.FIGURE, "Rate against decoding speed"), decoding),
        (rate_access.FIGURE, rows),
        (rate_distortion.FIGURE, rows),
    ]
    drawn = [drawn_figure(site, one, own, f"m{number}") for one, own in chosen]
    return {
        "title": site.machine_name(machine),
        "id": f"machine-{number + 1}",
        "tables": [
            *([table] if table else []),
            *(with_codec_links(site, narrowed(one, 0), 0) for one in images_of(site, rows)),
        ],
        "figures": list(filter(None, drawn)),
    }
