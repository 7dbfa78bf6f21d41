"""Rows and quantities: what is read, what counts, and intervals."""

import json
import math
import tempfile
import unittest
from pathlib import Path

import samples
from estimates import (
    Estimate,
    access_ns,
    geometric_mean,
    interval_rank,
    median_of,
    path_ms,
    speed,
    spell,
    spell_estimate,
    warm_ms,
)
from history import objects_in, steps_table
from rows import Row, load, varying_parameters


class Loading(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = Path(self.folder.name)

    def test_a_torn_last_line_is_counted_and_left_out(self):
        results = load([samples.write(self.path, [samples.row("a", "c", "encode")], torn=True)])
        self.assertEqual(len(results.rows), 1)
        self.assertEqual(results.sources[0].unreadable, [2])

    def test_what_is_no_object_and_bytes_that_are_no_text_are_left_out(self):
        samples.write(self.path, [samples.row("a", "c", "encode")])
        with (self.path / "rows.jsonl").open("ab") as file:
            file.write(b'[1, 2]\n"text"\n\xff\xfe{\n\n')
        results = load([self.path])
        self.assertEqual(len(results.rows), 1)
        self.assertEqual(results.sources[0].unreadable, [2, 3, 4])

    def test_the_last_row_of_a_cell_counts(self):
        rows = [samples.row("a", "c", "encode", size=samples.sized(rate)) for rate in (5.0, 6.0)]
        results = load([samples.write(self.path, rows)])
        self.assertEqual([row.number("size/rate") for row in results.rows], [6.0])
        self.assertEqual(results.superseded, 1)

    def test_of_two_folders_the_later_measurement_counts(self):
        new = samples.write(
            self.path / "new",
            [
                samples.row(
                    "a", "c", "encode", measured="2026-02-01T00:00:00Z", size=samples.sized(2.0)
                )
            ],
        )
        old = samples.write(
            self.path / "old",
            [
                samples.row(
                    "a", "c", "encode", measured="2026-01-01T00:00:00Z", size=samples.sized(1.0)
                )
            ],
        )
        self.assertEqual([row.number("size/rate") for row in load([new, old]).rows], [2.0])

    def test_machines_and_devices_are_never_one_row(self):
        rows = [samples.row("a", "c", "encode", machine=machine) for machine in ("m1", "m2", "m2")]
        results = load([samples.write(self.path, rows)])
        self.assertEqual(len(results.rows), 2)
        self.assertEqual(
            {machine: len(results.of(machine)) for machine in results.machines}, {"m1": 1, "m2": 1}
        )
        other = samples.drawn("a", "c", "none", 1.0)
        other["device"] = dict(other["device"], name="another")
        self.assertEqual(
            len(
                load([samples.write(self.path, [samples.drawn("a", "c", "none", 1.0), other])]).rows
            ),
            2,
        )

    def test_nulls_infinities_and_wrong_kinds_read_as_none(self):
        row = Row(
            {
                "a": None,
                "b": float("inf"),
                "c": True,
                "d": "5",
                "e": {"f": 2},
                "dataset": [],
                "codec": {"parameters": None},
            },
            Path("."),
            1,
        )
        for path in ("a", "b", "c", "d", "e", "e/f/g", "missing/x"):
            self.assertIsNone(row.number(path), path)
        self.assertEqual(row.number("e/f"), 2.0)
        self.assertEqual(
            (row.dataset, row.parameters, row.extent, row.codec, row.threads),
            ("unknown", {}, "", "unknown", 0),
        )

    def test_a_folder_without_rows_is_told(self):
        self.assertEqual(load([self.path]).sources[0].note, "no rows.jsonl")

    def test_only_parameters_that_vary_name_a_codec(self):
        rows = [
            Row(
                samples.row("a", "c", "encode", parameters={"brick": brick, "delta": "0"}),
                Path("."),
                1,
            )
            for brick in ("16", "32")
        ]
        self.assertEqual(varying_parameters(rows), {"c": {"brick"}})


class Estimates(unittest.TestCase):
    def test_ranks_are_those_of_order_statistics(self):
        # David and Nagaraja: the largest k with 1 - 2 P[Binomial(n, 1/2) < k] >= 0.95; 6 is the
        # least n that has one.
        self.assertEqual(
            [interval_rank(n) for n in (1, 5, 6, 8, 9, 11, 12, 20, 100)],
            [1, 1, 1, 1, 2, 2, 3, 6, 40],
        )

    def test_intervals_by_number_of_samples(self):
        self.assertIsNone(median_of([]))
        self.assertEqual(median_of([3.0, 1.0]), Estimate(2.0, None, None, 2))
        self.assertEqual(median_of([3.0, 1.0, 2.0]), Estimate(2.0, 1.0, 3.0, 3))
        self.assertEqual(median_of(range(9)), Estimate(4.0, 1.0, 7.0, 9))
        self.assertEqual(median_of([1, None, "x", math.nan, 3, 2]), Estimate(2.0, 1.0, 3.0, 3))

    def test_speed_turns_the_interval_over(self):
        row = Row(
            samples.row(
                "a", "c", "encode", edge=100, time={"seconds": {"samples": [0.5, 1.0, 2.0]}}
            ),
            Path("."),
            1,
        )
        self.assertEqual(speed(row), Estimate(1.0, 0.5, 2.0, 3))

    def test_access_is_of_uniform_points_at_the_finest_level(self):
        access = [
            {"points": points, "lod": lod, "ns_per_voxel": {"samples": [value] * 3}}
            for points, lod, value in (
                ("clustered", 0, 1.0),
                ("uniform", 1, 2.0),
                ("uniform", 0, 3.0),
            )
        ]
        found = access_ns(Row({"access": access}, Path("."), 1))
        self.assertEqual(found and found.value, 3.0)

    def test_frames_are_of_the_rounds_after_the_first(self):
        row = Row(samples.drawn("a", "c", "none", 10.0), Path("."), 1)
        held = warm_ms(row)
        self.assertEqual((held.value, held.low, held.high, held.n), (10.0, 9.0, 11.0, 4))
        path = path_ms(row)
        self.assertEqual((path.value, path.low, path.n), (20.0, None, 1))

    def test_apart_needs_two_intervals(self):
        self.assertTrue(Estimate(1, 0.9, 1.1, 9).apart(Estimate(2, 1.9, 2.1, 9)))
        self.assertFalse(Estimate(1, 0.9, 1.95, 9).apart(Estimate(2, 1.9, 2.1, 9)))
        self.assertFalse(Estimate(1).apart(Estimate(2, 1.9, 2.1, 9)))

    def test_numbers_are_spelt_with_significant_digits(self):
        self.assertEqual(
            [spell(x) for x in (0, 0.08621, 1.0, 11.64, 1594.2, 123456.0, None)],
            ["0", "0.0862", "1.00", "11.6", "1,594", "123,456", ""],
        )
        self.assertEqual(
            spell_estimate(Estimate(14.2, 13.0, 15.1, 9), "ns"), "14.2 ns [13.0, 15.1], n = 9"
        )
        self.assertIsNone(geometric_mean([1.0, 0.0]))
        self.assertAlmostEqual(geometric_mean([1.0, 100.0]) or 0, 10.0)


class History(unittest.TestCase):
    STEP = {
        "time": "2026-01-02",
        "revision": "b",
        "previous": "a",
        "machine": "m",
        "key": "k",
        "quantity": "encode",
        "before": "1 s",
        "after": "2 s",
        "ratio": 2.0,
        "worse": True,
        "last": True,
    }

    def test_objects_on_one_line_or_several_are_read(self):
        text = json.dumps(self.STEP) + "\n" + json.dumps(self.STEP, indent=2) + "\n{broken"
        self.assertEqual(objects_in(text), [self.STEP, self.STEP])

    def test_steps_are_of_one_machine(self):
        table = steps_table([self.STEP, dict(self.STEP, machine="other")], "m")
        self.assertEqual(
            [[cell.text for cell in line][-2:] for line in table.lines], [["+100.0", "worse"]]
        )
        self.assertIsNone(steps_table([self.STEP], "elsewhere"))


if __name__ == "__main__":
    unittest.main()
