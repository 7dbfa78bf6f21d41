"""Where rows come from: machine, build, devices, revisions, folders."""

from __future__ import annotations

from rows import Results, Row
from tables import Cell, Table, names


def machine_title(rows: list[Row], machine: str) -> str:
    """ "AMD EPYC, 2 cores, 24 GiB (5204f86cda42ec50)"."""
    row = rows[0]
    memory = row.number("provenance/memory_bytes")
    parts = [
        row.text("provenance/cpu", "unknown processor"),
        f"{row.number('provenance/cores') or 0:.0f} cores"
        if row.number("provenance/cores")
        else "",
        f"{memory / 2**30:.0f} GiB" if memory else "",
    ]
    return ", ".join(filter(None, parts)) + f" ({machine})"


def facts(rows: list[Row]) -> list[tuple[str, str]]:
    """Names and values, of several values all."""

    def all_of(path: str) -> str:
        return names(row.text(path) for row in rows)

    times = sorted(filter(None, (row.text("provenance/time") for row in rows)))
    devices = names(
        f"{row.device} ({row.text('device/type')}; {row.text('device/driver')}; Vulkan {row.text('device/api')})"
        for row in rows
        if row.device
    )
    found = [
        ("Processor", all_of("provenance/cpu")),
        ("System", all_of("provenance/os")),
        ("Kernel", all_of("provenance/kernel")),
        ("Devices that drew", devices),
        ("Harness", all_of("provenance/harness")),
        ("Revisions", all_of("provenance/revision")),
        ("Compiler", all_of("provenance/compiler")),
        ("Flags", all_of("provenance/flags")),
        ("Build type", all_of("provenance/build_type")),
        ("Configurations (hash)", all_of("provenance/config_hash")),
        ("Measured", f"{times[0]} to {times[-1]}" if times else ""),
    ]
    return [(name, value) for name, value in found if value]


def sources_table(results: Results) -> Table:
    """A line for each results folder."""
    lines = []
    for source in results.sources:
        torn = source.unreadable
        left_out = (
            f"left out: line{'s' * (len(torn) > 1)} {', '.join(map(str, torn[:8]))}{' ..' if len(torn) > 8 else ''}"
            if torn
            else ""
        )
        note = "; ".join(filter(None, (source.note, left_out)))
        lines.append(
            [
                Cell(str(source.folder)),
                Cell(str(source.rows), source.rows),
                Cell(str(len(torn)), len(torn)),
                Cell(note),
            ]
        )
    notes = (
        [
            f"{results.superseded} rows are not shown: later rows are of the same cell on the same machine."
        ]
        if results.superseded
        else []
    )
    return Table("Results folders", ["folder", "rows", "unreadable lines", "note"], lines, 1, notes)


def volumes_table(rows: list[Row]) -> Table | None:
    """A line for each volume."""
    seen: dict[str, Row] = {}
    for row in rows:
        if row.extent:
            seen.setdefault(row.volume, row)
    if not seen:
        return None
    lines = [
        [
            Cell(row.dataset),
            Cell(row.text("dataset/title")),
            Cell(row.extent),
            Cell(row.text("dataset/type")),
            Cell(row.text("dataset/label")),
            Cell(row.text("dataset/content_hash")),
        ]
        for row in seen.values()
    ]
    return Table(
        "Volumes",
        ["data set", "title", "extent", "type", "not the original", "hash of the voxels"],
        lines,
        1,
    )


def versions_table(rows: list[Row]) -> Table | None:
    found = sorted({(row.codec, str(row.get("codec/version", ""))) for row in rows})
    return (
        Table(
            "Codecs and the versions of their formats",
            ["codec", "version"],
            [[Cell(codec), Cell(version)] for codec, version in found],
            1,
        )
        if found
        else None
    )
