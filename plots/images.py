"""Images that a run kept (keep_images): DIR/pictures/*.png, each with its difference to the
reference, as data of the page.
"""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from pathlib import Path

from PIL import Image, UnidentifiedImageError

from figures.imaged import mode_label, place, place_title, swept
from rows import Row, varying_parameters

EXACT_BYTES = 1_200_000  # of PNG files; above that images are WebP
WEBP_QUALITY = 86
MOST_IMAGES = 48


@dataclass
class KeptImage:
    title: str
    where: str
    image: str  # data URI
    difference: str
    gain: float
    psnr: float | None
    ssim: float | None
    width: int
    height: int
    files: str


def file_of(row: Row, which: str) -> Path | None:
    """The file of an image: a plain name in DIR/pictures."""
    name = row.text(f"pictures/{which}")
    path = row.folder / "pictures" / name
    return path if name and "/" not in name and path.is_file() else None


def as_data(path: Path, exact: bool) -> tuple[str, int, int] | None:
    """Data URI, width and height; None for a file that is no image."""
    try:
        with Image.open(path) as image:
            width, height = image.size
            if exact:
                return (
                    "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode(),
                    width,
                    height,
                )
            smaller = io.BytesIO()
            image.convert("RGB").save(smaller, "WEBP", quality=WEBP_QUALITY, method=4)
            return (
                "data:image/webp;base64," + base64.b64encode(smaller.getvalue()).decode(),
                width,
                height,
            )
    except (OSError, UnidentifiedImageError, ValueError):
        return None


def collect(rows: list[Row]) -> tuple[list[KeptImage], str]:
    """Images of rows, equal ones of a view once, and what to say of them."""
    groups: dict[tuple, list[tuple[Row, Path, Path]]] = {}
    for row in rows:
        image, difference = file_of(row, "picture"), file_of(row, "difference")
        if row.ok and image and difference:
            groups.setdefault((place(row), image.read_bytes(), difference.read_bytes()), []).append(
                (row, image, difference)
            )
    kept = list(groups.values())[:MOST_IMAGES]
    exact = sum(one.stat().st_size for same in kept for one in same[0][1:]) <= EXACT_BYTES
    imaged = [row for same in groups.values() for row, _, _ in same]
    varying, sweeps = varying_parameters(imaged), swept(imaged)
    images = []
    for same in kept:
        row, image, difference = same[0]
        shown, changed = as_data(image, exact), as_data(difference, exact)
        if shown is None or changed is None:
            continue
        title = ", ".join(dict.fromkeys(mode_label(one, varying, sweeps) for one, _, _ in same))
        images.append(
            KeptImage(
                title,
                place_title(place(row)),
                shown[0],
                changed[0],
                row.number("pictures/gain") or 1.0,
                row.number("pictures/psnr_db"),
                row.number("pictures/ssim"),
                shown[1],
                shown[2],
                str(image),
            )
        )
    note = "Images that are equal bit by bit are shown once." if len(imaged) > len(groups) else ""
    if kept and not exact:
        note += f" Images are shown as WebP of quality {WEBP_QUALITY}; the exact ones are the PNG files named below each."
    if len(groups) > len(kept):
        note += f" {len(kept)} of {len(groups)} images are shown."
    return images, note.strip()
