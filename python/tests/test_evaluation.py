#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores of arrays beside those of `waymark evaluate`, and pictures."""
import pathlib
import tempfile
import unittest

import matplotlib

matplotlib.use("Agg")
import numpy as np

import support
import waymark
from support import QUICKSTART, SHORT
from waymark import plot


class Scores(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.result = waymark.run(QUICKSTART, set=SHORT, out=cls.folder.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_are_those_of_the_command(self):
        for align in ("none", "se2"):
            theirs = waymark.evaluate(self.folder.name, "--align", align)["trajectory"]
            ours = waymark.score(self.result.trajectory, self.result.reference, align=align)
            self.assertAlmostEqual(ours.rms_m, theirs["ate_horizontal_rms_m"], delta=2e-6)
            self.assertAlmostEqual(ours.max_m, theirs["ate_horizontal_max_m"], delta=2e-6)
            self.assertAlmostEqual(ours.yaw_rms_rad, theirs["yaw_rms_rad"], delta=2e-6)
            self.assertEqual(len(ours.stamp_ns), theirs["scored"])

    def test_alignment_finds_a_known_motion(self):
        turned = self.result.trajectory.copy()
        c, s = np.cos(0.3), np.sin(0.3)
        turned.position[:, :2] = turned.position[:, :2] @ np.array([[c, s], [-s, c]]) + [5, -2]
        turned.yaw += 0.3
        straight = waymark.score(self.result.trajectory, self.result.reference, align="se2")
        moved = waymark.score(turned, self.result.reference, align="se2")
        self.assertAlmostEqual(moved.rms_m, straight.rms_m, places=9)
        self.assertAlmostEqual(moved.transform[2], straight.transform[2] - 0.3, places=9)

    def test_without_a_common_time(self):
        late = self.result.reference.copy()
        late.stamp_ns += 10**15
        with self.assertRaisesRegex(waymark.Error, "no common time"):
            waymark.score(self.result.trajectory, late)

    def test_error_of_the_command_is_an_exception(self):
        with self.assertRaisesRegex(waymark.Error, "no_such_folder"):
            waymark.evaluate("no_such_folder")


class Pictures(unittest.TestCase):
    def test_of_landmarks_path_errors_and_particles(self):
        result = waymark.run(QUICKSTART, set=SHORT)
        ax = plot.overview(result)
        self.assertEqual(len(ax.collections), 1)  # the ellipses
        self.assertEqual(len(ax.collections[0].get_offsets()), len(result.landmarks()))
        for east, _ in result.landmarks().position:
            self.assertTrue(ax.get_xlim()[0] <= east <= ax.get_xlim()[1])
        plot.particles(result, ax)
        self.assertEqual(len(plot.errors(result)), 3)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "picture.png"
            ax.figure.savefig(file)
            self.assertGreater(file.stat().st_size, 5000)

    def test_of_a_grid(self):
        robot = waymark.Robot(support.ROOT / "config" / "indoor.yaml", until_s=10)
        robot.play()
        ax = plot.overview(robot)
        self.assertEqual(len(ax.images), 1)


if __name__ == "__main__":
    unittest.main()
