#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much farther, and by how much more, a robot moved than its wheels say: slopes of the motion of an estimate that a map corrected
against that of the wheels alone, over seeds.

    tests/results/odometry_scale.py --waymark build/release/bin/waymark config/mines_hokuyo.yaml --seeds 10 --map building

The wheels alone are the same run with the map disabled. Both trajectories are cut into windows of --window seconds; of each the way
forward (in the frame of its begin) and the rotation are taken. The slope is that of least squares through zero, of the estimate
on the wheels: wheels have little noise over a second, the matching has. A slope of 1: the wheels are right.
"""
import argparse
import math
import pathlib
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor


def trajectory(file):
    poses = []
    with open(file) as lines:
        for line in lines:
            if not line.startswith("#"):
                t, x, y, _, qx, qy, qz, qw = map(float, line.split())
                poses.append((t, x, y, math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))))
    return poses


def motions(poses, window):
    """(way forward [m], rotation [rad]) of each window, by its number."""
    steps, first = {}, None
    for pose in poses:
        number = math.floor(pose[0] / window)
        if first is None or number != first[0]:
            if first is not None and number == first[0] + 1:
                _, (_, x, y, yaw) = first
                dx, dy = pose[1] - x, pose[2] - y
                steps[first[0]] = (math.cos(yaw) * dx + math.sin(yaw) * dy, math.remainder(pose[3] - yaw, 2 * math.pi))
            first = (number, pose)
    return steps


def slope(pairs):
    return sum(a * b for a, b in pairs) / sum(b * b for _, b in pairs)


def run(arguments, seed, extra):
    with tempfile.TemporaryDirectory() as out:
        command = [arguments.waymark, "run", arguments.config, "--out", out, "--seed", str(seed), "--quiet", "--set", "sinks=[{plugin: tum}]"]
        for override in arguments.set + extra:
            command += ["--set", override]
        subprocess.run(command, check=True, stderr=subprocess.PIPE)
        return trajectory(pathlib.Path(out) / arguments.trajectory)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("config")
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--map", required=True, help="the map whose matches correct the wheels")
    parser.add_argument("--seeds", type=int, default=10, help="seeds 1..N (default 10)")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--window", type=float, default=1.0, help="s (default 1)")
    parser.add_argument("--trajectory", default="path.txt", help="path.txt (one particle, all of its scans; default) or trajectory.txt")
    parser.add_argument("--set", action="append", default=[], help="override of the YAML")
    arguments = parser.parse_args()
    wheels = motions(run(arguments, 1, [f"maps.{arguments.map}.enabled=false"]), arguments.window)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        estimates = list(pool.map(lambda seed: motions(run(arguments, seed, []), arguments.window), range(1, arguments.seeds + 1)))
    least = (0.05, math.radians(3.0))  # less is no motion
    for name, part in (("forward", 0), ("rotation", 1)):
        slopes = []
        for estimate in estimates:
            pairs = [(estimate[n][part], wheels[n][part]) for n in estimate.keys() & wheels.keys() if abs(wheels[n][part]) > least[part]]
            slopes.append(slope(pairs))
        print(f"{name:8}  slope {min(slopes):.4f} / {statistics.median(slopes):.4f} / {max(slopes):.4f}  (min / median / max of {len(slopes)} seeds, {len(pairs)} windows)")


if __name__ == "__main__":
    main()
