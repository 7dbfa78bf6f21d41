"""What several runs measured, joined: volumes, settings of codecs, exact figures, times.

A volume is a data set, an extent and what identifies its voxels; a setting is a codec, the version
of its format and all parameters. Sizes and errors of a setting on a volume are exact: every run,
stage, machine and thread count must state the same. Where two of them differ, the figure is a
conflict, and is used for nothing. Times belong to one machine and one number of threads.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import estimates as e
from codec_list import Codec
from figures.figure import groups
from pages.addresses import safe_name, safe_names
from rows import Results, Row, finite, varying_parameters

YARDSTICK = "memcpy"
DIGITS = 12  # to which exact figures must agree: the last ones of a logarithm are the library's

VolumeKey = tuple[str, str, str]
SettingKey = tuple[str, str, tuple[tuple[str, str], ...]]


def volume_key(row: Row) -> VolumeKey:
    return row.dataset, row.extent, row.text("dataset/identity")


def setting_key(row: Row) -> SettingKey:
    return row.codec, str(row.get("codec/version", "")), tuple(sorted(row.parameters.items()))


def flat(value: Any, name: str) -> Iterable[tuple[str, Any]]:
    """Numbers and texts of an object and of the objects in it."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from flat(inner, f"{name}.{key}")
    elif isinstance(value, (bool, str)):
        yield name, value
    elif finite(value) is not None:
        yield name, float(f"{value:.{DIGITS}g}")


def exact_figures(row: Row) -> dict[str, Any]:
    found = dict(flat(row.get("size", {}), "size")) | dict(flat(row.get("error", {}), "error"))
    for name in ("voxels_compared", "mismatches"):
        found |= dict(flat(row.get(f"verification/{name}"), f"verification.{name}"))
    return found


@dataclass
class Conflict:
    """Rows by what they state of one exact figure; `setting` is None for the volume itself."""

    volume: Volume
    setting: SettingKey | None
    name: str
    stated: list[tuple[str, list[Row]]]


@dataclass
class Setting:
    """On one volume. `rows`: those that count; `torn`: names of exact figures in conflict."""

    key: SettingKey
    rows: list[Row]
    torn: set[str] = field(default_factory=set)

    def row(self, stage: str, machine: str, threads: int) -> Row | None:
        """The row of a stage that knows no images."""
        for row in self.rows:
            if (row.stage, row.machine, row.threads) == (stage, machine, threads) and row.ok:
                return row
        return None

    @property
    def sized(self) -> Row | None:
        """A row that states rate and error, where no two runs state different ones."""
        if {"size.bytes", "size.rate"} & self.torn:
            return None
        return next((row for row in self.rows if row.ok and e.rate(row)), None)

    @property
    def error_known(self) -> bool:
        return not any(name.startswith(("error.", "verification.mismatches")) for name in self.torn)

    @property
    def exact(self) -> bool:
        return self.error_known and any(e.is_exact(row) for row in self.rows)

    @property
    def psnr(self) -> float | None:
        """Of a lossy one."""
        row = next((r for r in self.rows if r.ok and r.number("error/psnr_db") is not None), None)
        return row.number("error/psnr_db") if row is not None and self.error_known else None


@dataclass
class Volume:
    """`label`: as all pages call it; `page`: the name of its files."""

    key: VolumeKey
    rows: list[Row]
    label: str = ""
    page: str = ""
    settings: dict[SettingKey, Setting] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        return next(filter(None, (row.text("dataset/kind") for row in self.rows)), "")

    @property
    def any_row(self) -> Row:
        return next((row for row in self.rows if row.ok), self.rows[0])


@dataclass(frozen=True)
class Clock:
    """Whose times may stand in one column."""

    machine: str
    threads: int


@dataclass
class Measured:
    """Everything that pages are made of. `runs`: the rows that count of each run apart."""

    results: Results
    listed: dict[str, Codec]
    volumes: dict[VolumeKey, Volume]
    codec_pages: dict[str, str]
    shown: dict[str, set[str]]
    anchors: dict[int, str]
    conflicts: list[Conflict]

    @property
    def rows(self) -> list[Row]:
        return self.results.rows

    def volume(self, row: Row) -> Volume:
        return self.volumes[volume_key(row)]

    def label(self, row: Row) -> str:
        return self.setting_label(setting_key(row))

    def setting_label(self, key: SettingKey) -> str:
        """The codec, and the parameters that vary or are not the codec's own choice."""
        codec, version, parameters = key
        shown = self.shown.get(codec, set())
        words = [f"{name}={value}" for name, value in parameters if name in shown]
        if "version" in shown:
            words.insert(0, f"version {version}")
        return " ".join([codec, *words])

    def row_address(self, row: Row) -> str:
        """From the site's top."""
        return f"rows/{self.volume(row).page}.html#{self.anchors[id(row)]}"

    def clocks(self, rows: Iterable[Row]) -> list[Clock]:
        """Those that most rows are of come first."""
        found = groups(
            (r for r in rows if r.ok and r.stage in ("encode", "decode", "random-access")),
            lambda row: Clock(row.machine, row.threads),
        )
        return sorted(found, key=lambda one: (-len(found[one]), one.machine, one.threads))


def join(results: Results, codecs: Iterable[Codec]) -> Measured:
    listed = {codec.id: codec for codec in codecs}
    by_volume = groups(results.runs, volume_key)
    volumes = {key: Volume(key, rows) for key, rows in sorted(by_volume.items())}
    name_volumes(volumes)
    conflicts: list[Conflict] = []
    counted = {id(row) for row in results.rows}
    for volume in volumes.values():
        stated = groups((row for row in volume.rows if row.ok), setting_key)
        conflicts += content_conflicts(volume)
        for key, rows in stated.items():
            found = conflicts_of(volume, key, rows)
            conflicts += found
            setting = Setting(key, [row for row in rows if id(row) in counted])
            setting.torn = {one.name for one in found}
            volume.settings[key] = setting
    ids = {row.codec for row in results.runs} - {YARDSTICK}
    return Measured(
        results,
        listed,
        volumes,
        safe_names((codec, codec) for codec in ids),
        shown_parameters(results.runs, listed),
        {key: name for v in volumes.values() for key, name in anchors_of(v.rows).items()},
        conflicts,
    )


def name_volumes(volumes: dict[VolumeKey, Volume]) -> None:
    same = groups(volumes.values(), lambda one: one.rows[0].volume)
    for text, found in same.items():
        for volume in found:
            several = f" ({volume.key[2] or 'not identified'})" if len(found) > 1 else ""
            volume.label = text + several
    texts = {"\0".join(key): key for key in volumes}
    for identity, name in safe_names(
        (text, f"{key[0]} {'x'.join(key[1].split(' x '))}") for text, key in texts.items()
    ).items():
        volumes[texts[identity]].page = name


def anchors_of(rows: list[Row]) -> dict[int, str]:
    """The anchor of each row on its page: its cell, numbered where several rows are of it."""
    taken: set[str] = set()
    found = {}
    for row in rows:
        name = stem = "r-" + safe_name(row.text("cell") or "row")
        number = 1
        while name in taken:
            number += 1
            name = f"{stem}-{number}"
        taken.add(name)
        found[id(row)] = name
    return found


def shown_parameters(rows: list[Row], listed: dict[str, Codec]) -> dict[str, set[str]]:
    """Of each codec the parameters that tell settings apart or are not the default; "version" where
    its format has several.
    """
    shown = {codec: set(names) for codec, names in varying_parameters(rows).items()}
    versions: dict[str, set[str]] = {}
    for row in rows:
        versions.setdefault(row.codec, set()).add(setting_key(row)[1])
        codec = listed.get(row.codec)
        for one in codec.parameters if codec else []:
            name = one.get("name", "")
            if name in row.parameters and row.parameters[name] != one.get("default"):
                shown.setdefault(row.codec, set()).add(name)
    for codec, found in versions.items():
        if len(found) > 1:
            shown.setdefault(codec, set()).add("version")
    return shown


def disagreement(stated: Iterable[tuple[Any, Row]]) -> list[tuple[str, list[Row]]]:
    """Values with the rows that state them, where there are two or more values."""
    found = groups(stated, lambda one: one[0])
    if len(found) < 2:
        return []
    return [(str(value), [row for _, row in pairs]) for value, pairs in found.items()]


def conflicts_of(volume: Volume, key: SettingKey, rows: list[Row]) -> list[Conflict]:
    stated: dict[str, list[tuple[Any, Row]]] = {}
    for row in rows:
        for name, value in exact_figures(row).items():
            stated.setdefault(name, []).append((value, row))
    return [
        Conflict(volume, key, name, found)
        for name, pairs in stated.items()
        if (found := disagreement(pairs))
    ]


def content_conflicts(volume: Volume) -> list[Conflict]:
    """Voxels that differ under one identity."""
    pairs = [
        (row.text("dataset/content_hash"), row)
        for row in volume.rows
        if row.text("dataset/content_hash")
    ]
    found = disagreement(pairs)
    return [Conflict(volume, None, "dataset.content_hash", found)] if found else []
