"""Makes a pack (crate.py) of a results folder: cvrbench pack."""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import crate
from crate import EXIT_DIFFERS, EXIT_ENVIRONMENT, EXIT_OK, EXIT_USAGE
from rows import Row, load

HERE = Path(__file__).parent
# What of a results folder is packed: never volumes, scratch files or encoded files.
FOLDERS = {"tables": "*", "claims": "*", "pictures": "*.png", "configs": "**/*.yaml"}
TOP = ("*.yaml", "codecs.json", "report.html")


def different(values: list[Any]) -> list[Any]:
    return list(dict.fromkeys(value for value in values if value not in (None, "")))


def collect(run: Path) -> dict[str, bytes]:
    files = {}
    for pattern in TOP:
        for path in sorted(run.glob(pattern)):
            files[path.name] = path.read_bytes()
    for folder, pattern in FOLDERS.items():
        for path in sorted((run / folder).glob(pattern)):
            if path.is_file() and not path.is_symlink():
                files[path.relative_to(run).as_posix()] = path.read_bytes()
    # Evidence keeps its configuration at the top; elsewhere it is one of configs/.
    for name in [name for name in files if name.endswith(".yaml") and "/" not in name]:
        content = files.pop(name)
        files.setdefault(f"configs/{name}", content)
    return files


def make_report(run: Path) -> bytes | None:
    """The page of the run, where there is what makes it."""
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "report.html"
        done = subprocess.run(
            [sys.executable, "-B", HERE / "report.py", "--results", ".", "-o", page],
            cwd=run,
            capture_output=True,
        )
        return page.read_bytes() if done.returncode == 0 and page.is_file() else None


def described(program: str, run: Path, files: dict[str, bytes]) -> dict[str, dict[str, Any]]:
    """What the program says of the data sets that the run's descriptions name."""
    words = [program, "list", "datasets", "--json"]
    if any(name.startswith("configs/datasets/") for name in files):
        words += ["--datasets", str(run / "configs/datasets")]
    done = subprocess.run(words, capture_output=True, text=True)
    try:
        return {one["name"]: one for one in json.loads(done.stdout)}
    except (ValueError, KeyError, TypeError):
        return {}


def property_values(values: dict[str, Any]) -> list[dict[str, Any]]:
    return [
        {"@type": "PropertyValue", "name": name, "value": value}
        for name, value in values.items()
        if value not in (None, "")
    ]


def dataset_entities(rows: list[Row], known: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for row in rows:
        name = f"#data-{row.dataset}-{row.extent.replace(' ', '')}"
        if name in found:
            continue
        said = known.get(row.dataset, {})
        found[name] = {
            "@id": name,
            "@type": "Dataset",
            "name": f"{row.dataset}, {row.extent}",
            "description": row.text("dataset/title") or row.text("dataset/label"),
            "identifier": row.text("dataset/identity"),
            "license": said.get("licence") or "see its origin",
            "citation": said.get("citation") or "",
            "isBasedOn": said.get("origin") or said.get("generator") or "",
            "additionalProperty": property_values(
                {
                    "extent": row.extent,
                    "type": row.text("dataset/type"),
                    "content hash (XXH3-64)": row.text("dataset/content_hash"),
                    "stands in for": row.text("dataset/label"),
                }
            ),
        }
    return [{key: value for key, value in one.items() if value} for one in found.values()]


def machine_entities(rows: list[Row]) -> list[dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for row in rows:
        name = f"#machine-{row.machine}"
        devices = different([one.device for one in rows if one.machine == row.machine])
        drivers = different([r.text("device/driver") for r in rows if r.machine == row.machine])
        found.setdefault(
            name,
            {
                "@id": name,
                "@type": "Product",
                "name": row.text("provenance/cpu", "unknown processor"),
                "additionalProperty": property_values(
                    {
                        "cores": row.get("provenance/cores"),
                        "memory in bytes": row.get("provenance/memory_bytes"),
                        "system": row.text("provenance/os"),
                        "kernel": row.text("provenance/kernel"),
                        "Vulkan devices": ", ".join(devices),
                        "Vulkan drivers": ", ".join(drivers),
                    }
                ),
            },
        )
    return list(found.values())


def program_entities(rows: list[Row], program: str) -> list[dict[str, Any]]:
    """One for each revision; the hash of the executable where it is the one at hand."""
    said = subprocess.run([program, "--version"], capture_output=True, text=True).stdout
    found = []
    for revision in different([row.text("provenance/revision") for row in rows]):
        of_it = [row for row in rows if row.text("provenance/revision") == revision]
        first = of_it[0]
        entity = {
            "@id": f"#cvrbench-{revision}",
            "@type": "SoftwareApplication",
            "name": "cvrbench",
            "version": f"{first.text('provenance/harness')} ({revision})",
            "softwareRequirements": ", ".join(
                f"{name} {version}"
                for name, version in sorted((first.get("provenance/libraries") or {}).items())
            ),
            "additionalProperty": property_values(
                {
                    "compiler": first.text("provenance/compiler"),
                    "flags": first.text("provenance/flags"),
                    "SHA-256 of the executable": (
                        crate.sha256(Path(program).read_bytes()) if f"({revision})" in said else ""
                    ),
                }
            ),
        }
        found.append(entity)
    return found


def metadata_of(
    files: dict[str, bytes], rows: list[Row], choices: argparse.Namespace, configs: list[str]
) -> bytes:
    known = described(choices.program, choices.run, files)
    data, machines = dataset_entities(rows, known), machine_entities(rows)
    programs = program_entities(rows, choices.program)
    times = sorted(different([row.text("provenance/time") for row in rows]))
    people = [
        {"@id": f"#creator-{number}", "@type": "Person", "name": name}
        for number, name in enumerate(choices.creator, 1)
    ]

    def ids(some: list[dict[str, Any]]) -> list[dict[str, str]]:
        return [{"@id": one["@id"]} for one in some]

    parts = [crate.file_entity(name, files[name]) for name in sorted(files)]
    root: dict[str, Any] = {
        "@id": "./",
        "@type": "Dataset",
        "name": choices.title,
        "description": f"Rows, tables and configuration of a run of cvrbench: {len(rows)} cells.",
        "datePublished": times[-1] if times else "",
        "license": choices.licence,
        "hasPart": ids(parts),
        "mentions": [{"@id": "#run"}],
    }
    if people:
        root["creator"] = ids(people)
    graph: list[dict[str, Any]] = [
        {
            "@id": crate.METADATA,
            "@type": "CreativeWork",
            "conformsTo": {"@id": crate.PROFILE},
            "about": {"@id": "./"},
        },
        root,
        {
            "@id": "#run",
            "@type": "CreateAction",
            "name": "cvrbench run " + " ".join(configs),
            "instrument": ids(programs + machines),
            "object": ids(data) + [{"@id": name} for name in configs],
            "result": [{"@id": "rows.jsonl"}],
            "startTime": times[0] if times else "",
            "endTime": times[-1] if times else "",
        },
        *parts,
        *programs,
        *machines,
        *data,
        *people,
    ]
    text = json.dumps({"@context": crate.CONTEXT, "@graph": graph}, indent=1, ensure_ascii=False)
    return (text + "\n").encode()


def readme_of(choices: argparse.Namespace, rows: list[Row], configs: list[str]) -> bytes:
    ok = sum(row.ok for row in rows)
    revisions = ", ".join(different([row.text("provenance/revision") for row in rows]))
    lines = [
        f"# {choices.title}",
        "",
        f"Results of cvrbench (revision {revisions}): {ok} of {len(rows)} cells are ok.",
        f"`rows.jsonl` has every sample; `{crate.METADATA}` says what each file is, with its hash.",
        "",
        "Check the hashes and measure a random sample of the cells again:",
        "```",
        "cvrbench verify PACK.zip",
        "```",
        "Measure all of it again:",
        "```",
        *(f"cvrbench run {name} --out again" for name in configs),
        "```",
        "",
        f"Licence of these results: {choices.licence}. The data sets are not contained and keep",
        f"their own licences, which `{crate.METADATA}` names. Cite cvrbench as CITATION.cff says,",
        "with the revision above, and the data sets as their authors ask.",
    ]
    return ("\n".join(lines) + "\n").encode()


def make(choices: argparse.Namespace) -> int:
    run = choices.run
    results = load([run])
    rows = results.rows
    if not rows:
        print(f"pack: {run}: expected rows.jsonl with rows, found none", file=sys.stderr)
        return EXIT_USAGE
    if not any(row.ok for row in rows):
        print(f"pack: {run}: nothing to pack: no row is ok", file=sys.stderr)
        return EXIT_DIFFERS
    files = collect(run)
    files["rows.jsonl"] = "".join(
        json.dumps(row.data, separators=(",", ":"), ensure_ascii=False) + "\n" for row in rows
    ).encode()
    if "report.html" not in files and (page := make_report(run)) is not None:
        files["report.html"] = page
    configs = [name for name in sorted(files) if re.fullmatch(r"configs/[^/]+\.yaml", name)]
    if (HERE.parent / "CITATION.cff").is_file():
        files["CITATION.cff"] = (HERE.parent / "CITATION.cff").read_bytes()
    files["README.md"] = readme_of(choices, rows, configs)
    files[crate.METADATA] = metadata_of(files, rows, choices, configs)
    last = max(row.text("provenance/time") for row in rows)
    moment = [int(part) for part in re.findall(r"\d+", last)[:6]]
    time = tuple(moment) if len(moment) == 6 and moment[0] >= 1980 else (1980, 1, 1, 0, 0, 0)
    crate.write(choices.output, files, time)
    size = choices.output.stat().st_size
    print(f"{choices.output}: {len(rows)} rows, {len(files)} files, {size} bytes")
    return EXIT_OK


def main() -> int:
    parser = argparse.ArgumentParser(description="A pack of a results folder")
    parser.add_argument("--run", type=Path, required=True)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--title", default="Compressed volumes: size, speed and error")
    parser.add_argument("--licence", default="https://creativecommons.org/licenses/by/4.0/")
    parser.add_argument("--creator", action="append", default=[])
    parser.add_argument("--program", required=True)
    choices = parser.parse_args()
    try:
        return make(choices)
    except OSError as error:
        print(f"pack: {error}", file=sys.stderr)
        return EXIT_ENVIRONMENT


if __name__ == "__main__":
    sys.exit(main())
