"""Packs that were changed, cut or made to harm."""

from __future__ import annotations

import io
import json
import stat
import tempfile
import unittest
import zipfile
from pathlib import Path

import crate
import verify

TIME = (2026, 1, 2, 3, 4, 6)


def metadata_of(files: dict[str, bytes]) -> bytes:
    parts = [crate.file_entity(name, content) for name, content in files.items()]
    graph = [
        {"@id": crate.METADATA, "conformsTo": {"@id": crate.PROFILE}, "about": {"@id": "./"}},
        {"@id": "./", "hasPart": [{"@id": part["@id"]} for part in parts]},
        *parts,
    ]
    return json.dumps({"@context": crate.CONTEXT, "@graph": graph}).encode()


class Crate(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.path = Path(self.folder.name) / "p.zip"
        self.files = {"rows.jsonl": b"{}\n", "tables/t.md": b"| a |\n"}

    def tearDown(self) -> None:
        self.folder.cleanup()

    def write(self, **changes: bytes) -> None:
        files = {**self.files, crate.METADATA: metadata_of(self.files)}
        files.update({name.replace("__", "."): content for name, content in changes.items()})
        crate.write(self.path, files, TIME)

    def faults(self) -> list[str]:
        return list(crate.faults(crate.read(self.path)))

    def refused(self) -> str:
        with self.assertRaises(crate.NoPack) as caught:
            self.faults()
        return str(caught.exception)

    def raw(self, members: list[tuple[zipfile.ZipInfo | str, bytes]]) -> None:
        with zipfile.ZipFile(self.path, "w", zipfile.ZIP_DEFLATED) as pack:
            for name, content in members:
                pack.writestr(name, content)

    def test_a_whole_one_has_no_faults_and_equal_bytes(self) -> None:
        self.write()
        first = self.path.read_bytes()
        self.assertEqual(self.faults(), [])
        self.write()
        self.assertEqual(self.path.read_bytes(), first)
        self.assertEqual(list(self.path.parent.iterdir()), [self.path])

    def test_each_change_is_named(self) -> None:
        self.write(rows__jsonl=b"{ }\n")
        self.assertIn("rows.jsonl: expected SHA-256", self.faults()[0])
        self.write(more__txt=b"x")
        self.assertEqual(self.faults(), [f"more.txt: found, but {crate.METADATA} does not name it"])
        files = {**self.files, "gone.csv": b"1\n"}
        crate.write(self.path, {**self.files, crate.METADATA: metadata_of(files)}, TIME)
        self.assertEqual(self.faults(), ["gone.csv: expected this file, found none"])

    def test_what_is_no_crate_is_refused(self) -> None:
        crate.write(self.path, self.files, TIME)
        self.assertIn(f"expected {crate.METADATA}", self.refused())
        for text in (b"", b"[]", b'{"@graph": [1]}', b'{"@graph": []}', b"[" * 100_000):
            self.raw([(crate.METADATA, text)])
            self.assertIn("expected an RO-Crate 1.1", self.refused())

    def test_a_cut_zip_is_refused(self) -> None:
        self.write()
        whole = self.path.read_bytes()
        for length in (0, 10, len(whole) // 2, len(whole) - 1):
            self.path.write_bytes(whole[:length])
            self.assertIn("expected a whole zip", self.refused())

    def test_flipped_bytes_are_never_passed_over(self) -> None:
        self.write()
        whole = bytearray(self.path.read_bytes())
        begin = whole.index(b"rows.jsonl") + len("rows.jsonl")
        for at in range(begin, begin + 3):
            flipped = bytearray(whole)
            flipped[at] ^= 0x55
            self.path.write_bytes(flipped)
            try:
                self.assertNotEqual(self.faults(), [])
            except crate.NoPack:
                pass

    def test_names_that_leave_the_pack_are_refused(self) -> None:
        for name in ("../x", "/etc/x", "a/../../x", "a\\..\\x", "a//b"):
            self.raw([(zipfile.ZipInfo(name), b"x")])
            self.assertIn("expected names of files inside the pack", self.refused())

    def test_links_and_doubles_are_refused(self) -> None:
        link = zipfile.ZipInfo("rows.jsonl")
        link.external_attr = (stat.S_IFLNK | 0o777) << 16
        self.raw([(link, b"/etc/passwd")])
        self.assertIn("found a link", self.refused())
        with self.assertWarns(UserWarning):
            self.raw([("a", b"1"), ("a", b"2")])
        self.assertIn("found 'a' twice", self.refused())

    def test_a_bomb_is_refused(self) -> None:
        most, crate.MOST_BYTES = crate.MOST_BYTES, 1 << 20
        try:
            self.raw([("rows.jsonl", b"\0" * (8 << 20))])
            self.assertLess(self.path.stat().st_size, 1 << 16)
            self.assertIn("bytes in all, found more", self.refused())
        finally:
            crate.MOST_BYTES = most


class Sample(unittest.TestCase):
    ROWS = {
        f"{codec}|{stage}|{n}": {"status": "ok", "stage": stage, "codec": {"id": codec}}
        for codec in ("a", "b", "c")
        for stage in ("encode", "decode")
        for n in range(20)
    }

    def test_few_cells_are_of_every_stage_and_codec(self) -> None:
        found = verify.candidates(self.ROWS, 3)
        self.assertEqual(len(set(found)), 120)
        self.assertEqual(len({key.rsplit("|", 1)[0] for key in found[:6]}), 6)
        self.assertEqual(found, verify.candidates(self.ROWS, 3))
        self.assertNotEqual(found, verify.candidates(self.ROWS, 4))

    def test_only_cells_that_are_ok_are_tried(self) -> None:
        rows = {**self.ROWS, "x|encode|0": {"status": "failed", "stage": "encode"}}
        self.assertNotIn("x|encode|0", verify.candidates(rows, 1))

    def test_a_key_is_its_own_glob(self) -> None:
        self.assertEqual(verify.as_glob("a[1]*?\\b|c"), "a\\[1\\]\\*\\?\\\\b|c")

    def test_rows_that_are_none_are_left_out(self) -> None:
        text = io.StringIO()
        for line in ("{", "[]", '{"key": 1}', '{"key": "a", "n": 1}', '{"key": "a", "n": 2}'):
            text.write(line + "\n")
        self.assertEqual(verify.rows_of(text.getvalue()), {"a": {"key": "a", "n": 2}})


if __name__ == "__main__":
    unittest.main()
