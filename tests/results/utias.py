#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs config/utias_mrclam.yaml for robots and seeds and prints min / median / max of what `waymark evaluate` says,
per robot and pooled. Trajectories are aligned by SE(2) with the motion capture; landmarks are moved by the same motion,
and also by one of their own. Robots whose ground truth is not in the folder are scored by their landmarks alone: the
map is first laid on the survey by the motion that puts most landmarks within 0.5 m of a surveyed one.
With --from-truth a run starts where the motion capture has the robot, and nothing is aligned: this adds the NEES.

Example:
  tests/results/utias.py --data "$WAYMARK_DATA/utias_mrclam_7" --seeds 10 --set variables.barcodes=known
"""
import argparse
import gzip
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

FIGURES = [
    ("trajectory RMS [m]", ["trajectory", "ate_rms_m"]),
    ("yaw RMS [rad]", ["trajectory", "yaw_rms_rad"]),
    ("landmarks found", ["landmarks", "matched"]),
    ("duplicates", ["landmarks", "duplicates"]),
    ("others", ["landmarks", "others"]),
    ("landmark RMS [m]", ["landmarks", "landmark_rms_m"]),
    ("found, own alignment", ["landmarks", "own_alignment_matched"]),
    ("RMS, own alignment [m]", ["landmarks", "landmark_rms_own_alignment_m"]),
    ("NEES, mean", ["consistency", "nees_mean"]),
    ("NEES, median", ["consistency", "nees_median"]),
    ("NEES within 95 %", ["consistency", "nees_share_within_95"]),
]


def figure(report, path):
    for key in path:
        report = report.get(key) if isinstance(report, dict) else None
    return report


def numbers_of(path):
    with gzip.open(path, "rt") as file:
        for line in file:
            if not line.startswith("#"):
                yield [float(word) for word in line.split()]


def true_start(data, robot):
    """The overrides that start a run where the motion capture has the robot at its first command."""
    first = next(numbers_of(f"{data}/Robot{robot}_Odometry.dat.gz"))[0]
    _, x, y, yaw, *_ = min(numbers_of(f"{data}/Robot{robot}_Groundtruth.dat.gz"), key=lambda row: abs(row[0] - first))
    return [f"initial.x_m={x}", f"initial.y_m={y}", f"initial.yaw_deg={math.degrees(yaw)}"]


def run(arguments, robot, seed):
    with tempfile.TemporaryDirectory() as out:
        command = [arguments.waymark, "run", arguments.config, "--out", out, "--seed", str(seed), "--quiet",
                   "--set", f"variables.log={arguments.data}", "--set", f"variables.robot={robot}",
                   "--set", "sinks.plot.enabled=false"]
        for override in arguments.set + (true_start(arguments.data, robot) if arguments.from_truth else []):
            command += ["--set", override]
        subprocess.run(command, check=True, stderr=subprocess.PIPE)
        evaluate = [arguments.waymark, "evaluate", "--json", "--landmarks", f"{out}/landmarks.csv",
                    "--survey", f"{arguments.data}/Landmark_Groundtruth.dat", "--survey-columns", "name=0,x=1,y=2"]
        truth = f"{arguments.data}/Robot{robot}_Groundtruth.dat.gz"
        if os.path.exists(truth):
            evaluate += ["--estimate", f"{out}/trajectory.txt", "--reference", truth,
                         "--reference-columns", "t=0,x=1,y=2,yaw=3", "--align", "none" if arguments.from_truth else "se2"]
            if arguments.from_truth:
                evaluate += ["--covariance", f"{out}/covariance.csv"]
        else:
            lay_landmarks_on_survey(f"{out}/landmarks.csv", f"{arguments.data}/Landmark_Groundtruth.dat")
        report = json.loads(subprocess.run(evaluate, check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE).stdout)
        values = [figure(report, path) for _, path in FIGURES]
        if not os.path.exists(truth):  # without a trajectory nothing aligns the map but itself
            values[2], values[5] = None, None
        return values


def read_points(path, x, y, separator=None):
    with open(path) as file:
        rows = [line.split(separator) for line in file if not line.startswith(("#", "map,"))]
    return [complex(float(row[x]), float(row[y])) for row in rows if len(row) > max(x, y)]


def lay_on(points, survey):
    """The points, moved by the best motion among those that lay a pair of them on a pair of the survey."""
    def inliers(moved):
        distances = [min(abs(p - q) for q in survey) for p in moved]
        return sum(d < 0.5 for d in distances), -sum(d for d in distances if d < 0.5)

    best, best_moved = (-1, 0.0), points
    for i, a in enumerate(points):
        for b in points[:i]:
            for c in survey:
                for d in survey:
                    if abs(a - b) < 3.0 or abs(abs(a - b) - abs(c - d)) > 0.3:
                        continue
                    turn = (d - c) / (b - a)
                    turn /= abs(turn)
                    moved = [0.5 * (c + d) + turn * (p - 0.5 * (a + b)) for p in points]
                    score = inliers(moved)
                    if score > best:
                        best, best_moved = score, moved
    return best_moved


def lay_landmarks_on_survey(landmarks, survey):
    with open(landmarks) as file:
        rows = [line.rstrip("\n").split(",") for line in file]
    points = lay_on([complex(float(row[2]), float(row[3])) for row in rows[1:]], read_points(survey, 1, 2))
    for row, point in zip(rows[1:], points):
        row[2:4] = f"{point.real:.6f}", f"{point.imag:.6f}"
    with open(landmarks, "w") as file:
        file.writelines(",".join(row) + "\n" for row in rows)


def show(title, rows):
    print(title)
    for k, (name, _) in enumerate(FIGURES):
        values = [row[k] for row in rows if row[k] is not None]
        if values:
            print(f"  {name:<24} {min(values):8.4g} / {statistics.median(values):8.4g} / {max(values):8.4g}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", default="config/utias_mrclam.yaml")
    parser.add_argument("--data", default=os.path.expandvars("${WAYMARK_DATA}/utias_mrclam_7"))
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--robots", default="1,2,3,4,5")
    parser.add_argument("--seeds", type=int, default=10, help="seeds 1..N (default 10)")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--from-truth", action="store_true", help="start at the true pose, align nothing, add the NEES")
    parser.add_argument("--pooled", action="store_true", help="only the pooled figures")
    arguments = parser.parse_args()
    robots = [int(r) for r in arguments.robots.split(",")]
    tasks = [(robot, seed) for robot in robots for seed in range(1, arguments.seeds + 1)]
    try:
        with ThreadPoolExecutor(arguments.jobs) as pool:
            results = list(pool.map(lambda task: run(arguments, *task), tasks))
    except subprocess.CalledProcessError as error:
        sys.exit(f"{' '.join(error.cmd)}: exit code {error.returncode}\n{(error.stderr or b'').decode()}")
    print(f"{' '.join(arguments.set) or 'as configured'}; seeds 1..{arguments.seeds}; min / median / max")
    for robot in robots if not arguments.pooled else []:
        show(f"robot {robot}", [row for (r, _), row in zip(tasks, results) if r == robot])
    show(f"robots {arguments.robots} pooled", results)


if __name__ == "__main__":
    main()
