"""The site of many results: what is compared, what is a conflict, names that mean harm, and that
equal rows give equal bytes.
"""

from __future__ import annotations

import contextlib
import io
import re
import tempfile
import unittest
import zipfile
from html.parser import HTMLParser
from pathlib import Path

import leaderboard
import samples
from rows import load

EVIL = "</script><img src=x onerror=alert(1)>\n../../x"


class Links(HTMLParser):
    """Addresses and anchors of a page, and its elements by name."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.ids: set[str] = set()
        self.names: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.names.append(tag)
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            if name == "id" and value:
                self.ids.add(value)


class Site(unittest.TestCase):
    def setUp(self) -> None:
        self.scratch = tempfile.TemporaryDirectory()
        self.addCleanup(self.scratch.cleanup)
        self.folder = Path(self.scratch.name)
        self.said = ""

    def make(self, *places: Path, site: str = "site") -> int:
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = leaderboard.main([*map(str, places), "-o", str(self.folder / site)])
        self.said = out.getvalue() + err.getvalue()
        return code

    def pages(self, site: str = "site") -> dict[Path, Links]:
        return {
            path: Links(path.read_text(encoding="utf-8"))
            for path in sorted((self.folder / site).rglob("*.html"))
        }

    def test_every_link_leads_somewhere(self) -> None:
        samples.write_whole(self.folder / "run")
        self.assertEqual(self.make(self.folder / "run"), 0, self.said)
        pages = self.pages()
        self.assertGreater(len(pages), 8)
        for path, page in pages.items():
            for link in page.links:
                if link.startswith(("data:", "http")):
                    continue
                name, _, anchor = link.partition("#")
                target = (path.parent / name).resolve() if name else path
                self.assertTrue(target.exists(), f"{path}: {link}")
                if anchor and target in pages:
                    self.assertIn(anchor, pages[target].ids, f"{path}: {link}")

    def test_equal_rows_give_equal_bytes(self) -> None:
        samples.write_whole(self.folder / "run")
        for site in ("a", "b"):
            self.assertEqual(self.make(self.folder / "run", site=site), 0)
        files = sorted(p.relative_to(self.folder / "a") for p in (self.folder / "a").rglob("*"))
        self.assertEqual(
            files, sorted(p.relative_to(self.folder / "b") for p in (self.folder / "b").rglob("*"))
        )
        for name in files:
            if (self.folder / "a" / name).is_file():
                self.assertEqual(
                    (self.folder / "a" / name).read_bytes(), (self.folder / "b" / name).read_bytes()
                )

    def test_names_that_mean_harm_are_text(self) -> None:
        rows = samples.label_rows(EVIL, "fast", 8.0, 0.1, 10.0)
        rows += samples.label_rows("a/b", "fast", 8.0, 0.1, 10.0)
        rows += samples.label_rows("a?b", EVIL, 8.0, 0.1, 10.0)
        samples.write(self.folder / "run", rows)
        before = set(self.folder.parent.iterdir())
        self.assertEqual(self.make(self.folder / "run"), 0, self.said)
        self.assertEqual(set(self.folder.parent.iterdir()), before)
        site = self.folder / "site"
        for path in site.rglob("*"):
            self.assertRegex(path.relative_to(site).as_posix(), r"^[A-Za-z0-9./-]+$")
        for path, page in self.pages().items():
            self.assertNotIn("img", page.names, path)
        self.assertEqual(len(list((site / "dataset").glob("*.html"))), 3)

    def test_runs_that_disagree_about_a_size_are_a_conflict(self) -> None:
        samples.write(self.folder / "one", samples.label_rows("v", "fast", 8.0, 0.1, 10.0))
        samples.write(
            self.folder / "two",
            samples.label_rows("v", "fast", 9.0, 0.1, 10.0, machine="00000000000000bb"),
        )
        self.assertEqual(self.make(self.folder / "one", self.folder / "two"), 0, self.said)
        self.assertIn("that runs disagree about", self.said)
        index = (self.folder / "site/index.html").read_text(encoding="utf-8")
        self.assertRegex(index, r"(?i)disagree")

    def test_times_of_two_machines_never_share_a_column(self) -> None:
        samples.write(self.folder / "one", samples.label_rows("v", "fast", 8.0, 0.1, 10.0))
        samples.write(
            self.folder / "two",
            samples.label_rows("v", "fast", 8.0, 0.7, 70.0, machine="00000000000000bb"),
        )
        self.assertEqual(self.make(self.folder / "one", self.folder / "two"), 0, self.said)
        self.assertNotIn("disagree", self.said)
        index = (self.folder / "site/index.html").read_text(encoding="utf-8")
        menu = re.search(r'<select id="machine">(.*?)</select>', index, re.S)
        assert menu is not None
        choices = re.findall(r"<option[^>]*>(.*?)</option>", menu.group(1))
        self.assertEqual(
            [text.split(",")[0].split(":")[0] for text in choices],
            ["1 thread of Processor aa", "1 thread of Processor bb", "none"],
        )

    def test_packs_and_compressed_rows_are_results_too(self) -> None:
        rows = samples.label_rows("v", "fast", 8.0, 0.1, 10.0)
        run = samples.write(self.folder / "run", rows)
        with zipfile.ZipFile(self.folder / "p.zip", "w") as pack:
            pack.write(run / "rows.jsonl", "rows.jsonl")
        self.assertEqual(self.make(self.folder / "p.zip"), 0, self.said)
        self.assertEqual(len(load([self.folder / "p.zip"]).rows), len(rows))

    def test_what_is_not_a_site_is_never_replaced(self) -> None:
        samples.write(self.folder / "run", samples.label_rows("v", "fast", 8.0, 0.1, 10.0))
        (self.folder / "site").mkdir()
        (self.folder / "site/mine").write_text("x")
        self.assertEqual(self.make(self.folder / "run"), 2)
        self.assertEqual([p.name for p in (self.folder / "site").iterdir()], ["mine"])
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["run", "site"])


if __name__ == "__main__":
    unittest.main()
