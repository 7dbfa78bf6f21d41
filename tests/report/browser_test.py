"""The page of a run, and the site of many, in a browser: no error and no request, all figures, sorting by keyboard, both colour
schemes, narrow screens, paper.

Exit code 77 where there is no Chromium, which ctest shows as skipped.
"""

import sys
import tempfile
import unittest
from pathlib import Path

import leaderboard
import report
import samples
from browser import Browser, find_browser
from figures import REGISTRY

SKIPPED = 77
TABLE = "document.querySelector('#tables').parentElement.querySelector('table')"


class InBrowser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        folder = samples.write_whole(Path(cls.folder.name))
        cls.page = folder / "page.html"
        assert report.main(["--results", str(folder), "-o", str(cls.page)]) == 0
        cls.browser = Browser(find_browser())
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        self.browser.complaints.clear()
        self.browser.requests.clear()

    def open(self, **how):
        self.browser.open(self.page, **how)
        return self.browser.evaluate

    def column(self, number):
        return self.browser.evaluate(
            f"Array.from({TABLE}.tBodies[0].rows).filter(r => !r.hidden).map(r => r.cells[{number}].textContent.trim())"
        )

    def test_no_error_and_no_request_but_the_page(self):
        for scheme in ("light", "dark"):
            self.open(scheme=scheme)
        self.assertEqual(self.browser.complaints, [])
        self.assertEqual(
            {url for url in self.browser.requests if not url.startswith("data:")},
            {self.page.resolve().as_uri()},
        )

    def test_all_figures_have_a_size(self):
        ask = self.open()
        ask("document.querySelectorAll('details').forEach(d => d.open = true)")
        boxes = ask(
            "Array.from(document.querySelectorAll('figure svg')).map(s => [s.closest('figure').id, s.getBoundingClientRect().width, s.getBoundingClientRect().height])"
        )
        for figure in REGISTRY:
            self.assertTrue(
                any(name.startswith(f"figure-{figure.name}-") for name, _, _ in boxes), figure.name
            )
        self.assertEqual([box for box in boxes if box[1] < 200 or box[2] < 60], [])
        self.assertEqual(
            ask("Array.from(document.images).filter(i => i.naturalWidth === 0).length"), 0
        )

    def test_text_of_figures_stays_within_them(self):
        ask = self.open()
        outside = ask(
            """Array.from(document.querySelectorAll('figure svg')).flatMap(s => { const box =
            s.getBoundingClientRect(); return Array.from(s.querySelectorAll('text')).filter(t => {
            const b = t.getBoundingClientRect();
              return b.left < box.left - 4 || b.right > box.right + 4 || b.top < box.top - 4 || b.bottom > box.bottom + 4; })
              .map(t => s.closest('figure').id + ': ' + t.textContent); })
            """
        )
        self.assertEqual(outside, [])

    def test_the_keyboard_sorts(self):
        ask = self.open()
        before = self.column(2)
        ask(f"{TABLE}.tHead.rows[0].cells[2].querySelector('button').focus()")
        self.browser.press("Enter", "\r")
        self.assertEqual(
            ask(f"{TABLE}.tHead.rows[0].cells[2].getAttribute('aria-sort')"), "ascending"
        )
        self.assertEqual(self.column(2), ["2.25", "3", "7", "10.5", "100", "failed", ""])
        self.assertNotEqual(before, self.column(2))
        self.browser.press(" ", " ")
        self.assertEqual(
            ask(f"{TABLE}.tHead.rows[0].cells[2].getAttribute('aria-sort')"), "descending"
        )
        self.assertEqual(self.column(2), ["100", "10.5", "7", "3", "2.25", "failed", ""])
        self.browser.press("Tab")
        self.assertEqual(ask("document.activeElement.textContent"), "published %")
        self.browser.press("Enter", "\r")
        self.assertEqual(ask(f"{TABLE}.querySelectorAll('[aria-sort]').length"), 1)
        self.assertEqual(self.browser.complaints, [])

    def test_the_filter_keeps_lines_that_have_all_words(self):
        ask = self.open()
        ask(f"{TABLE}.closest('.scroll').previousElementSibling.querySelector('input').focus()")
        self.browser.write("ONE codec<3>")
        self.assertEqual(self.column(2), ["7"])
        self.assertEqual(
            ask(
                f"{TABLE}.closest('.scroll').previousElementSibling.querySelector('output').textContent"
            ),
            "1 of 7",
        )

    def test_dark_and_light_differ_in_background_text_and_figures(self):
        seen = {}
        for scheme in ("light", "dark"):
            ask = self.open(scheme=scheme)
            seen[scheme] = ask(
                """[getComputedStyle(document.documentElement).backgroundColor,
                getComputedStyle(document.body).color,
                getComputedStyle(document.querySelector('figure svg text')).fill]
                """
            )
        self.assertEqual(seen["light"][0], "rgb(255, 255, 255)")
        self.assertEqual(seen["light"][1], seen["light"][2])
        self.assertEqual(seen["dark"][1], seen["dark"][2])
        self.assertEqual([a == b for a, b in zip(seen["light"], seen["dark"])], [False] * 3)

    def test_nothing_is_wider_than_the_screen(self):
        for width in (320, 390, 1280):
            ask = self.open(width=width)
            self.assertLessEqual(ask("document.documentElement.scrollWidth"), width, width)

    def test_the_skip_link_is_first_and_leads_to_the_report(self):
        ask = self.open()
        self.browser.press("Tab")
        self.assertEqual(ask("document.activeElement.getAttribute('href')"), "#main")
        self.assertGreaterEqual(ask("document.activeElement.getBoundingClientRect().left"), 0)

    def test_paper_shows_everything_and_no_controls(self):
        ask = self.open(media="print", scheme="dark")
        self.assertEqual(ask("getComputedStyle(document.querySelector('nav')).display"), "none")
        self.assertEqual(ask("getComputedStyle(document.querySelector('.filter')).display"), "none")
        self.assertEqual(
            ask("getComputedStyle(document.querySelector('.scroll')).overflowX"), "visible"
        )
        self.assertEqual(
            ask("getComputedStyle(document.documentElement).backgroundColor"), "rgb(255, 255, 255)"
        )
        ask("dispatchEvent(new Event('beforeprint'))")
        self.assertEqual(ask("document.querySelectorAll('details:not([open])').length"), 0)


class SiteInBrowser(unittest.TestCase):
    """The leaderboard: its menus, questions and sorting; it asks for nothing but its own files."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        folder = Path(cls.folder.name)
        samples.write_whole(folder / "one")
        other = samples.label_rows("one", "fast", 8.0, 0.9, 33.0, machine="00000000000000bb")
        samples.write(folder / "two", other)
        cls.site = folder / "site"
        assert (
            leaderboard.main([str(folder / "one"), str(folder / "two"), "-o", str(cls.site)]) == 0
        )
        cls.browser = Browser(find_browser())
        cls.addClassCleanup(cls.browser.close)

    def open(self, page="index.html", **how):
        self.browser.complaints.clear()
        self.browser.requests.clear()
        self.browser.open(self.site / page, **how)
        return self.browser.evaluate

    def leaders(self, ask):
        """The codecs of the first board, in the order that is shown."""
        return ask(
            "Array.from(document.querySelector('.leaders').tBodies[0].rows)"
            ".map(r => r.cells[0].querySelector('a').textContent)"
        )

    def choose(self, ask, control, value):
        ask(
            f"(() => {{ const c = document.querySelector('{control}'); c.value = '{value}'; "
            "c.dispatchEvent(new Event('change')); })()"
        )

    def test_no_page_complains_or_asks_for_what_is_not_its_own(self):
        for path in sorted(self.site.rglob("*.html")):
            for scheme in ("light", "dark"):
                self.open(path.relative_to(self.site).as_posix(), scheme=scheme)
                self.assertEqual(self.browser.complaints, [], path)
                own = self.site.resolve().as_uri()
                asked = [url for url in self.browser.requests if not url.startswith("data:")]
                self.assertEqual([url for url in asked if not url.startswith(own)], [], path)

    def test_a_question_orders_the_codecs(self):
        ask = self.open()
        self.assertEqual(self.leaders(ask)[0], "small")
        ask("document.querySelectorAll('.answer')[1].click()")
        self.assertNotEqual(self.leaders(ask)[0], "small")
        self.assertEqual(
            ask("document.querySelectorAll('.answer')[1].getAttribute('aria-pressed')"), "true"
        )
        self.assertEqual(self.browser.complaints, [])

    def test_the_menus_choose_access_settings_and_machine(self):
        ask = self.open()
        everything = self.leaders(ask)
        self.assertIn("slow", everything)
        ask("document.querySelector('.all').click()")
        self.assertEqual(self.leaders(ask).count("slow"), 2)
        ask = self.open()
        self.choose(ask, "#machine", 1)
        self.assertEqual(self.browser.complaints, [])
        other = ask("document.querySelector('.leaders').textContent")
        self.choose(ask, "#machine", 0)
        self.assertNotEqual(other, ask("document.querySelector('.leaders').textContent"))
        self.choose(ask, "#kind", "scalars")
        self.assertEqual(ask("document.querySelectorAll('section.board[hidden]').length"), 1)
        self.assertEqual(self.browser.complaints, [])

    def test_nothing_is_wider_than_the_screen(self):
        for page in (
            "index.html",
            *(f"dataset/{p.name}" for p in (self.site / "dataset").iterdir()),
        ):
            for width in (320, 1280):
                ask = self.open(page, width=width)
                self.assertLessEqual(ask("document.documentElement.scrollWidth"), width, page)


if __name__ == "__main__":
    if find_browser() is None:
        print("Skipped: no chromium here; the Debian package chromium brings it.")
        sys.exit(SKIPPED)
    unittest.main()
