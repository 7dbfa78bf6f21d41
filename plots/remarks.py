"""What stands beside the summary: what was run, and what a reader should know before trusting a
figure.
"""

from __future__ import annotations

from collections import Counter

import estimates as e
from rows import Row
from summary import count
from tables import names


def stands_out(rows: list[Row]) -> list[str]:
    """What a reader should know before trusting a figure: failures, noise, stand-ins, builds with
    changes, software devices.
    """
    told = []
    failed = [row for row in rows if not row.ok and row.text("status") != "unsupported"]
    if failed:
        by_status = ", ".join(
            f"{number} {status}"
            for status, number in Counter(
                row.text("status", "unknown") for row in failed
            ).most_common()
        )
        told.append(
            f"{count(len(failed), 'cell')} without a result that should have one: {by_status}."
        )
    unsupported = sum(row.text("status") == "unsupported" for row in rows)
    if unsupported:
        told.append(
            f"{count(unsupported, 'cell')} unsupported: the codec, mode or device cannot do it; the reasons are listed below."
        )
    wrong = [
        row
        for row in rows
        if row.ok and row.number("verification/mismatches") and not row.get("error")
    ]
    if wrong:
        told.append(f"{count(len(wrong), 'row')} of lossless codecs with voxels that differ.")
    told += noise(rows)
    stand_ins = names(row.dataset for row in rows if row.text("dataset/label"))
    if stand_ins:
        told.append(f"Generated volumes, whose rates are not those of originals: {stand_ins}.")
    if any(row.text("device/type") == "software" for row in rows):
        told.append(
            "Frames were drawn by a software device: times of a processor; their order can be compared, not their size with a GPU's."
        )
    dirty = names(
        row.text("provenance/revision")
        for row in rows
        if row.text("provenance/revision").endswith("-dirty")
    )
    if dirty:
        told.append(f"Built from a tree with changes that are not committed: {dirty}.")
    revisions = names(row.text("provenance/revision") for row in rows)
    if ", " in revisions:
        told.append(f"Rows of several revisions stand side by side: {revisions}.")
    return told


def noise(rows: list[Row]) -> list[str]:
    """How far times can be trusted."""
    told, widths, few, notes = [], [], 0, Counter()
    for row in rows:
        time = e.seconds(row) if row.stage in ("encode", "decode") else e.access_ns(row)
        if not row.ok or time is None or row.codec == "memcpy":
            continue
        few += time.n < 6
        if time.low is not None and time.high is not None and time.n >= 6 and time.value > 0:
            widths.append((time.high - time.low) / time.value)
        notes.update(
            note for note in row.text("time/seconds/note").split(", ") if note == "bimodal"
        )
    if widths:
        widths.sort()
        told.append(
            f"Noise: the 95 % intervals of {count(len(widths), 'time')} are {100 * widths[len(widths) // 2]:.0f} % of the median wide in the middle, "
            f"{100 * widths[-1]:.0f} % at most"
            + (f"; {count(notes['bimodal'], 'series', 'series')} bimodal." if notes else ".")
        )
    if few:
        told.append(
            f"{count(few, 'time')} repeated fewer than six times: too few for a 95 % interval."
        )
    return told


def what_was_run(rows: list[Row]) -> str:
    """One sentence."""
    statuses = ", ".join(
        f"{number} {status}"
        for status, number in Counter(row.text("status", "unknown") for row in rows).most_common()
    )
    stages = names(row.stage for row in rows)
    volumes = {row.volume for row in rows}
    codecs = {row.codec for row in rows if row.codec != "memcpy"}
    times = sorted(filter(None, (row.text("provenance/time") for row in rows)))
    when = (
        f", measured {times[0]}" + (f" to {times[-1]}" if times[-1] != times[0] else "")
        if times
        else ""
    )
    return f"{count(len(rows), 'cell')} ({statuses}): {count(len(volumes), 'volume')}, {count(len(codecs), 'codec')}, stages {stages}{when}."
