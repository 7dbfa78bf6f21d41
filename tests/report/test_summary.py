"""The executive summary says what the rows say, and nothing else."""

import unittest
from pathlib import Path

import remarks
import samples
import summary
from rows import Row


def rows_of(found):
    return [Row(one, Path("."), number) for number, one in enumerate(found, 1)]


def finding(found, question):
    return next(
        (one for one in summary.findings(rows_of(found), []) if question in one.question), None
    )


class Answers(unittest.TestCase):
    def test_the_smallest_codec_and_the_smallest_with_random_access(self):
        found = finding(samples.whole(), "smallest")
        self.assertTrue(found.headline.startswith("small, 1.22 %"), found.headline)  # sqrt(1 * 1.5)
        text = " ".join(found.answer)
        self.assertIn("Smallest on single volumes: small on 2.", text)
        self.assertIn("With access to single voxels: slow, 3.06 %", text)  # sqrt(2.5 * 3.75)
        self.assertIn("not one of", text)
        self.assertNotIn("raw", text)

    def test_a_codec_that_was_left_out_of_a_volume_is_not_ranked(self):
        rows = (
            samples.label_rows("a", "x", 2.0, 1, None)
            + samples.label_rows("b", "x", 2.0, 1, None)
            + samples.label_rows("a", "y", 3.0, 1, None)
        )
        rows += samples.label_rows("b", "y", 3.0, 1, None) + samples.label_rows(
            "b", "tiny", 0.1, 1, None
        )
        found = finding(rows, "smallest")
        self.assertTrue(found.headline.startswith("x, 2.00 %"), found.headline)
        self.assertIn("tiny", found.evidence)

    def test_rows_with_voxels_that_differ_are_no_answer(self):
        rows = samples.label_rows("a", "wrong", 0.1, 1, None) + samples.label_rows(
            "a", "right", 2.0, 1, None
        )
        for one in rows[:2]:
            one["verification"] = {"voxels_compared": 100, "mismatches": 1}
        self.assertTrue(finding(rows, "smallest").headline.startswith("right"))
        self.assertTrue(
            any("voxels that differ" in text for text in remarks.stands_out(rows_of(rows)))
        )

    def test_the_fastest_access_with_its_interval_size_and_error(self):
        found = finding(samples.whole(), "random access")
        self.assertTrue(found.headline.startswith("fast, 10.0 ns"), found.headline)
        text = " ".join(found.answer)
        self.assertIn(
            "Cost of fast in size: 8.00 to 12.0 % of the original. Cost in error: none.", text
        )
        self.assertIn("interval is apart from the next one's on 2", text)
        self.assertIn("A plain array takes 5.00 ns", text)
        self.assertIn("n = 9", found.details[0])

    def test_overlapping_intervals_are_not_called_apart(self):
        rows = samples.label_rows("a", "x", 2.0, 1, 10.0) + samples.label_rows(
            "a", "y", 2.0, 1, 10.5
        )
        self.assertIn(
            "apart from the next one's on 0", " ".join(finding(rows, "random access").answer)
        )

    def test_the_cache_mode_with_what_it_costs(self):
        found = finding(samples.whole(), "access mode")
        self.assertEqual(
            found.headline,
            "fixed view: voxel; path from an empty cache: voxel, exact in every frame",
        )
        text = " ".join(found.answer)
        self.assertIn("1/4.00 of the time without a cache", text)
        self.assertIn("Exact in the first frame from an empty cache: none, voxel.", text)
        self.assertIn("brick shows placeholders and converges after up to 3 frames", text)
        self.assertIn("brick 28 % of the pixels wrong (17.5 dB)", text)
        self.assertIn("llvmpipe", found.evidence)

    def test_a_mode_that_shows_stand_ins_is_not_recommended_for_moving_views(self):
        rows = [
            samples.drawn("a", "c", cache, ms)
            for cache, ms in (("none", 9.0), ("voxel", 5.0), ("brick", 1.0))
        ]
        found = finding(rows, "access mode")
        self.assertEqual(
            found.headline,
            "fixed view: brick; path from an empty cache: voxel, exact in every frame",
        )
        text = " ".join(found.answer)
        self.assertIn("Fastest, path from an empty cache: brick in 1 of 1", text)
        self.assertIn(
            "Of the modes that are exact in every frame, fastest, path from an empty cache: voxel in 1 of 1",
            text,
        )

    def test_coarser_pictures_are_not_compared_with_exact_ones(self):
        rows = [
            samples.drawn("a", "c", "none", 5.0),
            samples.drawn("a", "c", "voxel", 1.0, render={"lod_bias": 2.0}),
        ]
        self.assertIsNone(finding(rows, "access mode"))

    def test_modes_that_draw_wrong_pixels_are_not_compared(self):
        wrong = samples.drawn("a", "c", "voxel-es-paper", 1.0)
        wrong["verification"]["label_mismatches"] = 3
        rows = [samples.drawn("a", "c", "none", 5.0), samples.drawn("a", "c", "voxel", 2.0), wrong]
        self.assertTrue(finding(rows, "access mode").headline.startswith("fixed view: voxel;"))

    def test_lossy_codecs_by_their_front(self):
        found = finding(samples.whole(), "lossy codec, and")
        self.assertIn("lossy 1.60 to 3.20 bits/voxel, 30.0 to 36.0 dB", " ".join(found.answer))

    def test_nothing_is_said_without_rows(self):
        self.assertEqual(summary.findings([], []), [])
        self.assertEqual(len(summary.unanswered([])), 3)
        self.assertEqual(summary.unanswered(summary.findings(rows_of(samples.whole()), [])), [])

    def test_failures_are_counted(self):
        text = " ".join(remarks.stands_out(rows_of(samples.whole())))
        self.assertIn("1 cell without a result that should have one: 1 data-missing.", text)
        self.assertIn("1 cell unsupported", text)


if __name__ == "__main__":
    unittest.main()
