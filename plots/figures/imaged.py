"""What figures of images share: how rows of the stage render are grouped and named."""

from __future__ import annotations

from collections.abc import Iterable

from rows import Row, codec_label


def place(row: Row) -> tuple[str, str, str, str, str]:
    """What two images must share to be compared: volume, scene, shading, size and device."""
    size = row.get("render/size", [])
    return (
        row.volume,
        row.text("render/scene"),
        row.text("render/shading"),
        "x".join(map(str, size)) if isinstance(size, list) else "",
        row.device,
    )


def place_title(found: tuple[str, str, str, str, str]) -> str:
    volume, scene, shading, size, _ = found
    return f"{volume}; scene {scene}, {shading}, {size}"


def short_title(found: tuple[str, str, str, str, str]) -> str:
    volume, scene, shading, size, _ = found
    return f"{volume}; {scene}, {shading}, {size}"


def mode_label(row: Row, varying: dict[str, set[str]], sweeps: Iterable[str] = ()) -> str:
    """Codec, access mode, and the values of settings that tell it from others."""
    settings = [f"{name}={row.get(f'render/{name}')}" for name in sweeps]
    return " ".join([codec_label(row, varying), row.text("render/cache"), *settings])


def swept(rows: list[Row]) -> list[str]:
    """Settings of images that take several values in these rows for some access mode (what has no
    cache has 0 MiB).
    """
    names = ("lod_bias", "cache_mib", "ao_samples", "ao_roulette", "step", "frames")
    modes = {row.text("render/cache") for row in rows}
    return [
        name
        for name in names
        if any(
            len(
                {str(row.get(f"render/{name}")) for row in rows if row.text("render/cache") == mode}
            )
            > 1
            for mode in modes
        )
    ]


def software_note(rows: list[Row]) -> str:
    software = any(row.text("device/type") == "software" for row in rows)
    return (
        "Drawn by a software device: these are times of a processor, not comparable with those of a GPU."
        if software
        else ""
    )
