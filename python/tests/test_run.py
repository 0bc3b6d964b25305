#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs and steps of a robot on its log, compared with `waymark run`."""
import pathlib
import signal
import tempfile
import threading
import time
import unittest

import numpy as np

import support
import waymark
from support import QUICKSTART, SHORT


class Run(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.out = pathlib.Path(cls.folder.name)
        support.run_command(QUICKSTART, cls.out / "command", SHORT, "--seed", "3")
        cls.result = waymark.run(QUICKSTART, set=SHORT, seed=3, out=cls.out / "python")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_writes_the_same_bytes_as_the_command(self):
        for name in ("trajectory.txt", "path.txt", "covariance.csv", "landmarks.csv", "reference.txt"):
            self.assertEqual((self.out / "command" / name).read_bytes(), (self.out / "python" / name).read_bytes(), name)

    def test_trajectory_has_the_rows_of_the_file(self):
        self.assertEqual(support.tum_lines(self.result.trajectory), support.rows_of(self.out / "command" / "trajectory.txt"))

    def test_path_has_the_rows_of_the_file(self):
        self.assertEqual(support.tum_lines(self.result.path), support.rows_of(self.out / "command" / "path.txt"))

    def test_covariance_of_mapping_steps_is_that_of_the_file(self):
        rows = np.loadtxt(self.out / "command" / "covariance.csv", delimiter=",", skiprows=1)
        mapped = self.result.trajectory[self.result.trajectory.fate == waymark.FATES.index("mapped")]
        P = mapped.covariance[-1]
        self.assertTrue(np.allclose(rows[-1, 1:], [P[0, 0], P[0, 1], P[0, 2], P[1, 1], P[1, 2], P[2, 2]], rtol=1e-6, atol=0))

    def test_landmarks_are_those_of_the_file(self):
        rows = np.genfromtxt(self.out / "command" / "landmarks.csv", delimiter=",", names=True)
        landmarks = self.result.landmarks("pillars")
        order = np.argsort(landmarks.id)
        self.assertTrue(np.allclose(landmarks.position[order, 0], rows["east_m"][np.argsort(rows["id"])], atol=1e-5))
        self.assertTrue(np.allclose(landmarks.covariance[order, 1, 1], rows["var_north_m2"][np.argsort(rows["id"])], rtol=1e-4))

    def test_particles_have_normalised_weights(self):
        self.assertEqual(len(self.result.particles), 25)
        self.assertAlmostEqual(self.result.particles.weight.sum(), 1.0, places=12)

    def test_does_not_depend_on_threads_and_needs_no_folder(self):
        again = waymark.run(QUICKSTART, set=SHORT, seed=3, threads=3)
        self.assertEqual(again.trajectory.tobytes(), self.result.trajectory.tobytes())
        self.assertIsNone(again.out)

    def test_another_seed_gives_another_result(self):
        other = waymark.run(QUICKSTART, set=SHORT, seed=4)
        self.assertNotEqual(other.trajectory.tobytes(), self.result.trajectory.tobytes())

    def test_counts_measurements(self):
        self.assertEqual(sum(s["measurements"] for s in self.result.sensors.values()), len(self.result.trajectory))

    def test_reference_of_the_simulator(self):
        self.assertEqual(support.tum_lines(self.result.reference), support.rows_of(self.out / "command" / "reference.txt"))


class Steps(unittest.TestCase):
    def test_give_the_rows_of_a_run(self):
        whole = waymark.run(QUICKSTART, set=SHORT, seed=3)
        robot = waymark.Robot(QUICKSTART, set=SHORT, seed=3)
        snapshots = list(robot)
        self.assertEqual(robot.trajectory.tobytes(), whole.trajectory.tobytes())
        self.assertTrue(robot.is_finished)
        last, row = snapshots[-1], whole.trajectory[-1]
        self.assertEqual((last.stamp_ns, last.yaw), (row.stamp_ns, row.yaw))
        np.testing.assert_array_equal(last.position, row.position)
        np.testing.assert_array_equal(last.pose_covariance, row.covariance)
        self.assertEqual(last.covariance.shape, (len(robot.state_names),) * 2)

    def test_show_the_maps_as_they_grow(self):
        robot = waymark.Robot(QUICKSTART, set=SHORT)
        counts = []
        for snapshot in robot:
            if snapshot.fate == "mapped":
                counts.append(len(robot.landmarks()))
        self.assertLess(counts[0], counts[-1])

    def test_may_be_mixed_with_play(self):
        robot = waymark.Robot(QUICKSTART, set=SHORT, seed=3)
        for _ in range(100):
            robot.step()
        result = robot.play().finish()
        self.assertEqual(result.trajectory.tobytes(), waymark.run(QUICKSTART, set=SHORT, seed=3).trajectory.tobytes())
        self.assertFalse(result.report["failures"])

    def test_with_latency_deliver_all_snapshots(self):
        settings = SHORT | {"filter.max_latency_s": 0.5}
        robot = waymark.Robot(QUICKSTART, set=settings)
        count = sum(1 for _ in robot)
        self.assertEqual(count, sum(s["measurements"] for s in robot.report["sensors"].values()))

    def test_go_on_from_a_checkpoint(self):
        whole = waymark.run(QUICKSTART, set=SHORT, seed=3)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "half.ckpt"
            first = waymark.Robot(QUICKSTART, set=SHORT, seed=3, until_s=20).play().suspend(file)
            robot = waymark.Robot(QUICKSTART, set=SHORT, seed=3).resume(file)
            second = robot.play().finish()
        self.assertGreater(len(second.trajectory), 100)
        self.assertEqual(first.trajectory.tobytes() + second.trajectory.tobytes(), whole.trajectory.tobytes())
        self.assertEqual(second.path.tobytes(), whole.path.tobytes())

    def test_dense_map(self):
        robot = waymark.Robot(support.ROOT / "config" / "indoor.yaml", until_s=15)
        robot.play()
        grid = robot.grid()
        self.assertEqual(grid.cells.dtype, np.uint8)
        self.assertEqual(grid.probability.shape, grid.cells.shape)
        self.assertGreater(np.nanmax(grid.probability), 0.8)
        self.assertLess(np.nanmin(grid.probability), 0.3)
        left, right, bottom, top = grid.extent
        x, y = robot.trajectory.position[-1][:2]
        self.assertTrue(left < x < right and bottom < y < top)


class Errors(unittest.TestCase):
    def test_of_the_yaml_are_exceptions_with_their_text(self):
        with self.assertRaisesRegex(waymark.ConfigError, r'filter.partciles: unknown key; did you mean "particles"\?'):
            waymark.run(QUICKSTART, set={"filter.partciles": 3})
        with self.assertRaisesRegex(waymark.PluginError, 'plugin "gsp" is not found'):
            waymark.run(QUICKSTART, set={"sensors.gps.plugin": "gsp"})
        with self.assertRaisesRegex(waymark.Error, "no_such.yaml"):
            waymark.run("no_such.yaml")

    def test_of_a_run_have_its_result(self):
        yaml = """
source: { plugin: csv, files: [{ path: no.csv, sensor: wheels, payload: BodyTwist, time: t }] }
sensors: [{ name: wheels, plugin: odometry, model: twist }]
"""
        with self.assertRaises(waymark.Error):
            waymark.Robot(yaml=yaml)
        robot = waymark.Robot(QUICKSTART, set=SHORT)
        with self.assertRaisesRegex(waymark.RunError, "start") as caught:
            robot.finish()  # before anything was read
        self.assertEqual(len(caught.exception.result.trajectory), 0)

    def test_maps_are_named(self):
        robot = waymark.Robot(QUICKSTART, set=SHORT)
        with self.assertRaisesRegex(waymark.Error, 'no map "pilars"; there is pillars'):
            robot.landmarks("pilars")

    def test_two_runs_in_one_folder(self):
        with tempfile.TemporaryDirectory() as out:
            robot = waymark.Robot(QUICKSTART, set=SHORT, out=out)
            with self.assertRaisesRegex(waymark.Error, out):
                waymark.Robot(QUICKSTART, set=SHORT, out=out)
            robot.finish(check=False)


class Threads(unittest.TestCase):
    def test_gil_is_released_while_the_filter_works(self):
        robot = waymark.Robot(QUICKSTART)
        worker = threading.Thread(target=robot.play)
        switches, largest, last = 0, 0.0, time.monotonic()
        worker.start()
        while worker.is_alive():
            time.sleep(0.001)
            now = time.monotonic()
            largest, last, switches = max(largest, now - last), now, switches + 1
        worker.join()
        self.assertGreater(switches, 20)  # with the GIL held it would be one or two

    def test_a_second_use_at_the_same_time_is_refused(self):
        robot = waymark.Robot(QUICKSTART)
        worker = threading.Thread(target=robot.play)
        worker.start()
        with self.assertRaisesRegex(RuntimeError, "in use by another call"):
            while worker.is_alive():
                robot.particles
        worker.join()

    def test_ctrl_c_ends_a_run_and_keeps_what_there_is(self):
        robot = waymark.Robot(QUICKSTART, set={"source.duration_s": 3000})
        before = signal.signal(signal.SIGALRM, signal.default_int_handler)
        signal.setitimer(signal.ITIMER_REAL, 1.0)
        try:
            with self.assertRaises(KeyboardInterrupt):
                robot.play()
        finally:
            signal.signal(signal.SIGALRM, before)
        self.assertGreater(len(robot.finish().trajectory), 10)


if __name__ == "__main__":
    unittest.main()
