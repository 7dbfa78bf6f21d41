"""Pictures that a run kept (keep_pictures): DIR/pictures/*.png, each with its difference to the reference, as data of the page."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from pathlib import Path

from PIL import Image, UnidentifiedImageError

from figures.pictured import mode_label, place, place_title
from rows import Row, varying_parameters

EXACT_BYTES = 1_200_000  # of PNG files; above that pictures are WebP
WEBP_QUALITY = 86
MOST_PICTURES = 48


@dataclass
class Picture:
    title: str
    where: str
    picture: str  # data URI
    difference: str
    gain: float
    psnr: float | None
    ssim: float | None
    width: int
    height: int
    files: str


def file_of(row: Row, which: str) -> Path | None:
    """The file of a picture: a plain name in DIR/pictures."""
    name = row.text(f"pictures/{which}")
    path = row.folder / "pictures" / name
    return path if name and "/" not in name and path.is_file() else None


def as_data(path: Path, exact: bool) -> tuple[str, int, int] | None:
    """Data URI, width and height; None for a file that is no picture."""
    try:
        with Image.open(path) as image:
            width, height = image.size
            if exact:
                return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode(), width, height
            smaller = io.BytesIO()
            image.convert("RGB").save(smaller, "WEBP", quality=WEBP_QUALITY, method=4)
            return "data:image/webp;base64," + base64.b64encode(smaller.getvalue()).decode(), width, height
    except (OSError, UnidentifiedImageError, ValueError):
        return None


def collect(rows: list[Row]) -> tuple[list[Picture], str]:
    """Pictures of rows, and what to say of them."""
    found = [(row, picture, difference) for row in rows if row.ok and (picture := file_of(row, "picture")) and (difference := file_of(row, "difference"))]
    kept = found[:MOST_PICTURES]
    exact = sum(one.stat().st_size for _, *both in kept for one in both) <= EXACT_BYTES
    varying = varying_parameters(row for row, _, _ in kept)
    pictures = []
    for row, picture, difference in kept:
        shown, changed = as_data(picture, exact), as_data(difference, exact)
        if shown is None or changed is None:
            continue
        pictures.append(Picture(mode_label(row, varying), place_title(place(row)), shown[0], changed[0], row.number("pictures/gain") or 1.0,
                                row.number("pictures/psnr_db"), row.number("pictures/ssim"), shown[1], shown[2], str(picture)))
    note = "" if exact or not kept else f"Pictures are shown as WebP of quality {WEBP_QUALITY}; the exact ones are the PNG files named below each."
    if len(found) > len(kept):
        note += f" {len(kept)} of {len(found)} pictures are shown."
    return pictures, note.strip()
