#!/usr/bin/env python3
"""Makes one static site of many results; `cvrbench leaderboard` calls it.

    leaderboard.py RESULTS... -o SITE [--title TEXT] [--program CVRBENCH]

RESULTS are results folders or packs. The site loads nothing from anywhere and works from files.
Equal results give equal bytes. Exit codes: 0 ok, 1 where no row is ok (no site is made then), 2
usage or input, 3 environment.
"""

from __future__ import annotations

import argparse
import signal
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

import codec_list
import look
from pages.build import build
from pages.folder import Refused, SiteFolder
from pages.measured import join
from rows import Results, Unreadable, load
from summary import count

TITLE = "Compressed volumes: leaderboard"
EXIT_OK, EXIT_NOTHING, EXIT_USAGE, EXIT_ENVIRONMENT = 0, 1, 2, 3


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="One static site of many results")
    parser.add_argument("results", type=Path, nargs="+", help="results folders or packs")
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder of the site")
    parser.add_argument("--title", default=TITLE, help="heading of the site")
    parser.add_argument(
        "--program", default="", help="cvrbench, asked for its codecs where no results list them"
    )
    return parser.parse_args(arguments)


def leave(number: int, frame: object) -> None:
    """By way of `finally`; a second signal does not disturb that."""
    for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(one, signal.SIG_IGN)
    sys.exit(128 + number)


def read(places: Sequence[Path]) -> Results:
    """Raises Unreadable also for results without rows."""
    results = load(places)
    for source in results.sources:
        if source.note.startswith("no "):
            raise Unreadable(
                f"{source.folder}: expected rows.jsonl or rows.jsonl.zst, found neither"
            )
    return results


def make(choices: argparse.Namespace) -> int:
    places = list(dict.fromkeys(choices.results))
    for place in places:
        if not place.exists():
            raise Unreadable(f"{place}: expected a results folder or a pack, found none")
    with SiteFolder(choices.output, places) as folder:
        results = read(places)
        if not any(row.ok for row in results.rows):
            print("leaderboard.py: nothing to show: no row of these results is ok", file=sys.stderr)
            return EXIT_NOTHING
        listed = codec_list.listed(places, choices.program)
        look.use_codecs(listed, (row.codec for row in results.rows))
        measured = join(results, listed)
        build(measured, choices.title, folder)
        folder.commit()
        parts = [
            count(len(measured.volumes), "data set"),
            count(len(measured.codec_pages), "codec"),
            count(len(results.rows), "cell"),
            count(len(folder.files), "file"),
        ]
        print(f"{', '.join(parts)}, {folder.bytes / 1e6:.1f} MB")
        if measured.conflicts:
            number = count(len(measured.conflicts), "exact figure")
            print(f"{number} that runs disagree about: the site shows them first")
        print(f"Site: {choices.output}/index.html", flush=True)
    return EXIT_OK


def main(arguments: Sequence[str] | None = None) -> int:
    choices = parse(arguments)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, leave)
    try:
        return make(choices)
    except (Refused, Unreadable) as error:
        print(f"leaderboard.py: {error}", file=sys.stderr)
        return EXIT_USAGE
    except OSError as error:
        print(f"leaderboard.py: {error}", file=sys.stderr)
        return EXIT_ENVIRONMENT
    except Exception:  # Python's own exit code for it is 1, which says that nothing was measured
        traceback.print_exc()
        return EXIT_ENVIRONMENT


if __name__ == "__main__":
    sys.exit(main())
