# SPDX-License-Identifier: Apache-2.0
"""Cases of live_faults.py: faults of topics of ROS 2. The robot publishes through tests/peers/publish_bytes, which sends what it is given."""
import json
import os
import random
import signal
import struct
import subprocess
import time

from live_cases import case, end, in_own_network, interrupt, row, set_loopback
from live_robot import Driver, Waymark

CHANNELS = """[
  { topic: /twist, type: geometry_msgs/msg/TwistStamped, sensor: wheels, reliable: true },
  { topic: /fix, type: sensor_msgs/msg/NavSatFix, sensor: gps, reliable: true }]"""


def header(stamp_ns):
    """Encapsulation of CDR, little endian, and std_msgs/Header with an empty frame, up to what is aligned to 8 bytes."""
    body = struct.pack("<iI", stamp_ns // 10 ** 9, stamp_ns % 10 ** 9) + struct.pack("<I", 1) + b"\0"
    return b"\0\1\0\0", body


def padded(body, size):
    return body + b"\0" * (-len(body) % size)


def twist_sample(reading):
    start, body = header(reading["stamp_ns"])
    return start + padded(body, 8) + struct.pack("<6d", reading["v_x_mps"], reading["v_y_mps"], 0, 0, 0, reading["w_z_radps"])


def fix_sample(reading):
    start, body = header(reading["stamp_ns"])
    body = padded(body + struct.pack("<b", 0), 2) + struct.pack("<H", 1)
    body = padded(body, 8) + struct.pack("<3d", reading["latitude_deg"], reading["longitude_deg"], 0) + struct.pack("<9d", *[0] * 9)
    return start + body + struct.pack("<B", 0)


TOPICS = {"wheels": ("/twist", "geometry_msgs/msg/TwistStamped", twist_sample), "gps": ("/fix", "sensor_msgs/msg/NavSatFix", fix_sample)}


class Topics:
    """Lines of JSON as samples of topics; or pairs of a sensor and the bytes to publish for it."""

    def __init__(self, program, domain):
        self.program, self.domain = program, domain
        self.process = None
        self.start()

    def start(self):
        self.process = subprocess.Popen([self.program, str(self.domain)], stdin=subprocess.PIPE, text=True, bufsize=1)

    def kill(self):
        process, self.process = self.process, None
        process.kill()
        process.wait()

    def publish(self, sensor, sample):
        process = self.process
        if process is None:
            return False
        topic, kind, _ = TOPICS[sensor]
        try:
            process.stdin.write(f"{topic} {kind} {sample.hex()}\n")
            return True
        except OSError:
            return False

    def __call__(self, line):
        if isinstance(line, tuple):
            return self.publish(*line)
        reading = json.loads(line)
        return self.publish(reading["sensor"], TOPICS[reading["sensor"]][2](reading))


def topic_robot(arguments, folder):
    domain = 1 + os.getpid() % 199
    robot = Waymark(arguments.waymark, folder, f"plugin: ros2, domain: {domain}, initial_pose: none", channels=CHANNELS).start()
    topics = Topics(arguments.waymark.with_name("publish_bytes"), domain)
    driver = Driver(topics)
    return robot.wait_until_under_way(), driver, topics


def lost_messages(report):
    """What DDS counted as lost, and what the gaps in stamps say."""
    events = [event["text"] for event in report["run"]["events"]]
    lost = [text for text in events if "lost so far" in text][-1:] + [text for text in events if text.endswith(" missing")]
    return "; events: " + ", ".join(f"`{text}`" for text in lost) if lost else ""


@case
def topics_killed(arguments, folder):
    robot, driver, topics = topic_robot(arguments, folder)
    report, seen, text = interrupt(robot, driver, topics.kill, 5, topics.start)
    row("ROS 2: the publisher is killed (kill -9), 5 s later another one begins", f"{seen}{lost_messages(report)}; {text}")


@case
def topics_stopped(arguments, folder):
    robot, driver, _ = topic_robot(arguments, folder)
    report, seen, text = interrupt(robot, driver, lambda: robot.send(signal.SIGSTOP), 10, lambda: robot.send(signal.SIGCONT), look=False)
    row("ROS 2: stopped for 10 s (SIGSTOP) while messages come", f"{seen}{lost_messages(report)}; {text}")


@case
def topics_damaged(arguments, folder):
    noise = random.Random(1)
    good = twist_sample({"stamp_ns": 10 ** 18, "v_x_mps": 1.0, "v_y_mps": 0.0, "w_z_radps": 0.1})

    def sample():
        kind = noise.randrange(4)
        if kind == 0:
            return bytes(noise.randrange(256) for _ in range(noise.randrange(1, 200)))
        if kind == 1:
            return good[:noise.randrange(1, len(good))]
        if kind == 2:  # a frame of 4 GB
            return good[:12] + b"\xff\xff\xff\xff" + good[16:]
        return good[:-8] + struct.pack("<d", noise.choice([float("nan"), float("inf")]))

    robot, driver, topics = topic_robot(arguments, folder)
    before = robot.resident_kb()
    count = 0

    def rubbish():
        nonlocal count
        count += 1
        return noise.choice(["wheels", "gps"]), sample()

    driver.rubbish = rubbish
    time.sleep(15)
    grown = robot.resident_kb() - before
    _, report, text = end(robot, driver)
    row("ROS 2: every second sample is damaged", f"{count} damaged, {report['run']['bad_record_count']} bad messages counted, memory {grown / 1024:+.1f} MB"
        f"{lost_messages(report)}; {text}")


@case
def topics_interface(arguments, folder):
    in_own_network(arguments, folder, "--inner-topics")


def topics_in_their_network(arguments, folder):
    set_loopback("up", "multicast", "on")
    robot, driver, _ = topic_robot(arguments, folder)
    report, seen, text = interrupt(robot, driver, lambda: set_loopback("down"), 5, lambda: set_loopback("up"))
    row("ROS 2: network interface down for 5 s, and up", f"{seen}{lost_messages(report)}; {text}")
