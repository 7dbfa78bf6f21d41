"""The page as a document: self-contained, well formed, accessible, the same for the same rows."""

import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml
from html.parser import HTMLParser
from pathlib import Path

import look
import report
import samples
from codec_list import Codec, listed
from figures import REGISTRY

VOID = {"meta", "link", "img", "input", "br", "hr"}


class Document(HTMLParser):
    """Elements with their attributes and texts; complains of what is not closed."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.elements, self.complaints = [], [], []
        self.feed(text)
        self.close()
        self.complaints += [f"{element[0]} is not closed" for element in self.open]

    def handle_starttag(self, tag, attributes):
        element = (tag, dict(attributes), [])
        self.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes), []))

    def handle_endtag(self, tag):
        if not self.open or self.open[-1][0] != tag:
            self.complaints.append(
                f"</{tag}> at {self.getpos()} closes {self.open[-1][0] if self.open else 'nothing'}"
            )
        else:
            self.open.pop()

    def handle_data(self, data):
        for element in self.open:
            element[2].append(data)

    def all(self, tag):
        return [
            (attributes, "".join(texts)) for name, attributes, texts in self.elements if name == tag
        ]


def make(folder, *more):
    page = Path(folder) / "page.html"
    code = report.main(["--results", str(folder), "-o", str(page), *more])
    return code, page.read_text(encoding="utf-8")


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.path = samples.write_whole(Path(cls.folder.name))
        cls.code, cls.text = make(cls.path, "--figures", str(cls.path / "figures"))
        cls.document = Document(cls.text)

    def test_it_is_made_and_well_formed(self):
        self.assertEqual(self.code, 0)
        self.assertEqual(self.document.complaints, [])
        ids = [
            attributes["id"] for _, attributes, _ in self.document.elements if "id" in attributes
        ]
        self.assertEqual(len(ids), len(set(ids)))
        links = [
            attributes["href"][1:]
            for attributes, _ in self.document.all("a")
            if attributes["href"].startswith("#")
        ]
        self.assertEqual([link for link in links if link not in ids], [])

    def test_it_loads_nothing(self):
        for _, attributes, _ in self.document.elements:
            for name in ("src", "href", "srcset", "data", "action"):
                if name in attributes:
                    self.assertRegex(attributes[name], r"^(#|data:)")
        self.assertEqual(re.findall(r"url\((?!#)|@import|fetch\(|XMLHttpRequest", self.text), [])

    def test_every_figure_of_the_registry_is_drawn(self):
        drawn = [
            attributes["id"] for attributes, _ in self.document.all("figure") if "id" in attributes
        ]
        for figure in REGISTRY:
            self.assertTrue(
                any(name.startswith(f"figure-{figure.name}-") for name in drawn), figure.name
            )
            self.assertNotIn(figure.needs, self.text)

    def test_figures_speak_to_those_who_do_not_see_them(self):
        svgs = self.document.all("svg")
        self.assertGreater(len(svgs), 10)
        ids = {
            attributes["id"]: "".join(texts)
            for _, attributes, texts in self.document.elements
            if "id" in attributes
        }
        for attributes, _ in svgs:
            self.assertEqual(attributes["role"], "img")
            title, description = attributes["aria-labelledby"].split()
            self.assertGreater(len(ids[title]), 5)
            self.assertRegex(ids[description], r"\d")
        for attributes, _ in self.document.all("img"):
            self.assertGreater(len(attributes["alt"]), 10)

    def test_svgs_follow_the_colour_of_the_page(self):
        self.assertNotIn(look.INK, self.text)
        self.assertIn("currentColor", self.text)

    def test_headings_are_in_order(self):
        levels = [
            int(name[1]) for name, _, _ in self.document.elements if re.fullmatch(r"h\d", name)
        ]
        self.assertEqual(levels[0], 1)
        self.assertEqual(levels.count(1), 1)
        self.assertTrue(all(b <= a + 1 for a, b in zip(levels, levels[1:])), levels)

    def test_tables_have_captions_and_scopes(self):
        tables = self.document.all("table")
        self.assertEqual(len(tables), len(self.document.all("caption")))
        self.assertGreater(len(tables), 5)
        self.assertEqual(
            [
                attributes
                for attributes, _ in self.document.all("th")
                if attributes.get("scope") not in ("col", "row")
            ],
            [],
        )

    def test_reasons_notes_claims_and_pictures_are_there(self):
        for text in (
            "no access to single voxels",
            "expected FILE.h5",
            "data-missing",
            "Rates &amp; more",
            "A note.",
            "codec&lt;0&gt;",
            "half as large",
            "does not hold",
            "left out: line",
            "data:image/png;base64,",
        ):
            self.assertIn(text, self.text)
        self.assertIn('data-sort="2.25"', self.text)

    def test_figures_are_files_for_papers(self):
        files = sorted((self.path / "figures").iterdir())
        self.assertEqual({file.suffix for file in files}, {".pdf", ".svg"})
        self.assertEqual(
            len(files),
            2 * len([1 for attributes, _ in self.document.all("figure") if "id" in attributes]),
        )
        for file in files:
            if file.suffix == ".pdf":
                data = file.read_bytes()
                self.assertTrue(data.startswith(b"%PDF"))
                box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+)", data)
                self.assertAlmostEqual(float(box.group(1)), 72 * look.COLUMN_INCHES, delta=0.1)
                self.assertNotIn(b"/Subtype /Image", data)
            else:
                self.assertTrue(xml.parse(file).getroot().tag.endswith("svg"))

    def test_equal_rows_give_equal_bytes(self):
        again = subprocess.run(
            [
                sys.executable,
                "-B",
                samples.PLOTS / "report.py",
                "--results",
                self.path,
                "-o",
                self.path / "again.html",
                "--figures",
                self.path / "again",
            ],
            check=True,
            env={"PYTHONHASHSEED": "7", "PATH": "/usr/bin:/bin", "HOME": str(self.path)},
        )
        self.assertEqual(again.returncode, 0)
        self.assertEqual((self.path / "again.html").read_text(encoding="utf-8"), self.text)
        for file in (self.path / "figures").iterdir():
            self.assertEqual(
                (self.path / "again" / file.name).read_bytes(), file.read_bytes(), file.name
            )


class Poor(unittest.TestCase):
    """Results that lack almost everything."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name)

    def page(self, rows, expected=0):
        code, text = make(samples.write(self.path, rows))
        self.assertEqual(code, expected)
        self.assertEqual(Document(text).complaints, [])
        return text

    def test_a_page_of_no_rows_says_what_would_fill_it(self):
        text = self.page([], 1)
        for figure in REGISTRY:
            self.assertIn(figure.needs, text)
        self.assertIn("There are no rows", text)

    def test_unknown_stages_nulls_and_wrong_kinds_do_no_harm(self):
        strange = samples.row("a", "unheard", "juggling")
        nulls = samples.row("a", "c", "encode", size=None) | {
            "time": None,
            "dataset": {"name": None, "extent": None},
            "provenance": {},
        }
        kinds = samples.row(
            "a",
            "c",
            "render",
            render=[],
            frames={"mean_ms": "fast", "ms": [[None, "x"], 5]},
            jump={"frames": [None, {}]},
            held=3,
        ) | {"codec": {"id": 7}}
        empty = samples.drawn("a", "d", "voxel", 1.0) | {
            "jump": {"frames": [{}]},
            "frames": {"mean_ms": 3.0},
            "held": {"median_ms": 0.0},
            "picture_error": {"psnr_db": None},
        }
        zero = samples.label_rows("z", "c", 0.0, 0.0, 0.0)
        bare = {"status": None}
        text = self.page([strange, nulls, kinds, empty, bare, *zero])
        self.assertIn("juggling", text)

    def test_two_machines_stand_apart(self):
        rows = samples.label_rows("a", "x", 2.0, 1, 10.0, machine="m1") + samples.label_rows(
            "a", "y", 1.0, 1, 5.0, machine="m2"
        )
        text = self.page(rows)
        self.assertIn("Rows come from 2 machines", text)
        document = Document(text)
        heads = [
            text for attributes, text in document.all("p") if attributes.get("class") == "headline"
        ]
        self.assertEqual(sum(head.startswith("x, 2.00 %") for head in heads), 1)
        self.assertEqual(sum(head.startswith("y, 1.00 %") for head in heads), 1)
        access = [text for attributes, text in document.all("svg") if "one voxel at random" in text]
        self.assertEqual(len(access), 2)
        self.assertFalse(
            any(
                "x" in re.findall(r"\b[xy]\b", text)
                and "y" in re.findall(r"\b[xy]\b", text.split("rate %")[0])
                for text in access
            )
        )

    def test_names_cannot_leave_their_place(self):
        text = self.page(samples.label_rows("<script>alert(1)</script>", 'c"><b>', 2.0, 1, 10.0))
        self.assertNotIn("<script>alert", text)
        self.assertNotIn("<b>", text)

    def test_dollars_are_no_formulas(self):
        # An odd command between two dollars would end matplotlib's own formula parser.
        name = "a$\\frac{$b"
        rows = samples.label_rows(name, "c$x^$", 2.0, 1, 10.0) + samples.label_rows(
            name, "d$\\input$", 3.0, 0.5, 8.0
        )
        rows.append(samples.drawn(name, "c$x^$", "voxel", 5.0))
        self.assertIn("c$x^$", self.page(rows))

    def test_texts_of_tables_are_shown_as_they_stand(self):
        folder = samples.write(self.path, samples.label_rows("a", "c", 2.0, 1, 10.0))
        samples.write_table(
            folder,
            "t",
            "A `title` <b>",
            ["dataset", "rate"],
            1,
            [[("a|b<i>", None), ("1 (<u>2</u>)", 1.0)]],
            ["a *note* **of** \\`c\\` & <p>"],
        )
        code, text = make(folder)
        self.assertEqual(code, 0)
        for shown in (
            "A `title` &lt;b&gt;",
            "a|b&lt;i&gt;",
            ">1 (&lt;u&gt;2&lt;/u&gt;)<",
            "a *note* **of** \\`c\\` &amp; &lt;p&gt;",
            'data-sort="1.0"',
        ):
            self.assertIn(shown, text)

    def test_labels_are_ordered_as_text(self):
        folder = samples.write(self.path, samples.label_rows("a", "c", 2.0, 1, 10.0))
        samples.write_table(
            folder, "t", "T", ["brick", "rate"], 1, [[("32", 32.0), ("5", 5.5)]], []
        )
        _, text = make(folder)
        self.assertIn('data-sort="5.5"', text)
        self.assertNotIn('data-sort="32.0"', text)

    def test_a_table_that_cannot_be_read_is_told(self):
        folder = samples.write(self.path, samples.label_rows("a", "c", 2.0, 1, 10.0))
        samples.write_table(folder, "empty", "Nothing", ["dataset"], 1, [], [])
        short = '{"title": "T", "columns": [{"heading": "a"}], "labels": 1, "lines": [{"cells": []}], "notes": []}'
        for name, broken in enumerate(
            (
                "",
                "{",
                "[]",
                "5",
                '{"title": "T"}',
                short,
                short.replace("[]}]", '[{"text": 5}]}]'),
                "[" * 100000,
                short.replace('"labels": 1', '"labels": {}'),
            )
        ):
            (folder / "tables" / f"broken{name}.json").write_text(broken, encoding="utf-8")
        code, text = make(folder)
        self.assertEqual(code, 0)
        self.assertEqual(Document(text).complaints, [])
        self.assertEqual(text.count("no table: "), 9)
        self.assertNotIn("Nothing</caption>", text)

    def test_a_folder_that_is_none_is_a_usage_error(self):
        self.assertEqual(
            report.main(["--results", str(self.path / "none"), "-o", str(self.path / "p.html")]), 2
        )


class Colours(unittest.TestCase):
    @staticmethod
    def luminance(colour):
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [
            part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts
        ]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    def contrast(self, one, other):
        low, high = sorted((self.luminance(one), self.luminance(other)))
        return (high + 0.05) / (low + 0.05)

    def test_marks_stand_out_from_both_backgrounds(self):
        for colour in look.COLOURS:
            for panel in ("#f5f6f7", "#1d2126"):
                self.assertGreaterEqual(self.contrast(colour, panel), 3.0, f"{colour} on {panel}")

    def test_text_stands_out_from_its_background(self):
        style = (samples.PLOTS / "style.css").read_text(encoding="utf-8")
        schemes = [
            dict(re.findall(r"--(\w+): (#\w{6})", block))
            for block in re.findall(r":root \{([^}]*)\}", style)
        ][:2]
        self.assertEqual(len(schemes), 2)
        for scheme in schemes:
            for text in ("ink", "soft", "link", "good", "bad", "open"):
                for background in ("paper", "panel"):
                    self.assertGreaterEqual(
                        self.contrast(scheme[text], scheme[background]),
                        4.5,
                        f"{text} on {background}",
                    )


class Codecs(unittest.TestCase):
    """What codecs look like."""

    def setUp(self):
        self.addCleanup(setattr, look, "palette", look.palette)

    def looks(self, listed, others=()):
        look.use_codecs(listed, others)
        return {
            name: (look.codec_colour(name), look.codec_marker(name), look.codec_fill(name))
            for name in look.palette.looks
        }

    def test_as_many_codecs_as_there_are_colours_and_fills_all_differ(self):
        for families in (1, 3, 8, 20, 48):
            looks = self.looks([Codec(f"c{i}", f"f{i % families}") for i in range(48)])
            self.assertEqual(
                len({(colour, marker) for colour, marker, _ in looks.values()}), 48, families
            )
            self.assertEqual(
                len({(colour, fill) for colour, _, fill in looks.values()}), 48, families
            )
        looks = self.looks([Codec(f"c{i}", f"f{i % 5}") for i in range(80)])
        self.assertEqual(len({(colour, marker) for colour, marker, _ in looks.values()}), 80)

    def test_a_family_has_one_colour_and_families_have_several(self):
        looks = self.looks(
            [Codec(f"{family}-{i}", family) for family in "abcdefgh" for i in range(4)]
        )
        self.assertEqual(
            [len({looks[f"{family}-{i}"][0] for i in range(4)}) for family in "abcdefgh"], [1] * 8
        )
        self.assertEqual(len({colour for colour, _, _ in looks.values()}), 8)

    def test_looks_depend_on_the_place_in_the_list_alone(self):
        listed = [Codec("x", "f"), Codec("y", "f"), Codec("z", "g")]
        self.assertEqual(
            self.looks(listed, ["new", "x", "another"]), self.looks(listed, ["another", "new"])
        )
        self.assertEqual(list(look.palette.looks), ["x", "y", "z", "another", "new"])
        before = self.looks(listed)
        self.assertEqual(
            {
                name: found
                for name, found in self.looks([*listed, Codec("later", "f")]).items()
                if name in before
            },
            before,
        )

    def test_codecs_come_from_the_folders_and_else_from_the_program(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            samples.write_codecs(folder / "a", ("x", "f"), ("y", "f"))
            samples.write_codecs(folder / "b", ("z", "g"), ("x", "other"))
            self.assertEqual(
                listed([folder / "a", folder / "b", folder]),
                [Codec("x", "f"), Codec("y", "f"), Codec("z", "g")],
            )
            self.assertEqual(listed([folder], str(folder / "no-program")), [])
            program = folder / "program"
            program.write_text(
                '#!/bin/sh\necho \'[{"id": "p"}, {"family": "no id"}, 5]\'\n', encoding="utf-8"
            )
            program.chmod(0o755)
            self.assertEqual(listed([folder], str(program)), [Codec("p", "p")])
            (folder / "codecs.json").write_text('{"id": "no list"}', encoding="utf-8")
            self.assertEqual(listed([folder]), [])


if __name__ == "__main__":
    unittest.main()
