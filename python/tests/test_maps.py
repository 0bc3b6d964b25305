#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A map module written in Python: the charging dock of docs/write_a_map_module.md."""
import unittest

import numpy as np

import waymark

DOCK = np.array([6.0, 2.0])


def log_normal(nu, S):
    return -0.5 * (nu @ np.linalg.solve(S, nu) + np.log(np.linalg.det(2 * np.pi * S)))


class DockMap(waymark.ParticleMap):
    def __init__(self, sigma_m):
        self.R, self.sightings = sigma_m**2 * np.eye(2), 0
        self.dock, self.P = np.zeros(2), 1e6 * np.eye(2)

    @staticmethod
    def view(pose, p_base):
        d = pose.R[:2, :2] @ p_base
        return pose.position[:2] + d, np.array([[1, 0, -d[1]], [0, 1, d[0]]])

    def refine(self, pose, P, start, observation):
        if self.sightings == 0:
            return None
        p_map, G = self.view(pose, observation)
        nu, noise = self.dock - p_map, self.P + self.R
        W = np.linalg.inv(noise)
        return dict(information=G.T @ W @ G, gradient=G.T @ W @ nu, log_evidence=log_normal(nu, G @ P @ G.T + noise))

    def insert(self, pose, P, observation, association):
        p_map, G = self.view(pose, observation)
        K = self.P @ np.linalg.inv(self.P + self.R + G @ P @ G.T)
        self.dock = self.dock + K @ (p_map - self.dock)
        self.P = self.P - K @ self.P
        self.sightings += 1

    def landmarks(self):
        return [dict(id=0, position=self.dock, covariance=self.P, sightings=self.sightings)] if self.sightings else []

    def figures(self):
        return {"sightings": self.sightings}

    def save(self):
        return np.array([self.sightings, *self.dock, *self.P.flat]).tobytes()

    def load(self, state):
        if len(state) != 7 * 8:
            raise waymark.DataError("a dock has seven numbers")
        numbers = np.frombuffer(state)
        self.sightings, self.dock, self.P = int(numbers[0]), numbers[1:3].copy(), numbers[3:].reshape(2, 2).copy()
        return self


@waymark.map_module("test_dock")
class DockModule(waymark.MapModule):
    payload = "LandmarkObservations"

    def __init__(self, config):
        self.sigma_m = config.positive("sigma_m")

    def create_map(self):
        return DockMap(self.sigma_m)

    def load_map(self, state):
        return self.create_map().load(state)

    def extract(self, measurement, companions, motion):
        if not measurement.landmarks:
            return None
        one = measurement.landmarks[0]
        p = np.array([one.range_m * np.cos(one.bearing_rad), one.range_m * np.sin(one.bearing_rad), 0, 1])
        return (self.T_base_sensor @ p)[:2]


YAML = """
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors:
  - { name: wheels, plugin: odometry, model: twist }
  - { name: camera, payload: LandmarkObservations, base_T_sensor: { xyz_m: [0.1, 0, 0.3] } }
maps: [{ name: dock, plugin: python_map, class: test_dock, inputs: [camera], sigma_m: 0.05 }]
filter: { particles: 20, seed: 1 }
"""


def drive(threads, cls="test_dock"):
    robot = waymark.Robot(yaml=YAML.replace("test_dock", cls), threads=threads)
    random = np.random.default_rng(1)
    t = 0.1 * np.arange(1, 301)
    yaw = 0.4 * t
    x, y = np.sin(yaw) / 0.4, (1 - np.cos(yaw)) / 0.4
    camera = np.column_stack([x + 0.1 * np.cos(yaw), y + 0.1 * np.sin(yaw)])
    d = DOCK - camera
    ranges = np.hypot(*d.T) + random.normal(0, 0.03, len(t))
    bearings = np.arctan2(d[:, 1], d[:, 0]) - yaw + random.normal(0, 0.005, len(t))
    stamps = np.round(t * 1e9).astype(np.int64)
    robot.feed("wheels", stamps, v_x_mps=1.0 + random.normal(0, 0.05, len(t)), w_z_radps=0.4 + random.normal(0, 0.02, len(t)))
    seen = np.arange(len(t)) % 5 == 0
    robot.feed("camera", stamps[seen], range_m=ranges[seen][:, None], bearing_rad=bearings[seen][:, None])
    robot.play()
    return robot, np.array([x[-1], y[-1]])


def violations(cls):
    """Of the contract, on a drive of 1 m along x."""
    x = np.linspace(0, 1, 20)
    stamps = np.round(1e9 * np.arange(1, 21)).astype(np.int64)
    mounting = np.eye(4)
    mounting[:3, 3] = 0.1, 0, 0.3
    return waymark.check_map_module(cls, {"inputs": ["camera"], "sigma_m": 0.05}, stamps, np.column_stack([x, 0 * x, 0 * x]),
                                    T_base_sensor=mounting, range_m=5 - x[:, None], bearing_rad=np.full((20, 1), 0.3))


class PythonMaps(unittest.TestCase):
    def test_keep_the_contract(self):
        self.assertEqual(violations("test_dock"), [])

    def test_what_breaks_the_contract_is_named(self):
        class Leaky(DockMap):
            def refine(self, pose, P, start, observation):
                self.dock = self.dock + 1e-3
                return super().refine(pose, P, start, observation)

        @waymark.map_module("test_leaky_dock")
        class LeakyModule(DockModule):
            def create_map(self):
                return Leaky(self.sigma_m)

        self.assertRegex(str(violations("test_leaky_dock")), "refine")

    def test_find_the_dock_and_keep_the_pose(self):
        robot, end = drive(1)
        dock = robot.landmarks("dock")[0]
        self.assertLess(np.hypot(*(dock.position - DOCK)), 0.3)
        self.assertLess(np.hypot(*(robot.trajectory.position[-1][:2] - end)), 0.4)
        self.assertGreater(robot.figures("dock")["sightings"], 50)
        self.assertEqual(robot.report["sensors"]["camera"]["mapped"], 60)

    def test_run_in_many_threads_with_the_same_bytes(self):
        self.assertEqual(drive(1)[0].trajectory.tobytes(), drive(4)[0].trajectory.tobytes())

    def test_an_exception_takes_the_map_out_of_service(self):
        @waymark.map_module("test_broken_dock")
        class Broken(DockModule):
            def extract(self, measurement, companions, motion):
                return measurement.no_such_field

        robot, _ = drive(1, "test_broken_dock")
        with self.assertRaisesRegex(waymark.RunError, "dock.*AttributeError.*no_such_field"):
            robot.finish()

    def test_unknown_class(self):
        with self.assertRaisesRegex(waymark.ConfigError, '"no_dock" is no registered map_module; there are:'):
            drive(1, "no_dock")


if __name__ == "__main__":
    unittest.main()
