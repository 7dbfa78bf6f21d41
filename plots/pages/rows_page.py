"""The rows of a data set: a page with an anchor for each, and all of them in a compressed file."""

from __future__ import annotations

import gzip
import json
from typing import Any

from pages.frame import Site
from pages.measured import Volume

SHARED = ("dataset", "provenance")  # parts of rows that the page has once


def write_rows(site: Site, volume: Volume) -> None:
    """A page with an anchor for each row, and the rows themselves, compressed."""
    shared: dict[str, str] = {}
    shown = []
    for row in volume.rows:
        data = dict(row.data)
        parts = []
        for name in SHARED:
            value = data.pop(name, None)
            stamp = (
                value.get("time", "") if name == "provenance" and isinstance(value, dict) else ""
            )
            if isinstance(value, dict):
                value = {key: inner for key, inner in value.items() if key != "time"}
            text = f'"{name}": {compact(value)}'
            parts.append(shared.setdefault(text, f"{name}-{len(shared) + 1}"))
            if stamp:
                data["time of the row"] = stamp
        shown.append(
            {
                "id": site.measured.anchors[id(row)],
                "title": f"{site.measured.label(row)}, {row.stage}",
                "status": row.text("status", "unknown"),
                "run": row.folder.resolve().name,
                "line": row.line,
                "parts": parts,
                "text": compact(data),
            }
        )
    lines = "".join(compact(row.data) + "\n" for row in volume.rows)
    site.folder.write(
        f"rows/{volume.page}.jsonl.gz",
        gzip.compress(lines.encode("utf-8", errors="replace"), 9, mtime=0),
    )
    site.page(
        f"rows/{volume.page}.html",
        "rows.html.j2",
        (),
        heading=f"Rows of {volume.label}",
        page=volume.page,
        rows=shown,
        shared=[(name, text) for text, name in shared.items()],
    )


def compact(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
