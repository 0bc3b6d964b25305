#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""CPU time of a measurement that is fed in blocks from Python, beside a C++ program that adds the same ones.

    feed_timing.py FEED_TIMING [--count N] [--rounds N]     FEED_TIMING: the C++ program, of this project's build
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

import waymark

YAML = """
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors: [{ name: wheels, plugin: odometry, model: differential, track_m: 0.5 }]
diagnosis: { enabled: false }
"""


def python_time(count, block, record):
    """CPU time [µs] per measurement of feed and play, and of feed alone."""
    robot = waymark.Robot(yaml=YAML, record=record)
    k = np.arange(count)
    stamps, left, right = (k + 1) * 10**7, 1.0 + 0.1 * np.sin(0.01 * k), np.ones(count)
    in_feed, begin = 0.0, time.process_time()
    for a in range(0, count, block):
        start = time.process_time()
        robot.feed("wheels", stamps[a:a + block], left_mps=left[a:a + block], right_mps=right[a:a + block])
        in_feed += time.process_time() - start
        robot.play()
    passed = time.process_time() - begin
    robot.finish()
    return 1e6 * passed / count, 1e6 * in_feed / count


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=200000)
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--most-us", type=float,
                        help="fail if feed takes more in the best round; other processes on the machine only ever add to a round")
    options = parser.parse_args()
    blocks = [(100, True), (1000, True), (10000, True), (10000, False)]
    times = {key: [] for key in blocks}
    feeds = {key: [] for key in blocks}
    native = []
    with tempfile.TemporaryDirectory() as folder:
        yaml = pathlib.Path(folder) / "robot.yaml"
        yaml.write_text(YAML)
        for _ in range(options.rounds):  # in turn, so that a busy machine is busy for all
            native.append(float(subprocess.run([options.program, yaml, str(options.count)], check=True, text=True,
                                               stdout=subprocess.PIPE).stdout))
            for key in blocks:
                passed, in_feed = python_time(options.count, *key)
                times[key].append(passed)
                feeds[key].append(in_feed)
    spread = lambda values: f"{min(values):.3f} / {np.median(values):.3f} / {max(values):.3f}"
    print(f"CPU time, µs per measurement, min / median / max of {options.rounds} rounds, {options.count} measurements each")
    print(f"C++                                {spread(native)}")
    for (block, record), values in times.items():
        more = np.array(values) - np.array(native)
        what = f"Python, blocks of {block}" + ("" if record else ", record=False")
        print(f"{what:34} {spread(values)}, beyond C++ {spread(more)}; in feed {spread(feeds[block, record])}")
    slowest = max(min(values) for values in feeds.values())
    return int(options.most_us is not None and slowest > options.most_us)


if __name__ == "__main__":
    sys.exit(main())
