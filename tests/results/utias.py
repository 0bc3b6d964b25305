#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs config/utias_mrclam.yaml for robots and seeds and prints min / median / max of what `waymark evaluate` says,
per robot and pooled. Trajectories are aligned by SE(2) with the motion capture; landmarks are moved by the same motion,
and also by one of their own. Robots whose ground truth is not in the folder are scored by their landmarks alone.

Example:
  tests/results/utias.py --data "$WAYMARK_DATA/utias_mrclam_7" --seeds 10 --set variables.barcodes=known
"""
import argparse
import json
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
]


def figure(report, path):
    for key in path:
        report = report.get(key) if isinstance(report, dict) else None
    return report


def run(arguments, robot, seed):
    with tempfile.TemporaryDirectory() as out:
        command = [arguments.waymark, "run", arguments.config, "--out", out, "--seed", str(seed), "--quiet",
                   "--set", f"variables.log={arguments.data}", "--set", f"variables.robot={robot}",
                   "--set", "sinks.plot.enabled=false"]
        for override in arguments.set:
            command += ["--set", override]
        subprocess.run(command, check=True, stderr=subprocess.PIPE)
        evaluate = [arguments.waymark, "evaluate", "--json", "--landmarks", f"{out}/landmarks.csv",
                    "--survey", f"{arguments.data}/Landmark_Groundtruth.dat", "--survey-columns", "name=0,x=1,y=2"]
        truth = f"{arguments.data}/Robot{robot}_Groundtruth.dat.gz"
        if os.path.exists(truth):
            evaluate += ["--estimate", f"{out}/trajectory.txt", "--reference", truth,
                         "--reference-columns", "t=0,x=1,y=2,yaw=3", "--align", "se2"]
        report = json.loads(subprocess.run(evaluate, check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE).stdout)
        values = [figure(report, path) for _, path in FIGURES]
        if not os.path.exists(truth):  # without a trajectory nothing aligns the map but itself
            values[2:6] = [None] * 4
        return values


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
