#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Running robots: fed through a socket by this program, and the replay of their flight records."""
import json
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import unittest

import support
import waymark
from support import QUICKSTART

PATIENCE_S = 60

ROBOT = """
source:
  plugin: json
  from: unix
  path: {socket}
  channels: [{{ sensor: wheels, payload: BodyTwist }}]
initial: {{ x_m: 0, y_m: 0, yaw_deg: 0 }}
sensors: [{{ name: wheels, plugin: odometry, model: twist }}]
sinks: [{{ plugin: tum }}]
record: {{}}
"""


def eventually(condition):
    end = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


class Wheels:
    """A robot that drives at 1 m/s, as a program that connects to the socket and sends 50 lines a second."""

    def __init__(self, path):
        self._path, self._ends = str(path), threading.Event()
        self.sent = 0
        self._thread = threading.Thread(target=self._drive)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self.end()

    def end(self):
        self._ends.set()
        self._thread.join()

    def _drive(self):
        with socket.socket(socket.AF_UNIX) as out:
            if not eventually(lambda: out.connect_ex(self._path) == 0):
                return
            while not self._ends.wait(0.02):
                line = {"sensor": "wheels", "stamp_ns": time.time_ns(), "v_x_mps": 1.0, "w_z_radps": 0.1}
                out.sendall(json.dumps(line).encode() + b"\n")
                self.sent += 1


class Live(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = pathlib.Path(folder.name)
        self.yaml = ROBOT.format(socket=self.out / "robot.sock")

    def test_the_pose_now_follows_what_arrives(self):
        with waymark.Live(yaml=self.yaml) as live, Wheels(self.out / "robot.sock"):
            self.assertTrue(eventually(lambda: live.front() is not None and live.front().position[0] > 1.0))
            front, now = live.front(), time.time_ns()
            self.assertLess(abs(now - front.stamp_ns), 2_000_000_000)
            self.assertAlmostEqual(front.velocity[0], 1.0, delta=0.1)
            self.assertEqual(front.pose_covariance.shape, (3, 3))
            self.assertTrue((front.pose_covariance == front.covariance[[[0], [1], [2]], [0, 1, 2]]).all())
            self.assertIn(live.last().fate, ("fused", "skipped"))
            self.assertTrue(eventually(lambda: live.health == "ok"), live.health_reason)
            self.assertTrue(live.is_running)
        self.assertFalse(live.is_running)

    def test_stop_gives_the_result_and_its_record_the_same_bytes_again(self):
        live = waymark.Live(yaml=self.yaml, out=self.out / "live", record=True)
        with Wheels(self.out / "robot.sock") as wheels:
            self.assertTrue(eventually(lambda: live.last() is not None and live.last().sequence >= 50))
        result = live.stop()
        self.assertTrue(50 <= result.sensors["wheels"]["measurements"] <= wheels.sent)
        trajectory = self.out / "live" / "trajectory.txt"
        self.assertEqual(support.tum_lines(result.trajectory), support.rows_of(trajectory))
        self.assertEqual(live.stop().trajectory.tobytes(), result.trajectory.tobytes())

        record = self.out / "live" / "flight.mcap"
        again = waymark.run(record, out=self.out / "python")
        support.run_command(record, self.out / "command", {})
        self.assertEqual(again.trajectory.tobytes(), result.trajectory.tobytes())
        self.assertEqual((self.out / "python" / "trajectory.txt").read_bytes(), trajectory.read_bytes())
        self.assertEqual((self.out / "command" / "trajectory.txt").read_bytes(), trajectory.read_bytes())
        other = waymark.run(record, set={"sensors.wheels.speed_scale": 1.1})
        self.assertNotEqual(other.trajectory.tobytes(), result.trajectory.tobytes())

    def test_without_measurements_the_pose_is_lost(self):
        with waymark.Live(yaml=self.yaml) as live:
            self.assertEqual((live.health, live.health_reason), ("lost", "nothing has arrived"))
            self.assertIsNone(live.front())
            self.assertIsNone(live.last())
            with Wheels(self.out / "robot.sock"):
                self.assertTrue(eventually(lambda: live.health == "ok"), live.health_reason)
            self.assertTrue(eventually(lambda: live.health == "lost"))
            self.assertRegex(live.health_reason, r"nothing has arrived for \d")
            self.assertTrue(eventually(lambda: any("nothing has arrived" in event["text"] for event in live.events)))

    def test_ends_after_a_time(self):
        live = waymark.Live(QUICKSTART, set={"live.real_time": True}, until_s=1)
        self.assertFalse(live.wait(0.2))
        self.assertTrue(live.wait(PATIENCE_S))
        self.assertFalse(live.is_running)
        self.assertEqual(len(live.stop().trajectory), 0)  # record=False
        self.assertGreater(live.stop().sensors["wheels"]["measurements"], 10)

    def test_ctrl_c_ends_it_and_keeps_what_there_is(self):
        before = signal.signal(signal.SIGALRM, signal.default_int_handler)
        try:
            with self.assertRaises(KeyboardInterrupt):
                with waymark.Live(QUICKSTART, set={"live.real_time": True}, out=self.out) as live:
                    self.assertTrue(eventually(lambda: live.front() is not None))
                    signal.setitimer(signal.ITIMER_REAL, 0.1)
                    live.wait()
        finally:
            signal.signal(signal.SIGALRM, before)
        self.assertTrue(support.rows_of(self.out / "trajectory.txt"))

    def test_a_program_that_leaves_it_running_ends(self):
        program = textwrap.dedent(f"""
            import time, waymark
            live = waymark.Live({str(QUICKSTART)!r}, set={{"live.real_time": True}}, out={str(self.out)!r})
            while live.front() is None:
                time.sleep(0.01)
            """)
        subprocess.run([sys.executable, "-c", program], check=True, timeout=PATIENCE_S)
        self.assertTrue(support.rows_of(self.out / "trajectory.txt"))

    def test_sensors_in_python_work_in_its_threads(self):
        @waymark.sensor("live_speed")
        class Speed(waymark.Sensor):
            payload = "BodyTwist"
            is_motion_source = True

            def process(self, measurement, prediction, out):
                out.add(waymark.NumericalUpdate([measurement.v_x_mps, 0.0], lambda state: state.velocity[:2],
                                                [[0.01, 0.0], [0.0, 0.01]], observes="velocity"))

        yaml = self.yaml.replace("plugin: odometry, model: twist", "plugin: python_sensor, class: live_speed")
        with waymark.Live(yaml=yaml) as live, Wheels(self.out / "robot.sock"):
            self.assertTrue(eventually(lambda: live.front() is not None and live.front().position[0] > 0.5), live.events)

    def test_logs_and_running_robots_are_told_apart(self):
        with self.assertRaisesRegex(waymark.ConfigError, "its source is a log"):
            waymark.Live(QUICKSTART)
        with self.assertRaisesRegex(waymark.ConfigError, "with waymark.Live"):
            waymark.run(QUICKSTART, set={"live.real_time": True})
        with self.assertRaisesRegex(waymark.ConfigError, "has no source"):
            waymark.Live(yaml="sensors: [{ name: wheels, plugin: odometry, model: twist }]")


class FlightRecord(unittest.TestCase):
    def test_of_a_log_gives_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            first = waymark.run(QUICKSTART, set=support.SHORT | {"record": {}}, out=out / "first")
            second = waymark.run(out / "first" / "flight.mcap", out=out / "second")
            self.assertEqual(second.trajectory.tobytes(), first.trajectory.tobytes())
            for name in ("trajectory.txt", "landmarks.csv"):
                self.assertEqual((out / "first" / name).read_bytes(), (out / "second" / name).read_bytes(), name)
            self.assertFalse((out / "second" / "flight.mcap").exists())

    def test_other_files_are_refused(self):
        with tempfile.NamedTemporaryFile(suffix=".mcap") as file:
            file.write(b"no record")
            file.flush()
            with self.assertRaisesRegex(waymark.Error, file.name):
                waymark.run(file.name)


if __name__ == "__main__":
    unittest.main()
