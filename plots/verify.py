"""Checks a pack (crate.py): its hashes, then a random sample of its cells, measured again here:
cvrbench verify.

Exact figures (sizes, checksums, errors, mismatches) must come out equal, as `cvrbench compare` calls
them. Times are told as ratios and judge nothing. What another machine changes by right is said: the
threads of `all`, the device, libraries of another version.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import crate
from crate import EXIT_DIFFERS, EXIT_ENVIRONMENT, EXIT_OK, EXIT_USAGE

TIMES = ("time/seconds", "frames", "held")
MOST_DIFFERENCES = 5  # of a cell that are named


@dataclass
class Checked:
    """A cell that was measured again."""

    key: str
    agree: int = 0
    differ: list[str] = field(default_factory=list)
    ratios: dict[str, float] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def as_object(self) -> dict[str, Any]:
        return {
            "key": self.key,
            "exact_agree": self.agree,
            "exact_differ": self.differ,
            "time_ratios": self.ratios,
            "remarks": self.remarks,
        }


def at(row: dict[str, Any], path: str) -> Any:
    value: Any = row
    for part in path.split("/"):
        value = value.get(part) if isinstance(value, dict) else None
    return value


def rows_of(text: str) -> dict[str, dict[str, Any]]:
    """The last row of each key; lines that are none are left out."""
    rows = {}
    for line in text.splitlines():
        try:
            row = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(row, dict) and isinstance(row.get("key"), str):
            rows[row["key"]] = row
    return rows


def candidates(rows: dict[str, dict[str, Any]], seed: int) -> list[str]:
    """Keys of the cells that are ok, in the order in which to try them: by chance, and one stage and
    codec after the other, so that a few cells say something of each."""
    groups: dict[tuple[str, str], list[str]] = {}
    for key, row in sorted(rows.items()):
        if row.get("status") == "ok":
            groups.setdefault((str(row.get("stage")), str(at(row, "codec/id"))), []).append(key)
    chance = random.Random(seed)
    order = sorted(groups)
    chance.shuffle(order)
    for keys in groups.values():
        chance.shuffle(keys)
    found = []
    while any(groups.values()):
        found += [groups[name].pop() for name in order if groups[name]]
    return found


def as_glob(key: str) -> str:
    return re.sub(r"([\\*?\[\]])", r"\\\1", key)


class Rerun:
    """Measures cells of a pack anew, in a folder of its own."""

    def __init__(self, choices: argparse.Namespace, files: dict[str, bytes], folder: Path) -> None:
        self.choices, self.folder = choices, folder
        for name, content in files.items():
            if name.startswith("configs/"):
                path = folder / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
        self.configs = [n for n in sorted(files) if re.fullmatch(r"configs/[^/]+\.yaml", n)]
        self.runs = 0

    def measure(self, keys: list[str]) -> dict[str, dict[str, Any]]:
        """Rows by key; a cell that no configuration has is missing."""
        self.runs += 1
        found: dict[str, dict[str, Any]] = {}
        for number, config in enumerate(self.configs):
            out = f"out{self.runs}-{number}"
            words = [self.choices.program, "run", config, "--out", out]
            for key in keys:
                if key not in found:
                    words += ["--only", f"key={as_glob(key)}"]
            for option in ("data", "cache"):
                if value := getattr(self.choices, option):
                    words += [f"--{option}", str(Path(value).resolve())]
            done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True)
            path = self.folder / out / "rows.jsonl"
            if path.is_file():
                found.update(rows_of(path.read_text(encoding="utf-8", errors="replace")))
            elif "found none of" not in done.stderr:
                print(f"verify: {config}: {done.stderr.strip()}", file=sys.stderr)
        return found

    def compare(self, base: dict[str, Any], fresh: dict[str, Any]) -> Checked:
        for name, row in (("base", base), ("fresh", fresh)):
            (self.folder / name).mkdir(exist_ok=True)
            text = json.dumps(row) + "\n"
            (self.folder / name / "rows.jsonl").write_text(text, encoding="utf-8")
        done = subprocess.run(
            [self.choices.program, "compare", "base", "fresh"]
            + ["--format", "jsonl", "--fail-on", "never"],
            cwd=self.folder,
            capture_output=True,
            text=True,
        )
        checked = Checked(base["key"])
        lines = done.stdout.splitlines()
        for line in lines:
            one = json.loads(line)
            if one["kind"] != "exact":
                continue
            if one["outcome"] == "same":
                checked.agree += 1
            else:
                says = f"{one['quantity']}: {one.get('base', '')} there, {one.get('new', '')} here"
                checked.differ.append(says.replace(":  there,  here", ""))
        if not lines:
            checked.differ.append(done.stderr.strip() or "nothing was compared")
        return checked


def median_of(row: dict[str, Any], path: str) -> float | None:
    value = at(row, path)
    if not isinstance(value, dict):
        return None
    found = value.get("median", value.get("median_ms"))
    return found if isinstance(found, float) and found > 0 else None


def add_times(base: dict[str, Any], fresh: dict[str, Any], checked: Checked) -> None:
    for path in TIMES:
        there, here = median_of(base, path), median_of(fresh, path)
        if there and here:
            checked.ratios[path.split("/")[0]] = here / there
    for there, here in zip(at(base, "access") or [], at(fresh, "access") or []):
        first, second = median_of(there, "ns_per_voxel"), median_of(here, "ns_per_voxel")
        if first and second:
            checked.ratios[f"{there.get('points')} level {there.get('lod')}"] = second / first


def add_remarks(base: dict[str, Any], fresh: dict[str, Any], checked: Checked) -> None:
    """What is another here than there and may explain figures that differ."""
    for path, word in (
        ("provenance/machine", "another machine"),
        ("provenance/revision", "another revision"),
        ("threads", "another number of threads"),
        ("device/driver", "another Vulkan driver"),
    ):
        there, here = at(base, path), at(fresh, path)
        if there != here:
            checked.remarks.append(f"{word} ({there} there, {here} here)")
    there = at(base, "provenance/libraries") or {}
    here = at(fresh, "provenance/libraries") or {}
    checked.remarks += [
        f"{name} {there[name]} there, {here[name]} here"
        for name in sorted(there)
        if name in here and there[name] != here[name]
    ]


@dataclass
class Outcome:
    """Of all cells that were tried."""

    checked: list[Checked] = field(default_factory=list)
    data_missing: list[str] = field(default_factory=list)
    not_done: list[str] = field(default_factory=list)  # "KEY: reason"


def check_cells(
    choices: argparse.Namespace, files: dict[str, bytes], rows: dict[str, dict[str, Any]]
) -> Outcome:
    outcome = Outcome()
    left = candidates(rows, choices.seed)
    wanted = len(left) if choices.all else choices.cells
    with tempfile.TemporaryDirectory(prefix="cvrbench-verify-") as folder:
        rerun = Rerun(choices, files, Path(folder))
        while left and len(outcome.checked) < wanted:
            batch = left[: wanted - len(outcome.checked)]
            left = left[len(batch) :]
            fresh = rerun.measure(batch)
            for key in batch:
                if key not in fresh:
                    outcome.not_done.append(f"{key}: no configuration of the pack has this cell")
                    continue
                row = fresh[key]
                if row["status"] == "data-missing":
                    outcome.data_missing.append(key)
                elif row["status"] in ("unsupported", "out-of-memory"):
                    outcome.not_done.append(f"{key}: {row['status']}: {row.get('reason')}")
                elif at(row, "dataset/identity") != at(rows[key], "dataset/identity"):
                    outcome.not_done.append(f"{key}: another volume has this name here")
                else:
                    checked = rerun.compare(rows[key], row)
                    add_times(rows[key], row, checked)
                    add_remarks(rows[key], row, checked)
                    outcome.checked.append(checked)
    return outcome


def table_of(outcome: Outcome) -> list[str]:
    lines = ["| cell | exact figures | times here / there |", "|:--|:--|:--|"]
    for one in outcome.checked:
        key = one.key.replace("|", " ")
        agree = f"{one.agree} of {one.agree + len(one.differ)} agree"
        times = ", ".join(f"{name} {ratio:.2f}" for name, ratio in one.ratios.items())
        lines.append(f"| {key} | {agree} | {times} |")
    for one in outcome.checked:
        for says in one.differ[:MOST_DIFFERENCES]:
            lines.append(f"- {one.key}: {says}")
        if one.differ and one.remarks:
            lines.append(f"- {one.key}: measured by {'; '.join(one.remarks)}")
    return lines


def verdict_of(outcome: Outcome, choices: argparse.Namespace) -> tuple[str, int]:
    """A sentence and the exit code."""
    apart = ""
    if outcome.data_missing:
        apart += f" {len(outcome.data_missing)} cells were left out: their data are not here."
    if outcome.not_done:
        apart += f" {len(outcome.not_done)} could not be measured: {outcome.not_done[0]}."
    if not outcome.checked:
        return f"No cell was measured again.{apart}", EXIT_DIFFERS
    differ = sum(bool(one.differ) for one in outcome.checked)
    ratios = [ratio for one in outcome.checked for ratio in one.ratios.values()]
    times = f" Times here / there: median {statistics.median(ratios):.2f}." if ratios else ""
    cells = f"{len(outcome.checked)} cells (seed {choices.seed})"
    if differ:
        return f"Exact figures of {differ} of {cells} differ.{times}{apart}", EXIT_DIFFERS
    return f"All exact figures of {cells} agree.{times}{apart}", EXIT_OK


def check(choices: argparse.Namespace) -> int:
    try:
        files = crate.read(choices.pack)
        faults = list(crate.faults(files))
        if "rows.jsonl" not in files:
            raise crate.NoPack("expected rows.jsonl, found none")
    except crate.NoPack as error:
        print(f"verify: {choices.pack}: {error}", file=sys.stderr)
        return EXIT_USAGE
    for fault in faults:
        print(f"verify: {choices.pack}: {fault}", file=sys.stderr)
    if faults:
        return EXIT_DIFFERS
    rows = rows_of(files["rows.jsonl"].decode(encoding="utf-8", errors="replace"))
    outcome = check_cells(choices, files, rows)
    sentence, code = verdict_of(outcome, choices)
    if choices.json:
        found = {
            "pack": str(choices.pack),
            "files": len(files),
            "seed": choices.seed,
            "cells": [one.as_object() for one in outcome.checked],
            "data_missing": outcome.data_missing,
            "not_measured": outcome.not_done,
            "agrees": code == EXIT_OK,
            "verdict": sentence,
        }
        print(json.dumps(found, indent=2))
    else:
        print(f"Hashes of {len(files) - 1} files agree.\n")
        print("\n".join(table_of(outcome)) + "\n")
        print(sentence)
    return code


def main() -> int:
    parser = argparse.ArgumentParser(description="Checks a pack")
    parser.add_argument("--pack", type=Path, required=True)
    parser.add_argument("--cells", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--data", default="")
    parser.add_argument("--cache", default="")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--program", required=True)
    choices = parser.parse_args()
    try:
        return check(choices)
    except FileNotFoundError as error:
        print(f"verify: {error.filename}: expected a file, found none", file=sys.stderr)
        return EXIT_USAGE
    except OSError as error:
        print(f"verify: {error}", file=sys.stderr)
        return EXIT_ENVIRONMENT


if __name__ == "__main__":
    sys.exit(main())
