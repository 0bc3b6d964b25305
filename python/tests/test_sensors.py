#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sensors written in Python, in the YAML of a robot."""
import os
import tempfile
import unittest

import numpy as np

import support
import waymark

BEACONS = np.array([[0.0, 12.0], [14.0, -6.0], [-9.0, -7.0]])


def skew(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


class RangeUpdate(waymark.Update):
    observes = "position"

    def __init__(self, range_m, beacon, arm, sigma_m):
        self.range_m, self.beacon, self.arm, self.sigma_m = range_m, beacon, arm, sigma_m

    def linearize(self, state):
        arm = state.R @ self.arm
        d = (state.position + arm)[:2] - self.beacon
        expected = np.hypot(*d)
        unit = np.array([*(d / expected), 0.0])
        return dict(residual=self.range_m - expected, R=self.sigma_m**2, position=unit, attitude=-unit @ skew(arm))


@waymark.sensor("test_ranges")
class Ranges(waymark.Sensor):
    payload = "Ranges"
    is_absolute = True

    def __init__(self, config):
        self.sigma_m = config.positive("sigma_m", unit="m", meaning="noise of a range")
        self.arm = config.numbers("base_p_antenna_m", 3, unit="m", meaning="antenna in the base frame")
        self.count = 0
        self.accepted = []

    def process(self, measurement, prediction, out):
        self.count += 1
        for one in measurement.ranges:
            if one.range_m > 1000:
                raise waymark.DataError(f"a range of {one.range_m} m; expected up to 1000")
            out.add(self.update(one.range_m, BEACONS[one.beacon]))

    def update(self, range_m, beacon):
        return RangeUpdate(range_m, beacon, self.arm, self.sigma_m)

    def outcome(self, update, innovation, S, nis, accepted):
        self.accepted.append(accepted)

    def save(self):
        return str(self.count).encode()

    def load(self, state):
        self.count = int(state)


@waymark.sensor("test_numerical_ranges")
class NumericalRanges(Ranges):
    def update(self, range_m, beacon):
        h = lambda state: np.hypot(*((state.position + state.R @ self.arm)[:2] - beacon))
        return waymark.NumericalUpdate(range_m, h, self.sigma_m**2, observes="position")


@waymark.sensor("test_offset_ranges")
class OffsetRanges(Ranges):
    block = [dict(name="offset_m", initial_sigma=2.0)]

    def update(self, range_m, beacon):
        h = lambda state: np.hypot(*((state.position + state.R @ self.arm)[:2] - beacon)) + state.block[0]
        return waymark.NumericalUpdate(range_m, h, self.sigma_m**2, observes="position")


@waymark.sensor("test_wrong")
class Wrong(Ranges):
    def update(self, range_m, beacon):
        return waymark.NumericalUpdate(range_m, lambda state: state.no_such_thing, 1.0)


def yaml(cls, more=""):
    return f"""
initial: {{ x_m: 0, y_m: 0, yaw_deg: 0, position_sigma_m: 0.5, yaw_sigma_deg: 5 }}
sensors:
  - {{ name: wheels, plugin: odometry, model: twist }}
  - {{ name: radio, plugin: python_sensor, class: {cls}, sigma_m: 0.1, base_p_antenna_m: [0.2, 0.1, 0.5] }}
filter: {{ seed: 1 }}
{more}"""


def circle(seed=1, count=600, offset=0.0):
    """Stamps, true poses, twists with a wrong speed, ranges of the three beacons."""
    random = np.random.default_rng(seed)
    t = 0.1 * np.arange(1, count + 1)
    yaw = 0.2 * t
    x, y = np.sin(yaw) / 0.2, (1 - np.cos(yaw)) / 0.2
    arm = np.array([0.2 * np.cos(yaw) - 0.1 * np.sin(yaw), 0.2 * np.sin(yaw) + 0.1 * np.cos(yaw)]).T
    antenna = np.column_stack([x, y]) + arm
    ranges = np.hypot(*(antenna[:, None, :] - BEACONS).transpose(2, 0, 1)) + random.normal(0, 0.1, (count, 3)) + offset
    stamps = np.round(t * 1e9).astype(np.int64)
    return stamps, np.column_stack([x, y, yaw]), ranges


def drive(cls, threads=1, more="", offset=0.0, ranges_change=None):
    stamps, truth, ranges = circle(offset=offset)
    if ranges_change:
        ranges_change(ranges)
    robot = waymark.Robot(yaml=yaml(cls, more), threads=threads)
    robot.feed("wheels", stamps, v_x_mps=1.1, w_z_radps=0.2)
    robot.feed("radio", stamps, beacon=np.tile(np.arange(3), (len(stamps), 1)), range_m=ranges)
    robot.play()
    return robot, truth


def last_error(robot, truth):
    return np.hypot(*(robot.trajectory.position[-1][:2] - truth[-1, :2]))


class PythonSensors(unittest.TestCase):
    def test_correct_the_pose(self):
        robot, truth = drive("test_ranges")
        self.assertLess(last_error(robot, truth), 0.3)
        without = waymark.Robot(yaml=yaml("test_ranges"), set={"sensors.radio.enabled": False}, feed=True)
        stamps, *_ = circle()
        without.feed("wheels", stamps, v_x_mps=1.1, w_z_radps=0.2)
        without.play()
        self.assertGreater(last_error(without, truth), last_error(robot, truth))
        self.assertAlmostEqual(robot.report["sensors"]["radio"]["nis_ratio"], 1.0, delta=0.3)

    def test_numerical_jacobians_give_the_same(self):
        analytic, _ = drive("test_ranges")
        numerical, _ = drive("test_numerical_ranges")
        np.testing.assert_allclose(numerical.trajectory.position, analytic.trajectory.position, atol=1e-5)

    def test_estimate_states_of_their_own(self):
        robot, truth = drive("test_offset_ranges", offset=0.8)
        self.assertEqual(robot.state_names[-1], "radio.offset_m")
        self.assertAlmostEqual(robot.front(int(robot.trajectory.stamp_ns[-1]) + 10**9).block[-1], 0.8, delta=0.3)

    def test_are_copied_for_late_measurements(self):
        stamps, _, ranges = circle()
        ends = []
        for delay_ns in (0, 250_000_000):  # the second one is processed again from before each range
            robot = waymark.Robot(yaml=yaml("test_counting"))
            robot.feed("wheels", stamps, v_x_mps=1.1, w_z_radps=0.2)
            robot.feed("radio", stamps[:-5], arrivals_ns=stamps[:-5] + delay_ns, range_m=ranges[:-5], beacon=np.tile(np.arange(3), (len(stamps) - 5, 1)))
            robot.play().finish()
            ends.append(robot.trajectory[-1].position)
        np.testing.assert_array_equal(*ends)

    def test_save_their_state_on_a_checkpoint(self):
        stamps, _, ranges = circle()

        def fed(part, robot):
            robot.feed("wheels", stamps[part], v_x_mps=1.1, w_z_radps=0.2)
            robot.feed("radio", stamps[part], range_m=ranges[part], beacon=np.tile(np.arange(3), (len(stamps[part]), 1)))
            return robot

        whole = fed(slice(None), waymark.Robot(yaml=yaml("test_counting"))).play().finish().trajectory
        with tempfile.TemporaryDirectory() as folder:
            file = folder + "/half.ckpt"
            fed(slice(0, 300), waymark.Robot(yaml=yaml("test_counting"))).play().suspend(file)
            second = fed(slice(None), waymark.Robot(yaml=yaml("test_counting"))).resume(file).play().finish().trajectory
        self.assertEqual(whole[-len(second):].tobytes(), second.tobytes())

    def test_run_in_many_threads_with_the_same_bytes(self):
        landmark_yaml = (support.ROOT / "config" / "quickstart.yaml").read_text()
        self.assertIn("    plugin: dgps\n", landmark_yaml)
        settings = {"source.duration_s": 15, "filter.particles": 40}
        text = landmark_yaml.replace("    plugin: dgps\n", "    plugin: python_sensor\n    class: test_position\n")
        runs = [waymark.Robot(yaml=text, set=settings, threads=threads).play().trajectory for threads in (1, 4)]
        self.assertGreater(np.sum(runs[0].sensor == 1), 20)
        self.assertEqual(runs[0].tobytes(), runs[1].tobytes())

    def test_unusable_measurements_are_counted(self):
        def spoil(ranges):
            ranges[100, 1] = 5000

        robot, _ = drive("test_ranges", ranges_change=spoil)
        self.assertEqual(robot.report["sensors"]["radio"]["unusable"], 1)
        self.assertIn("a range of 5000.0 m; expected up to 1000", str(robot.events))

    def test_an_exception_takes_the_sensor_out_of_service_and_names_the_place(self):
        robot, _ = drive("test_wrong")
        with self.assertRaisesRegex(waymark.RunError, r"radio.*AttributeError.*no_such_thing.*test_sensors.py:\d+"):
            robot.finish()

    def test_errors_of_the_yaml_name_the_place(self):
        with self.assertRaisesRegex(waymark.ConfigError, r'sensors.radio.class: "test_rangs" is no registered sensor; there are:.*test_ranges'):
            waymark.Robot(yaml=yaml("test_rangs"))
        with self.assertRaisesRegex(waymark.ConfigError, "sensors.radio.sigma_m: -1 must be > 0"):
            waymark.Robot(yaml=yaml("test_ranges"), set={"sensors.radio.sigma_m": -1})
        with self.assertRaisesRegex(waymark.ConfigError, 'sensors.radio.sigma: unknown key; did you mean "sigma_m"'):
            waymark.Robot(yaml=yaml("test_ranges"), set={"sensors.radio.sigma": 1})

    def test_payloads_of_plugins_are_fed_and_read(self):
        if "WAYMARK_PLUGIN_PATH" not in os.environ:
            self.skipTest("without the plugin of echo.cpp")
        seen = []

        @waymark.sensor("test_echo_reader")
        class EchoReader(waymark.Sensor):
            payload = "test/Echo@1"

            def process(self, measurement, prediction, out):
                echoes = [(one.strength, one.x_m, one.y_m, one.z_m) for one in measurement.echoes]
                seen.append((echoes, measurement.tilt_rad))

        robot = waymark.Robot(yaml="""
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors:
  - { name: wheels, plugin: odometry, model: twist }
  - { name: echo, plugin: test_echo }
  - { name: reader, plugin: python_sensor, class: test_echo_reader }
""")
        self.assertEqual(list(waymark.payloads()["test/Echo@1"]), ["strength", "x_m", "y_m", "z_m", "tilt_rad"])
        stamps = np.arange(1, 4) * 10**8
        strengths, places = [[1.0], [], [2.0, 3.0]], [[4.0], [], [5.0, 6.0]]
        robot.feed("wheels", stamps, v_x_mps=0.0, w_z_radps=0.0)
        robot.feed("reader", stamps, payload="Echo", strength=strengths, x_m=places, y_m=places, z_m=places, tilt_rad=[0.1, 0.2, 0.3])
        robot.play().finish()
        self.assertEqual(seen, [([(1, 4, 4, 4)], 0.1), ([], 0.2), ([(2, 5, 5, 5), (3, 6, 6, 6)], 0.3)])
        # Without its name: no other payload has these fields.
        again = waymark.Robot(yaml=yaml("test_echo_reader").replace(", sigma_m: 0.1, base_p_antenna_m: [0.2, 0.1, 0.5]", ""))
        again.feed("radio", stamps, strength=strengths, x_m=places, y_m=places, z_m=places, tilt_rad=0.1)
        with self.assertRaisesRegex(waymark.DataError, "y_m and strength differ in their number of elements"):
            again.feed("radio", stamps + 10**9, strength=strengths, x_m=places, y_m=[[4.0], [], [5.0]], z_m=places, tilt_rad=0.1)

    def test_keep_the_contract(self):
        stamps, _, ranges = circle(count=10)
        fields = dict(beacon=np.tile(np.arange(3), (len(stamps), 1)), range_m=ranges)
        entry = {"sigma_m": 0.1, "base_p_antenna_m": [0.2, 0.1, 0.5]}
        for cls, motion in (("test_ranges", "planar"), ("test_ranges", "spatial"), ("test_offset_ranges", "planar"),
                            ("test_counting", "spatial")):
            self.assertEqual(waymark.check_sensor(cls, entry, stamps, motion=motion, **fields), [], (cls, motion))

    def test_what_breaks_the_contract_is_named(self):
        stamps, _, ranges = circle(count=10)
        fields = dict(beacon=np.tile(np.arange(3), (len(stamps), 1)), range_m=ranges)
        entry = {"sigma_m": 0.1, "base_p_antenna_m": [0.2, 0.1, 0.5]}
        self.assertRegex(str(waymark.check_sensor("test_wrong", entry, stamps, **fields)), "no_such_thing")

        @waymark.sensor("test_wrong_jacobian")
        class WrongJacobian(Ranges):
            def update(self, range_m, beacon):
                update = super().update(range_m, beacon)
                right = update.linearize
                update.linearize = lambda state: {**right(state), "position": -right(state)["position"]}
                return update

        self.assertRegex(str(waymark.check_sensor("test_wrong_jacobian", entry, stamps, **fields)), "Jacobian|central")

        @waymark.sensor("test_forgets")
        class Forgets(Ranges):
            def load(self, state):
                pass

            def process(self, measurement, prediction, out):
                super().process(measurement, prediction, out)
                self.sigma_m *= 1.01

        self.assertRegex(str(waymark.check_sensor("test_forgets", entry, stamps, **fields)), "load")

    def test_wrong_models_are_named(self):
        for model, text in ((dict(residual=1.0), "needs residual and R"),
                            (dict(residual=1.0, R=1.0, positon=[1, 0, 0]), '"positon" is none of'),
                            (dict(residual=[1.0, 2.0], R=1.0, position=[1, 0, 0]), r"position has the shape \(3\); expected \(2, 3\)"),
                            (3.0, "returns a dictionary")):
            WrongModel.model = model
            robot, _ = drive("test_wrong_model")
            self.assertRegex(str(robot.events), text)


@waymark.sensor("test_position")
class Position(waymark.Sensor):
    is_absolute = True

    def __init__(self, config):
        self.antenna = config.numbers("base_p_antenna_m", 3)
        self.sigma_m = np.hypot(config.positive("sigma_m"), config.positive("offset_sigma_m"))
        config.positive("offset_tau_s")

    def process(self, measurement, prediction, out):
        z = np.array([measurement.east_m, measurement.north_m])
        h = lambda state: (state.position + state.R @ self.antenna)[:2]
        out.add(waymark.NumericalUpdate(z, h, self.sigma_m**2, observes="position"))


@waymark.sensor("test_counting")
class Counting(Ranges):
    """Its noise depends on how many measurements it has processed, so a copy that shares that count gives another result."""

    def update(self, range_m, beacon):
        return RangeUpdate(range_m, beacon, self.arm, self.sigma_m * (1 + self.count / 100))


@waymark.sensor("test_wrong_model")
class WrongModel(Ranges):
    model = None

    def update(self, range_m, beacon):
        update = waymark.Update()
        update.linearize = lambda state: self.model
        return update


if __name__ == "__main__":
    unittest.main()
