#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much farther, and by how much more, a robot moved than its wheels say: slopes of the motion of an estimate that a map corrected
against that of the wheels alone.

The wheels alone are the same run with the map disabled. Both trajectories are cut into windows of --window seconds; of each the way
forward (in the frame of its begin) and the rotation are taken. The slope is that of least squares through zero, of the estimate
on the wheels: wheels have little noise over a second, the matching has. A slope of 1: the wheels are right.

Example:
  tests/results/odometry_scale.py config/mines_hokuyo.yaml --map building --seed 3 --out out/scale
"""
import math

from one_run import ROOT, heading_of, parser_of, print_scores, rows_of, run


def trajectory(file):
    return [(*row[:3], heading_of(row)) for row in rows_of(file)]


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


def main():
    parser = parser_of(__doc__)
    parser.add_argument("config", help="relative to the repository")
    parser.add_argument("--map", required=True, help="the map whose matches correct the wheels")
    parser.add_argument("--window", type=float, default=1.0, help="s (default 1)")
    parser.add_argument("--trajectory", default="path.txt", help="path.txt (one particle, all of its scans; default) or trajectory.txt")
    options = parser.parse_args()

    def motions_of(name, seed, *settings):
        run(options, ROOT / options.config, options.out / name, "sinks=[{plugin: tum}]", *settings, more=["--seed", str(seed)])
        return motions(trajectory(options.out / name / options.trajectory), options.window)

    wheels = motions_of("wheels", 1, f"maps.{options.map}.enabled=false")
    estimate = motions_of("estimate", options.seed)
    scores = {}
    for part, (name, least) in enumerate((("forward", 0.05), ("rotation", math.radians(3.0)))):  # less is no motion
        pairs = [(estimate[n][part], wheels[n][part]) for n in estimate.keys() & wheels.keys() if abs(wheels[n][part]) > least]
        scores |= {f"{name}_slope": slope(pairs), f"{name}_windows": len(pairs)}
    print_scores(scores)


if __name__ == "__main__":
    main()
