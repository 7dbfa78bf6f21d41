"""Makes all pages of a site."""

from __future__ import annotations

from pages.codec_page import write_codec
from pages.dataset_page import write_dataset
from pages.folder import SiteFolder
from pages.frame import Site
from pages.index_page import write_index
from pages.measured import Measured
from pages.rows_page import write_rows


def build(measured: Measured, title: str, folder: SiteFolder) -> None:
    site = Site(measured, title, folder)
    for volume in measured.volumes.values():
        write_rows(site, volume)
        write_dataset(site, volume)
    for codec in sorted(measured.codec_pages):
        write_codec(site, codec)
    write_index(site)
