"""A pack: one zip that holds the results of a run as an RO-Crate 1.1, so that a paper can cite it.

pack.py makes one, verify.py checks one. Beside the files of the run there is ro-crate-metadata.json,
which names every file with its size and SHA-256, the program, the machine and the data sets.
(https://www.researchobject.org/ro-crate/1.1)
"""

from __future__ import annotations

import hashlib
import json
import stat
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

METADATA = "ro-crate-metadata.json"
CONTEXT = "https://w3id.org/ro/crate/1.1/context"
PROFILE = "https://w3id.org/ro/crate/1.1"
EXIT_OK, EXIT_DIFFERS, EXIT_USAGE, EXIT_ENVIRONMENT = 0, 1, 2, 3

# Of what is read: a pack of rows is far below them.
MOST_FILES = 20_000
MOST_BYTES = 1 << 30

MEDIA_TYPES = {
    ".jsonl": "application/jsonl",
    ".json": "application/json",
    ".yaml": "application/yaml",
    ".csv": "text/csv",
    ".md": "text/markdown",
    ".tex": "application/x-tex",
    ".html": "text/html",
    ".png": "image/png",
    ".cff": "application/yaml",
}


class NoPack(Exception):
    """The file is no pack, or a damaged one; says what was expected."""


def sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def file_entity(name: str, content: bytes) -> dict[str, Any]:
    return {
        "@id": name,
        "@type": "File",
        "name": name.rsplit("/", 1)[-1],
        "contentSize": str(len(content)),
        "encodingFormat": MEDIA_TYPES.get(Path(name).suffix, "application/octet-stream"),
        "sha256": sha256(content),
    }


def write(path: Path, files: dict[str, bytes], time: tuple[int, int, int, int, int, int]) -> None:
    """Equal files and an equal time give equal bytes. Under a temporary name first."""
    unfinished = path.with_name(f".{path.name}.part")
    try:
        with zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as pack:
            for name in sorted(files):
                info = zipfile.ZipInfo(name, time)
                info.compress_type = zipfile.ZIP_DEFLATED
                info.create_system = 3
                info.external_attr = (stat.S_IFREG | 0o644) << 16
                pack.writestr(info, files[name])
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)


def check_name(name: str, seen: set[str]) -> None:
    parts = name.split("/")
    if name.startswith("/") or "\\" in name or ".." in parts or "" in parts or "\0" in name:
        raise NoPack(f"expected names of files inside the pack, found {name!r}")
    if name in seen:
        raise NoPack(f"expected each file once, found {name!r} twice")
    seen.add(name)


def read(path: Path) -> dict[str, bytes]:
    """All files of a pack by their names, nothing of it trusted. Raises NoPack."""
    files: dict[str, bytes] = {}
    seen: set[str] = set()
    try:
        with zipfile.ZipFile(path) as pack:
            members = pack.infolist()
            if len(members) > MOST_FILES:
                raise NoPack(f"expected at most {MOST_FILES} files, found {len(members)}")
            left = MOST_BYTES
            for member in members:
                check_name(member.filename, seen)
                if stat.S_ISLNK(member.external_attr >> 16):
                    raise NoPack(f"{member.filename}: expected a file, found a link")
                with pack.open(member) as file:
                    content = file.read(left + 1)  # what the header says of sizes is not asked
                left -= len(content)
                if left < 0:
                    raise NoPack(f"expected at most {MOST_BYTES} bytes in all, found more")
                files[member.filename] = content
    except (zipfile.BadZipFile, EOFError, NotImplementedError, RuntimeError, ValueError) as error:
        raise NoPack(f"expected a whole zip, found: {error}") from error
    except Exception as error:
        if type(error).__module__ == "zlib":
            raise NoPack(f"expected a whole zip, found: {error}") from error
        raise
    return files


def entities(files: dict[str, bytes]) -> dict[str, dict[str, Any]]:
    """The graph by its ids. Raises NoPack."""
    if METADATA not in files:
        raise NoPack(f"expected {METADATA}, found none")
    try:
        graph = json.loads(files[METADATA])["@graph"]
        found = {entity["@id"]: entity for entity in graph}
        if found[METADATA]["conformsTo"]["@id"] != PROFILE or len(found) != len(graph):
            raise KeyError("conformsTo")
        found["./"]["hasPart"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise NoPack(f"{METADATA}: expected an RO-Crate 1.1, found none ({error!r})") from error
    return found


def faults(files: dict[str, bytes]) -> Iterable[str]:
    """What is not as the metadata says: a sentence for each file. Raises NoPack."""
    known = entities(files)
    parts = {part.get("@id") for part in known["./"]["hasPart"] if isinstance(part, dict)}
    for name in sorted(parts | set(files) - {METADATA}, key=str):
        entity = known.get(name)
        if name not in files:
            yield f"{name}: expected this file, found none"
        elif name not in parts or entity is None:
            yield f"{name}: found, but {METADATA} does not name it"
        elif entity.get("sha256") != sha256(files[name]):
            yield f"{name}: expected SHA-256 {entity.get('sha256')}, found {sha256(files[name])}"
