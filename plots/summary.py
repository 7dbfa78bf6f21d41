"""The executive summary: questions that a reader comes with, answered in words and figures from the
rows of one machine.

A codec's best parameters count for each volume, and codecs are ranked over the volumes on which all
of the ranked were measured, so that none wins by having been left out. Means over volumes are
geometric. Nothing is said where there are no rows.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import estimates as e
from claims import FAILS, HOLDS, UNCHECKED, UNDECIDED, Claim, verdict_counts
from estimates import Estimate, spell, spell_estimate
from figures.figure import groups, of_stage
from figures.imaged import place
from ranking import best_by_volume, clearly_first, not_ranked, rank, standing, wins_sentence
from rows import Row
from tables import names

PLAIN_ARRAY = "raw"
MODE_QUESTION = "Which access mode should be chosen, and what does it cost?"


@dataclass
class Finding:
    """`headline`: the answer in a few words; `answer`: sentences with figures; `evidence`: which
    rows, and how many.
    """

    question: str
    headline: str
    answer: list[str]
    evidence: str
    details: list[str]


def count(number: int, one: str, many: str = "") -> str:
    return f"{number} {one if number == 1 else many or one + 's'}"


def without(rows: list[Row], *codecs: str) -> list[Row]:
    return [row for row in rows if row.codec not in codecs]


def smallest(rows: list[Row]) -> Finding | None:
    sized = [
        row
        for row in without(of_stage(rows, "encode", "decode", "random-access"), PLAIN_ARRAY)
        if row.get("dataset/kind") == "labels" and e.is_exact(row)
    ]
    ranking = rank(
        best_by_volume(
            sized, lambda row: None if e.rate(row) is None else Estimate(e.rate(row) or 0)
        )
    )
    if ranking is None:
        return None
    codec, mean = ranking.order[0]
    answer = [
        f"{standing(ranking, '%')}, geometric means over {count(len(ranking.volumes), 'volume')}.",
        wins_sentence(ranking, "Smallest"),
    ]
    able = {row.codec for row in without(of_stage(rows, "random-access"), PLAIN_ARRAY)}
    reachable = [one for one in ranking.order if one[0] in able]
    if reachable and reachable[0][0] != codec:
        answer.append(
            f"With access to single voxels: {reachable[0][0]}, {spell(reachable[0][1])} %."
        )
    compared = sum(int(row.number("verification/voxels_compared") or 0) for row in sized)
    answer.append(f"Cost in error: none; not one of {compared:,} voxels compared differs.")
    details = []
    for volume in ranking.volumes:
        winner = min((c for c, _ in ranking.order), key=lambda c: ranking.best[volume][c].value)
        details.append(f"{volume}: {winner} {spell(ranking.best[volume][winner].value)} %")
    return Finding(
        "Which lossless codec is smallest?",
        f"{codec}, {spell(mean)} % of the original",
        answer,
        f"Sizes of {count(len(sized), 'verified row')} of label volumes; exact figures, "
        "no interval." + not_ranked(ranking),
        details,
    )


def fastest_access(rows: list[Row], kind: str) -> Finding | None:
    measured = [
        row
        for row in of_stage(rows, "random-access")
        if row.get("dataset/kind") == kind and e.access_ns(row)
    ]
    ranking = rank(best_by_volume(without(measured, PLAIN_ARRAY), e.access_ns))
    if ranking is None:
        return None
    codec, mean = ranking.order[0]
    clear = sum(clearly_first(ranking, volume) == codec for volume in ranking.volumes)
    answer = [
        f"{standing(ranking, 'ns')}, geometric means over {count(len(ranking.volumes), 'volume')}.",
        wins_sentence(ranking, "Fastest")
        + f" {codec}'s interval is apart from the next one's on {clear}.",
    ]
    sizes = [
        e.rate(row)
        for row in measured
        if row.codec == codec and row.volume in ranking.volumes and e.rate(row)
    ]
    own = [row for row in measured if row.codec == codec]
    answer.append(
        (f"Cost of {codec} in size: {span(sizes)} % of the original. " if sizes else "")
        + cost_in_error(own)
    )
    array = rank(best_by_volume([row for row in measured if row.codec == PLAIN_ARRAY], e.access_ns))
    if array is not None:
        answer.append(
            f"A plain array takes {spell(array.order[0][1])} ns over "
            f"{count(len(array.volumes), 'volume')}."
        )
    details = [
        f"{volume}: {spell_estimate(ranking.best[volume][codec], 'ns')}"
        for volume in ranking.volumes
    ]
    which = "" if kind == "labels" else ", lossy codecs"
    return Finding(
        f"Which codec is fastest for random access{which}?",
        f"{codec}, {spell(mean)} ns per voxel",
        [one for one in answer if one],
        "Stage random-access, uniform points, finest level, "
        f"{count(len(measured), 'row')} of {kind}; medians, intervals of 95 % from six rounds on."
        + not_ranked(ranking),
        details,
    )


def cost_in_error(rows: list[Row]) -> str:
    """What rows of a codec say of its error."""
    psnrs = [row.number("error/psnr_db") for row in rows if row.number("error/psnr_db") is not None]
    if psnrs:
        return f"Cost in error: PSNR {span(psnrs)} dB."
    return "Cost in error: none." if rows and all(map(e.is_exact, rows)) else ""


def fastest_coding(rows: list[Row]) -> Finding | None:
    heads, parts, used, details = [], [], 0, []
    for stage in ("encode", "decode"):
        measured = [
            row
            for row in without(of_stage(rows, stage), PLAIN_ARRAY)
            if row.get("dataset/kind") == "labels" and e.speed(row)
        ]
        measured = [row for row in measured if row.threads == min(r.threads for r in measured)]
        ranking = rank(best_by_volume(measured, e.speed, smaller=False), smaller=False)
        if ranking is None:
            continue
        codec = ranking.order[0][0]
        threads = measured[0].threads
        heads.append(f"{stage}: {codec}")
        parts.append(
            f"To {stage}: {standing(ranking, 'Mvoxel/s', 4)}; {count(threads, 'thread')}, "
            f"geometric means over {count(len(ranking.volumes), 'volume')}; "
            f"{codec} is first on {ranking.wins[codec]}."
        )
        used += len(measured)
        details += [
            f"{stage}, {volume}: {codec} {spell_estimate(ranking.best[volume][codec], 'Mvoxel/s')}"
            for volume in ranking.volumes
        ]
    if not parts:
        return None
    return Finding(
        "Which codec encodes and decodes label volumes fastest?",
        ", ".join(heads),
        parts,
        f"Wall time of {count(used, 'row')}; medians, intervals of 95 % from six rounds on.",
        details,
    )


@dataclass
class Comparison:
    """Access modes of one codec, volume and view: best row of each mode."""

    title: str
    modes: dict[str, Row]


def cache_comparisons(rows: list[Row]) -> list[Comparison]:
    """Views that two or more access modes drew, with the finest levels and equal samples; of
    several cache sizes the fastest. Modes that drew wrong pixels are not compared. Plain voxels,
    which need no cache, count only where there is nothing else.
    """
    usable = [
        row
        for row in of_stage(rows, "render")
        if e.frame_ms(row)[0]
        and not row.number("render/lod_bias")
        and not row.number("verification/label_mismatches")
        and row.get("render/step") is None
    ]
    usable = without(usable, PLAIN_ARRAY) or usable

    def key(row: Row) -> tuple:
        return (
            *place(row),
            row.codec,
            tuple(sorted(row.parameters.items())),
            row.get("render/ao_samples"),
            row.get("render/frames"),
        )

    found = []
    for where, members in groups(usable, key).items():
        modes = {
            mode: min(same, key=lambda row: e.frame_ms(row)[0].value)
            for mode, same in groups(members, lambda row: row.text("render/cache")).items()
        }
        if len(modes) > 1:
            found.append(Comparison(f"{where[5]} on {where[0]}, {where[1]}, {where[2]}", modes))
    return found


def cache_choice(rows: list[Row]) -> Finding | None:
    compared = cache_comparisons(rows)
    if not compared:
        return None
    exact = exact_at_once(compared)
    parts, details, heads = [], [], []
    for name, read in (
        ("fixed view", e.warm_ms),
        ("path from an empty cache", e.path_ms),
        ("first frame", e.first_frame_ms),
    ):
        best, told, lines = fastest_mode(compared, name, read)
        settled = name == "fixed view"
        if best and not settled and not set(best) <= exact:
            best_exact, told_exact, _ = fastest_mode(
                [
                    Comparison(c.title, {m: r for m, r in c.modes.items() if m in exact})
                    for c in compared
                ],
                name,
                read,
            )
            told += [
                text.replace("Fastest,", "Of the modes that are exact in every frame, fastest,", 1)
                for text in told_exact
            ]
            best = best_exact or best
        if best:
            heads.append(
                f"{name}: {' or '.join(best)}"
                + ("" if settled or not set(best) <= exact else ", exact in every frame")
            )
        parts += told
        details += lines
    late = {}
    for one in compared:
        for mode, row in one.modes.items():
            frames = row.number("exact_after_frames") or 0
            if frames > 1:
                late[mode] = max(late.get(mode, 0), int(frames))
    if exact:
        parts.append(f"Exact in the first frame from an empty cache: {', '.join(sorted(exact))}.")
    if late:
        parts.append(
            "Late: "
            + ", ".join(
                f"{mode} shows placeholders and converges after up to {frames} frames"
                for mode, frames in sorted(late.items())
            )
            + "."
        )
    parts.append(jump_cost(rows))
    devices = names(row.device for one in compared for row in one.modes.values())
    return Finding(
        MODE_QUESTION,
        "; ".join(heads[:2]),
        [part for part in parts if part],
        f"Stage render, {count(len(compared), 'comparison')} of modes with equal codec, volume, "
        f"scene, shading and size, on {devices}; device times.",
        details,
    )


def exact_at_once(compared: list[Comparison]) -> set[str]:
    """Modes whose images were exact in the first frame wherever they were drawn."""
    frames: dict[str, set[float | None]] = {}
    for one in compared:
        for mode, row in one.modes.items():
            frames.setdefault(mode, set()).add(row.number("exact_after_frames"))
    return {mode for mode, seen in frames.items() if seen == {1.0}}


def fastest_mode(
    compared: list[Comparison], name: str, read: Callable[[Row], Estimate | None]
) -> tuple[list[str], list[str], list[str]]:
    """Which mode is fastest most often, how clearly, and by how much over direct access; and a line
    for each comparison.
    """
    wins: Counter[str] = Counter()
    clear, gains, details = 0, [], []
    for one in compared:
        times = {
            mode: time
            for mode, row in one.modes.items()
            if (time := read(row)) is not None and time.value > 0
        }
        if len(times) < 2:
            continue
        order = sorted(times, key=lambda mode: times[mode].value)
        wins[order[0]] += 1
        clear += times[order[0]].apart(times[order[1]])
        if "none" in times:
            gains.append(times["none"].value / times[order[0]].value)
        details.append(
            f"{one.title}, {name}: "
            + ", ".join(f"{mode} {spell_estimate(times[mode], 'ms')}" for mode in order)
        )
    if not wins:
        return [], [], []
    total = sum(wins.values())
    ranked = ", ".join(f"{mode} in {number}" for mode, number in wins.most_common())
    text = (
        f"Fastest, {name}: {ranked} of {count(total, 'comparison')} ({clear} with intervals apart)"
    )
    gain = e.geometric_mean(gains)
    most = wins.most_common()
    return (
        [mode for mode, number in most if number == most[0][1]],
        [
            text
            + (
                f"; the fastest takes 1/{spell(gain)} of the time without a cache."
                if gain and gain >= 1.01
                else "."
            )
        ],
        details,
    )


def jump_cost(rows: list[Row]) -> str:
    """The worst first frame after a jump of each mode."""
    worst: dict[str, tuple[float, float]] = {}
    for row in of_stage(rows, "render"):
        frames = row.objects("jump/frames")
        pixels = row.number("jump/pixels")
        if frames and pixels and not row.number("render/lod_bias"):
            wrong = e.finite(frames[0].get("label_mismatches")) or 0
            psnr = e.finite(frames[0].get("psnr_db"))
            mode = row.text("render/cache")
            if wrong / pixels >= worst.get(mode, (-1, 0))[0]:
                worst[mode] = (wrong / pixels, psnr if psnr is not None else 0)
    if not worst:
        return ""
    told = [
        f"{mode} {100 * share:.0f} % of the pixels wrong ({psnr:.1f} dB)"
        if share
        else f"{mode} none"
        for mode, (share, psnr) in sorted(worst.items())
    ]
    return "First frame after a camera jump, at worst: " + ", ".join(told) + "."


def lossy_choice(rows: list[Row]) -> Finding | None:
    """Fronts of bits and PSNR."""
    usable = [
        row
        for row in without(of_stage(rows, "encode", "decode", "random-access"), PLAIN_ARRAY)
        if row.get("dataset/kind") == "scalars"
        and e.bits_per_voxel(row)
        and row.number("error/psnr_db") is not None
    ]
    if not usable:
        return None
    on_front: Counter[str] = Counter()
    details, volumes = [], groups(usable, lambda row: row.volume)
    spans: dict[str, list[tuple[float, float]]] = {}
    for volume, found in volumes.items():
        points = sorted(
            {
                (e.bits_per_voxel(row) or 0, row.number("error/psnr_db") or 0, row.codec)
                for row in found
            }
        )
        front = [
            p
            for p in points
            if not any(q[0] <= p[0] and q[1] >= p[1] and q[:2] != p[:2] for q in points)
        ]
        on_front.update({codec for _, _, codec in front})
        for bits, psnr, codec in points:
            spans.setdefault(codec, []).append((bits, psnr))
        details.append(
            f"{volume}: "
            + ", ".join(
                f"{codec} {spell(bits)} bits {psnr:.1f} dB" for bits, psnr, codec in front[:8]
            )
            + (" .." if len(front) > 8 else "")
        )
    fewest = min(spans, key=lambda codec: min(bits for bits, _ in spans[codec]))
    told = ", ".join(f"{codec} on {number}" for codec, number in on_front.most_common())
    costs = "; ".join(
        f"{codec} {span([b for b, _ in both])} bits/voxel, {span([p for _, p in both])} dB"
        for codec, both in spans.items()
    )
    answer = [
        "On the front, where nothing measured has both fewer bits and a higher PSNR: "
        f"{told} of {count(len(volumes), 'volume')}.",
        f"Fewest bits: {fewest}.",
        f"Cost in error of each: {costs}.",
    ]
    best = on_front.most_common()
    head = "on the front most often: " + " and ".join(
        codec for codec, number in best if number == best[0][1]
    )
    return Finding(
        "Which lossy codec, and at what error?",
        head,
        answer,
        f"Sizes and errors of {count(len(usable), 'row')} of scalar volumes; exact figures.",
        details,
    )


def span(values: list[float]) -> str:
    low, high = spell(min(values)), spell(max(values))
    return low if low == high else f"{low} to {high}"


def findings(rows: list[Row], claims: list[Claim]) -> list[Finding]:
    """All questions that rows of one machine, and claims judged from them, answer."""
    answers = (
        smallest(rows),
        fastest_access(rows, "labels"),
        fastest_access(rows, "scalars"),
        fastest_coding(rows),
        cache_choice(rows),
        lossy_choice(rows),
        claims_finding(claims),
    )
    return [answer for answer in answers if answer is not None]


UNANSWERED = {
    "Which lossless codec is smallest?": "no row of a lossless codec on labels that is ok",
    "Which codec is fastest for random access?": "no row of stage random-access that is ok",
    MODE_QUESTION: "no view was drawn by two access modes",
}


def unanswered(found: list[Finding]) -> list[str]:
    """The questions that this report must answer and cannot, each with why and what run would."""
    asked = {finding.question for finding in found}
    return [
        f"{question} Not answered: {why}; configs/quick.yaml measures it."
        for question, why in UNANSWERED.items()
        if question not in asked
    ]


def claims_finding(claims: list[Claim]) -> Finding | None:
    """Which claims hold, by name."""
    if not claims:
        return None
    counts = verdict_counts(claims)
    words = {
        HOLDS: "Hold",
        FAILS: "Do not hold",
        UNDECIDED: "Undecided",
        UNCHECKED: "Cannot be checked here",
    }
    answer = [
        f"{word}: "
        + ", ".join(
            f"{claim.name} ({claim.source})" for claim in claims if claim.verdict == verdict
        )
        + "."
        for verdict, word in words.items()
        if counts[verdict]
    ]
    files = names(str(claim.file) for claim in claims)
    return Finding(
        "Which claims of papers hold?",
        f"{counts[HOLDS]} of {count(len(claims), 'claim')}",
        answer,
        f"{count(sum(len(claim.groups) for claim in claims), 'group')} of cells, from {files}.",
        [],
    )


def claims_sentence(claims: list[Claim]) -> str:
    if not claims:
        return (
            "No claims were judged: the configs in configs/paper state what the papers claim, "
            "and `cvrbench run` judges them."
        )
    counts = verdict_counts(claims)
    words = {
        HOLDS: "hold",
        FAILS: "do not hold",
        UNDECIDED: "are undecided",
        UNCHECKED: "not testable here",
    }
    return (
        f"{count(len(claims), 'claim')} of papers judged: "
        + ", ".join(
            f"{counts[verdict]} {word}" for verdict, word in words.items() if counts[verdict]
        )
        + "."
    )
