"""Results folders that the tests make: rows as the harness writes them, small."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

PLOTS = Path(__file__).resolve().parents[2] / "plots"

MACHINE = "00000000000000aa"


def statistics(median: float, spread: float = 0.1, n: int = 9) -> dict[str, Any]:
    """Samples evenly around a median."""
    samples = [median * (1 + spread * (2 * i / max(1, n - 1) - 1)) for i in range(n)]
    return {"median": median, "samples": samples, "interval": [samples[0], samples[-1]], "note": ""}


def row(
    dataset: str,
    codec: str,
    stage: str,
    *,
    kind: str = "labels",
    parameters: dict[str, str] | None = None,
    threads: int = 1,
    machine: str = MACHINE,
    measured: str = "2026-01-01T00:00:00Z",
    edge: int = 32,
    **more: Any,
) -> dict[str, Any]:
    voxels = edge**3
    key = "|".join(
        [
            dataset,
            str(edge),
            codec,
            str(parameters),
            str(threads),
            stage,
            json.dumps(more.get("render", {})),
        ]
    )
    data: dict[str, Any] = {
        "schema": 1,
        "cell": key,
        "key": key,
        "status": "ok",
        "reason": "",
        "stage": stage,
        "threads": threads,
        "dataset": {
            "name": dataset,
            "title": f"Volume {dataset}",
            "label": "generated",
            "extent": [edge, edge, edge],
            "type": "u8",
            "kind": kind,
            "voxels": voxels,
            "bytes": voxels,
        },
        "codec": {"id": codec, "version": 1, "parameters": parameters or {}},
        "provenance": {
            "machine": machine,
            "cpu": f"Processor {machine[-2:]}",
            "cores": 2,
            "memory_bytes": 2**34,
            "revision": "abc",
            "compiler": "GNU",
            "flags": "-O3",
            "os": "Debian",
            "kernel": "Linux",
            "time": measured,
            "config_hash": "1",
            "harness": "0.1.0",
            "build_type": "Release",
        },
        "verification": {"voxels_compared": voxels, "mismatches": 0},
    }
    data.update(more)
    return data


def sized(rate: float) -> dict[str, Any]:
    return {
        "bytes": int(rate * 327.68),
        "rate": rate,
        "bits_per_voxel": rate * 0.08,
        "breakdown": {},
    }


def label_rows(
    dataset: str, codec: str, rate: float, seconds: float, ns: float | None, **more: Any
) -> list[dict[str, Any]]:
    rows = [
        row(dataset, codec, stage, size=sized(rate), time={"seconds": statistics(seconds)}, **more)
        for stage in ("encode", "decode")
    ]
    if ns is not None:
        access = [{"points": "uniform", "lod": 0, "count": 1000, "ns_per_voxel": statistics(ns)}]
        rows.append(row(dataset, codec, "random-access", size=sized(rate), access=access, **more))
    return rows


def drawn(dataset: str, codec: str, cache: str, ms: float, **more: Any) -> dict[str, Any]:
    """A row of the stage render: path of 2 rounds, 4 warm frames per round."""
    render = {
        "scene": "s",
        "cache": cache,
        "shading": "local",
        "cache_mib": 0 if cache == "none" else 8,
        "size": [16, 9],
        "frames": 2,
        "lod_bias": 0.0,
        "ao_samples": 1,
    }
    render.update(more.pop("render", {}))
    brick = cache.startswith("brick")
    data = row(
        dataset,
        codec,
        "render",
        render=render,
        size=sized(3.0),
        exact_after_frames=3 if brick else 1,
        frames={
            "count": 2,
            "rounds": 2,
            "mean_ms": 2 * ms,
            "median_ms": 2 * ms,
            "first_frame_ms": 3 * ms,
            "ms": [[3 * ms, ms], [3 * ms, ms]],
        },
        held={"median_ms": ms, "ms": [[ms, ms, ms, ms], [0.9 * ms, ms, ms, 1.1 * ms]]},
        jump={
            "pixels": 144,
            "frames": [
                {
                    "psnr_db": 17.5 if brick else None,
                    "label_mismatches": 40 if brick else 0,
                    "incomplete": 0,
                    "ms": 2 * ms,
                },
                {"psnr_db": None, "label_mismatches": 0, "incomplete": 0, "ms": ms},
            ],
        },
        picture_error={"psnr_db": 30.0 - 5 * render["lod_bias"], "ssim": 0.9, "pixels": 144},
        memory={"gpu_bytes": 4 << 20, "peak_bytes": 1},
        device={"name": "llvmpipe", "type": "software", "driver": "Mesa", "api": "1.3"},
        **more,
    )
    data["verification"]["label_mismatches"] = 0
    return data


def whole() -> list[dict[str, Any]]:
    """Every figure has something to draw; small is smallest, fast is fastest."""
    rows: list[dict[str, Any]] = []
    for dataset, factor in (("one", 1.0), ("two", 1.5)):
        rows += label_rows(dataset, "raw", 100.0, 0.001, 5.0)
        rows += label_rows(dataset, "small", 1.0 * factor, 0.5, None)
        rows += label_rows(dataset, "fast", 8.0 * factor, 0.1, 10.0)
        for brick in ("16", "32"):
            rows += label_rows(
                dataset,
                "slow",
                (3.0 if brick == "16" else 2.5) * factor,
                0.3,
                90.0,
                parameters={"brick": brick},
            )
    rows += label_rows("one", "fast", 8.0, 0.06, 10.0, threads=2)
    rows += label_rows("one", "fast", 7.0, 0.5, 11.0, edge=64)
    for bits, psnr in (("200", 30.0), ("400", 36.0)):
        error = {"psnr_db": psnr, "exact": False, "largest_error": 9.0, "mean_squared_error": 4.0}
        rows.append(
            row(
                "field",
                "lossy",
                "encode",
                kind="scalars",
                parameters={"rate": bits},
                size=sized(float(bits) / 10),
                error=error,
                time={"seconds": statistics(0.2)},
                verification={"voxels_compared": 32768, "mismatches": 9000},
            )
        )
    for cache, ms in (("none", 20.0), ("voxel", 5.0), ("brick", 9.0)):
        for bias in (0.0, 1.0):
            rows.append(drawn("one", "slow", cache, ms / (1 + bias), render={"lod_bias": bias}))
    rows.append(
        row("one", "small", "random-access")
        | {"status": "unsupported", "reason": "no access to single voxels"}
    )
    rows.append(
        row("gone", "fast", "encode") | {"status": "data-missing", "reason": "expected FILE.h5"}
    )
    return rows


def write(folder: Path, rows: list[dict[str, Any]], torn: bool = False) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    text = "".join(json.dumps(one) + "\n" for one in rows)
    (folder / "rows.jsonl").write_text(
        text + ('{"schema": 1, "cell": "to' if torn else ""), encoding="utf-8"
    )
    return folder


def write_table(
    folder: Path,
    name: str,
    title: str,
    headings: list[str],
    labels: int,
    lines: list[list[tuple[str, float | None]]],
    notes: list[str],
) -> None:
    """FOLDER/tables/NAME.json as the harness writes it."""
    columns = [
        {
            "name": heading,
            "heading": heading,
            "unit": "",
            "description": "",
            "align": "left" if at < labels else "right",
        }
        for at, heading in enumerate(headings)
    ]
    cells = [
        [{"text": text} | ({} if number is None else {"number": number}) for text, number in line]
        for line in lines
    ]
    table = {
        "schema": 1,
        "name": name,
        "title": title,
        "columns": columns,
        "labels": labels,
        "lines": [{"cells": line} for line in cells],
        "notes": notes,
    }
    (folder / "tables").mkdir(exist_ok=True)
    (folder / "tables" / f"{name}.json").write_text(json.dumps(table), encoding="utf-8")


def write_codecs(folder: Path, *codecs: tuple[str, str]) -> None:
    """FOLDER/codecs.json of ids and families."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "codecs.json").write_text(
        json.dumps([{"id": name, "family": family} for name, family in codecs]), encoding="utf-8"
    )


def write_whole(folder: Path) -> Path:
    """Rows, a table, codecs, claims and a pair of images; the last line is torn."""
    from PIL import Image

    rows = whole()
    drawn = next(one for one in rows if one["stage"] == "render")
    drawn["pictures"] = {
        "picture": "p.png",
        "difference": "d.png",
        "gain": 8.0,
        "psnr_db": 31.0,
        "ssim": 0.9,
    }
    write(folder, rows, torn=True)
    write_codecs(
        folder,
        ("raw", "general"),
        ("small", "general"),
        ("fast", "bricks"),
        ("slow", "bricks"),
        ("lossy", "lossy"),
    )
    for name in ("pictures", "tables", "claims"):
        (folder / name).mkdir(exist_ok=True)
    Image.new("RGB", (16, 9), (200, 20, 20)).save(folder / "pictures" / "p.png")
    Image.new("RGB", (16, 9)).save(folder / "pictures" / "d.png")
    values = (
        (10.5, "10.5"),
        (2.25, "2.25"),
        (100.0, "100"),
        (7.0, "7"),
        (3.0, "3"),
        (None, "failed"),
        (None, ""),
    )
    lines = [
        [("one", None), (f"codec<{i}>", None), (text, number), ("2.5", 2.5)]
        for i, (number, text) in enumerate(values)
    ]
    write_table(
        folder,
        "t",
        "Rates & more",
        ["dataset", "codec", "rate %", "published %"],
        2,
        lines,
        ["A note."],
    )
    claims = [
        {
            "claim": "smaller",
            "says": "half as large",
            "source": "Paper, 5",
            "claim_verdict": verdict,
            "group": {"dataset": "one"},
            "verdict": verdict,
            "reason": "1 / 8",
            "metric": "rate",
            "compare": "ratio",
            "at_most": 0.5,
            "compared": [{"value": 0.125}],
        }
        for verdict in ("holds",)
    ]
    claims.append(
        claims[0]
        | {"claim": "faster", "claim_verdict": "does not hold", "verdict": "does not hold"}
    )
    (folder / "claims" / "c.jsonl").write_text(
        "".join(json.dumps(one) + "\n" for one in claims), encoding="utf-8"
    )
    return folder
