#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measurements fed as arrays, compared with the same ones read from a log."""
import pathlib
import tempfile
import unittest

import numpy as np

import support
import waymark

GPS_ROBOT = support.ROOT / "docs" / "tutorials" / "gps_robot"
SENSORS = """
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5 }
  - { name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0.5] }
"""
LOG = f"""
source:
  plugin: csv
  files:
    - {{ path: {GPS_ROBOT}/wheels.csv, sensor: wheels, payload: WheelSpeeds, time: t, columns: {{ left_mps: left, right_mps: right }} }}
    - {{ path: {GPS_ROBOT}/gps.csv, sensor: gps, payload: GnssFix, time: t, columns: {{ latitude_deg: lat, longitude_deg: lon }} }}
""" + SENSORS
SCANS = """
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors:
  - { name: wheels, plugin: odometry, model: twist }
  - { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0, 0, 0.3] } }
maps: [{ name: room, plugin: occupancy_grid, inputs: [lidar] }]
"""


def stamps_of(file):
    """Stamps as integers: seconds since 1970 with decimals do not fit into a double."""
    texts = [line.split(",")[0] for line in file.read_text().splitlines()[1:]]
    return np.array([int(t.split(".")[0]) * 10**9 + int(t.split(".")[1].ljust(9, "0")) for t in texts], dtype=np.int64)


def column(file, place):
    return np.loadtxt(file, delimiter=",", skiprows=1, usecols=place)


class Blocks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.wheels, cls.gps = GPS_ROBOT / "wheels.csv", GPS_ROBOT / "gps.csv"
        cls.log = waymark.Robot(yaml=LOG).play().finish().trajectory
        cls.t_wheels, cls.t_gps = stamps_of(cls.wheels), stamps_of(cls.gps)
        cls.left, cls.right = column(cls.wheels, 1), column(cls.wheels, 2)
        cls.latitude, cls.longitude = column(cls.gps, 1), column(cls.gps, 2)

    def feed(self, robot, a, b):
        """All measurements stamped from a to before b."""
        w = (a <= self.t_wheels) & (self.t_wheels < b)
        g = (a <= self.t_gps) & (self.t_gps < b)
        robot.feed("wheels", self.t_wheels[w], left_mps=self.left[w], right_mps=self.right[w])
        robot.feed("gps", self.t_gps[g], latitude_deg=self.latitude[g], longitude_deg=self.longitude[g])

    def test_give_the_bytes_of_the_log(self):
        robot = waymark.Robot(yaml=SENSORS)
        self.feed(robot, 0, 2**62)
        self.assertEqual(robot.waiting, len(self.t_wheels) + len(self.t_gps))
        self.assertEqual(robot.play().finish().trajectory.tobytes(), self.log.tobytes())

    def test_of_a_second_each_give_the_same(self):
        robot = waymark.Robot(yaml=LOG, feed=True)  # its source is ignored
        first = int(self.t_wheels[0])
        snapshots = 0
        for second in range(400):
            self.feed(robot, first + second * 10**9, first + (second + 1) * 10**9)
            snapshots += sum(1 for _ in robot)
        self.assertEqual(robot.finish().trajectory.tobytes(), self.log.tobytes())
        snapshots += sum(1 for _ in robot)  # the newest measurement waits for the next one, or for the end
        self.assertEqual(snapshots, len(self.t_wheels) + len(self.t_gps))

    def test_single_measurements(self):
        robot = waymark.Robot(yaml=SENSORS.replace("model: differential, track_m: 0.5", "model: twist") +
                              "initial: { x_m: 0, y_m: 0, yaw_deg: 0 }\n")
        for k in range(100):
            robot.feed("wheels", (k + 1) * 10**8, v_x_mps=1.0, w_z_radps=0.0)
            snapshot = robot.step()
        self.assertAlmostEqual(snapshot.position[0], 9.9, delta=0.2)
        now = robot.front(snapshot.stamp_ns + 5 * 10**7)
        self.assertAlmostEqual(now.position[0], snapshot.position[0] + 0.05, delta=0.01)

    def test_are_copied(self):
        robot, left = waymark.Robot(yaml=SENSORS), self.left.copy()
        robot.feed("wheels", self.t_wheels, left_mps=left, right_mps=self.right)
        robot.feed("gps", self.t_gps, latitude_deg=self.latitude, longitude_deg=self.longitude)
        left[:] = 0
        self.assertEqual(robot.play().finish().trajectory.tobytes(), self.log.tobytes())


class Lists(unittest.TestCase):
    def test_scans_as_two_dimensional_array_and_as_list(self):
        def drawn(ranges):
            robot = waymark.Robot(yaml=SCANS)
            stamps = np.arange(1, 41) * 10**8
            robot.feed("wheels", stamps, v_x_mps=0.5, w_z_radps=0.0)
            robot.feed("lidar", stamps[::4], start_rad=-np.pi, step_rad=2 * np.pi / 360, ranges_m=ranges)
            robot.play()
            return robot.grid()

        ranges = np.full((10, 360), 3.0)
        grid = drawn(ranges)
        self.assertGreater(np.nanmax(grid.probability), 0.6)
        np.testing.assert_array_equal(grid.cells, drawn(list(ranges)).cells)

    def test_of_elements(self):
        yaml = """
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors:
  - { name: wheels, plugin: odometry, model: twist }
  - { name: tags, payload: LandmarkObservations, base_T_sensor: { xyz_m: [0, 0, 0] } }
maps:
  - { name: posts, plugin: feature_map, inputs: [tags], noise: { range_m: 0.05, bearing_deg: 1, tangential_m: 0.03 }, existence: { view_range_m: 20, view_half_angle_deg: 180 } }
"""
        robot = waymark.Robot(yaml=yaml)
        stamps = np.arange(1, 101) * 10**8
        x = 0.05 * np.arange(100)
        posts = np.array([[8.0, 3.0], [6.0, -4.0]])
        ranges = [np.hypot(posts[:, 0] - p, posts[:, 1]) for p in x]
        bearings = [np.arctan2(posts[:, 1], posts[:, 0] - p) for p in x]
        ranges[50], bearings[50] = [], []  # nothing seen is an observation, too
        robot.feed("wheels", stamps, v_x_mps=0.5, w_z_radps=0.0)
        robot.feed("tags", stamps, range_m=ranges, bearing_rad=bearings)
        robot.play()
        found = robot.landmarks("posts")
        self.assertEqual(len(found), 2)
        for post in posts:
            self.assertLess(np.min(np.hypot(*(found.position - post).T)), 0.5)


class Invalid(unittest.TestCase):
    def setUp(self):
        self.robot = waymark.Robot(yaml=SENSORS)
        self.stamps = np.arange(3) * 10**8
        self.good = {"left_mps": np.ones(3), "right_mps": np.ones(3)}

    def refuses(self, text, sensor="wheels", stamps=None, error=waymark.DataError, **columns):
        with self.assertRaisesRegex(error, text):
            self.robot.feed(sensor, self.stamps if stamps is None else stamps, **columns)
        self.assertEqual(self.robot.waiting, 0)

    def test_names(self):
        self.refuses('feed "weels": is not a sensor', "weels", **self.good)
        self.refuses('WheelSpeeds has no field "left"', payload="WheelSpeeds", left=1, right=1)
        self.refuses('did you mean "left_mps"', payload="WheelSpeeds", left_mp=1, right_mps=1)
        self.refuses("WheelSpeeds needs right_mps", payload="WheelSpeeds", left_mps=np.ones(3))
        self.refuses('"WheelSpeed" is no known payload; there are WheelSpeeds', payload="WheelSpeed", **self.good)
        self.refuses("no payload has just these fields: left_mps", left_mps=np.ones(3))
        self.refuses("several payloads have these fields: height_m", height_m=np.ones(3))

    def test_sizes(self):
        self.refuses("left_mps: 2 values for 3 stamps", left_mps=np.ones(2), right_mps=np.ones(3))
        self.refuses("2 arrivals for 3 stamps", arrivals_ns=self.stamps[:2], **self.good)
        self.refuses("ranges_m: 2 arrays for 3 stamps", payload="LaserScan", start_rad=0, step_rad=0.1, ranges_m=np.ones((2, 9)))

    def test_values_name_their_row(self):
        self.refuses("row 1: left_mps is not finite", left_mps=[1, np.nan, 1], right_mps=np.ones(3))
        self.refuses(r"row 2: arrives at 0\.1.* before the row that precedes it \(0\.2", stamps=self.stamps[[0, 2, 1]], **self.good)
        self.refuses("left_mps: expected numbers", left_mps=["a", "b", "c"], right_mps=np.ones(3))
        self.refuses('type: "rtk" is none of none, single', "gps", latitude_deg=1.0, longitude_deg=2.0, type="rtk")
        self.refuses("satellites: expected integers", "gps", latitude_deg=1.0, longitude_deg=2.0, satellites=[1.5, 2, 3])

    def test_stamps_are_integers(self):
        self.refuses("float64; expected int64 nanoseconds", stamps=self.stamps * 1e-9, error=TypeError, **self.good)

    def test_a_robot_with_a_log_is_not_fed(self):
        with self.assertRaisesRegex(waymark.DataError, "feed=True"):
            waymark.Robot(yaml=LOG).feed("wheels", self.stamps, **self.good)


if __name__ == "__main__":
    unittest.main()
