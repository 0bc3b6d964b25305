# SPDX-License-Identifier: Apache-2.0
"""Our source rosbag1 against python3-rosbag, on recorded bags: compare_rosbag.py PRINT_MEASUREMENTS"""
import math
import pathlib
import sys
import tempfile

import peers

try:
    import rosbag
except ImportError:
    peers.skip("python3-rosbag is not installed")

NAN = math.nan
ABSENT = -1.0


def xyz(v):
    return [v.x, v.y, v.z]


def sigma(variance):
    return math.sqrt(variance) if variance > 0 else NAN


def imu(m):
    q = [m.orientation.w, m.orientation.x, m.orientation.y, m.orientation.z]
    measured = m.orientation_covariance[0] != ABSENT and any(q)
    norm = math.sqrt(sum(v * v for v in q))
    if measured and abs(norm - 1) >= 1e-9:
        q = [v / norm for v in q]
    f = xyz(m.linear_acceleration) if m.linear_acceleration_covariance[0] != ABSENT else [NAN] * 3
    return xyz(m.angular_velocity) + f + (q if measured else [NAN] * 4)


def fix(m):
    kind = {-1: 0, 0: 1, 1: 2, 2: 2}[m.status.status]
    c = m.position_covariance
    known = m.position_covariance_type != 0
    sigmas = [sigma((c[0] + c[4]) / 2), sigma(c[8])] if known else [NAN, NAN]
    return [m.latitude, m.longitude, m.altitude] + sigmas + [NAN, -1, kind, NAN, NAN]


def twist(m):
    return [m.twist.twist.linear.x, m.twist.twist.linear.y, m.twist.twist.angular.z]


def height(m):
    return [m.pose.pose.position.z, sigma(m.pose.covariance[14])]


PAYLOADS = {
    "ImuSample": imu,
    "GnssFix": fix,
    "BodyTwist": twist,
    "Height": height,
}


def peer(bag, channels):
    rows = []
    for topic, message, recorded in rosbag.Bag(str(bag)).read_messages():
        for channel_topic, sensor, payload in channels:
            if channel_topic != topic:
                continue
            times = [recorded.to_nsec(), message.header.stamp.to_nsec()]
            rows.append([sensor, f"waymark/{payload}@1"] + times + PAYLOADS[payload](message))
    return rows


def yaml(bag, channels):
    entries = "".join(
        f"    - {{ topic: {topic}, sensor: {sensor}, payload: {payload} }}\n" for topic, sensor, payload in channels)
    names = ", ".join(sorted({sensor for _, sensor, _ in channels}))
    return f"sensors: [{names}]\nsource:\n  plugin: rosbag1\n  file: {bag}\n  channels:\n{entries}"


HUSKY = [
    ("/imu/data", "imu", "ImuSample"),
    ("/husky_velocity_controller/odom", "wheels", "BodyTwist"),
    ("/fix", "gps", "GnssFix"),
]
ARDRONE = [
    ("/ardrone/imu", "imu", "ImuSample"),
    ("/ardrone/odometry/raw", "flow", "BodyTwist"),
    ("/ardrone/odometry/raw", "ultrasound", "Height"),
]

def rewritten(bag, folder, compression):
    """A copy of the bag, written by the peer."""
    name = folder / f"{compression}.bag"
    with rosbag.Bag(str(name), "w", compression=compression, chunk_threshold=100_000) as copy:
        for topic, message, recorded in rosbag.Bag(str(bag)).read_messages(raw=True):
            copy.write(topic, message, recorded, raw=True)
    return name


def check(program, bag, channels):
    rows, bad = peers.ours(program, yaml(bag, channels))
    if bad:
        sys.exit(f"{bag}: bad records {bad}")
    # Equal to the last digit, but for quaternions that both sides normalised.
    peers.compare(bag.name, rows, peer(bag, channels), tolerance=1e-14)


program = sys.argv[1]
data = peers.data_folder()
check(program, data / "rl_husky/test1.bag", HUSKY)
check(program, data / "rl_ardrone/test3.bag", ARDRONE)
with tempfile.TemporaryDirectory() as temporary:
    for kind in (rosbag.Compression.NONE, rosbag.Compression.BZ2, rosbag.Compression.LZ4):
        check(program, rewritten(data / "rl_husky/test1.bag", pathlib.Path(temporary), kind), HUSKY)
