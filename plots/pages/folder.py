"""The folder of a site in the making: it grows beside its final name and is put there as a whole.

What may be replaced: nothing, an empty folder, and a folder that holds nothing but files of a site
that was made here, which its file cvrbench-site.json lists.
"""

from __future__ import annotations

import ctypes
import errno
import json
import os
import shutil
from collections.abc import Sequence
from pathlib import Path

MARKER = "cvrbench-site.json"
MADE_BY = "cvrbench leaderboard"
AT_CURRENT_FOLDER, EXCHANGE = -100, 2  # of renameat2(2)


class Refused(Exception):
    """The output names something that is not replaced."""


def foreign_entry(folder: Path) -> str:
    """Something in a folder that is no part of a site made here; empty where there is nothing."""
    entries = sorted(os.listdir(folder))
    if not entries:
        return ""
    marker = folder / MARKER
    if marker.is_symlink() or not marker.is_file():
        return f"'{entries[0]}', and no {MARKER}"
    try:
        told = json.loads(marker.read_text(encoding="utf-8"))
        ours = set(told["files"]) if told["made by"] == MADE_BY else set()
    except (ValueError, TypeError, KeyError):
        ours = set()
    if not ours:
        return f"a {MARKER} of something else"
    for at, folders, files in os.walk(folder):
        here = Path(at).relative_to(folder)
        for name in sorted([*files, *(one for one in folders if (Path(at) / one).is_symlink())]):
            if (here / name).as_posix() not in ours | {MARKER}:
                return f"'{(here / name).as_posix()}'"
    return ""


class SiteFolder:
    """`with SiteFolder(output, inputs) as site:` writes files and commits; without commit nothing
    of it stays. Raises Refused, and OSError where the disk says no.
    """

    def __init__(self, output: Path, inputs: Sequence[Path]) -> None:
        self.output = output
        self.target = output.resolve()
        self.inputs = [one.resolve() for one in inputs]
        self.files: list[str] = []
        self.bytes = 0
        self.check()
        self.partial = self.target

    def check(self) -> None:
        if any(self.target == one or self.target in one.parents for one in self.inputs):
            raise Refused(f"{self.output}: expected a folder without the results that are read")
        if not self.target.exists():
            if not self.target.parent.is_dir():
                raise OSError(f"{self.output}: there is no folder '{self.target.parent}'")
            return
        here = Path.cwd()
        if self.target == here or self.target in here.parents:
            raise Refused(f"{self.output}: it is the current folder or one above it")
        if not self.target.is_dir():
            raise Refused(f"{self.output}: expected a folder, found a file of this name")
        found = foreign_entry(self.target)
        if found:
            raise Refused(
                f"{self.output}: a folder is replaced only where it is empty or holds nothing but "
                f"a site that was made by {MADE_BY}, found {found}"
            )

    def __enter__(self) -> SiteFolder:
        for number in range(1000):
            partial = self.target.with_name(f"{self.target.name}.part{number}")
            try:
                partial.mkdir()
            except FileExistsError:
                continue
            self.partial = partial
            return self
        raise OSError(f"{self.output}: a thousand unfinished folders lie beside it")

    def __exit__(self, *failure: object) -> None:
        if self.partial != self.target:
            shutil.rmtree(self.partial, ignore_errors=True)

    def write(self, name: str, content: str | bytes) -> None:
        """`name`: of safe names joined by '/'."""
        path = self.partial / name
        path.parent.mkdir(exist_ok=True)
        data = content.encode("utf-8", errors="replace") if isinstance(content, str) else content
        path.write_bytes(data)
        self.files.append(name)
        self.bytes += len(data)

    def commit(self) -> None:
        told = {"made by": MADE_BY, "schema": 1, "files": sorted(self.files)}
        self.write(MARKER, json.dumps(told, indent=1) + "\n")
        self.check()
        try:
            os.rename(self.partial, self.target)
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise
            self.exchange()
            shutil.rmtree(self.partial, ignore_errors=True)
        self.partial = self.target

    def exchange(self) -> None:
        """In one step, so that at every moment a whole site has the name."""
        names = [os.fsencode(one) for one in (self.partial, self.target)]
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.renameat2(AT_CURRENT_FOLDER, names[0], AT_CURRENT_FOLDER, names[1], EXCHANGE) != 0:
            raise OSError(
                f"{self.output}: it cannot be replaced here: "
                f"{os.strerror(ctypes.get_errno())}; remove it or write beside it"
            )
