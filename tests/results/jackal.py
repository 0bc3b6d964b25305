#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A Jackal with one scanner and nothing else, started where motion capture has it: position, heading and what was claimed of them, not aligned.

The start is the mean of the poses of motion capture within 0.25 s of the first scan, since single ones scatter by about a degree. In one of the recordings motion capture stops eight times for half a second. The first pose after such a gap is old, and does not count, nor does the time between.

Example:
  tests/results/jackal.py --recording 2026-02-17-16-26-34 --seed 3 --out out/jackal
"""
import csv
import gzip
import math
import os
import struct

from one_run import ROOT, evaluate, parser_of, print_scores, run

BEFORE_STAMP_S = 0.034  # what a scan shows was so long before its stamp, as in config/jackal.yaml
NEAR_S = 0.25
GAP_S = 0.2


def first_scan(file):
    """Time of what it shows [s]."""
    with gzip.open(file) as scans:
        scans.read(24)
        return struct.unpack("<d", scans.read(8))[0] - BEFORE_STAMP_S


def start(recording):
    """x [m], y [m], yaw [rad] of the robot at the first scan."""
    path = os.path.join(os.environ["WAYMARK_DATA"], "jackal_mocap_scan", recording)
    at = first_scan(f"{path}_scans.bin.gz")
    with gzip.open(f"{path}_mocap.csv.gz", "rt") as poses:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(poses)]
    near = [row for row in rows if abs(row["t_s"] - at) < NEAR_S]
    sine = sum(2 * (row["qw"] * row["qz"] + row["qx"] * row["qy"]) for row in near)
    cosine = sum(1 - 2 * (row["qy"] ** 2 + row["qz"] ** 2) for row in near)
    return sum(row["x_m"] for row in near) / len(near), sum(row["y_m"] for row in near) / len(near), math.atan2(sine, cosine)


def without_old_poses(file, kept):
    """A trajectory without the first pose after each gap."""
    last = -math.inf
    with open(file) as poses, open(kept, "w") as out:
        for line in poses:
            if line.startswith("#"):
                continue
            stamp = float(line.split()[0])
            if stamp - last < GAP_S:
                out.write(line)
            last = stamp


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--recording", required=True)
    options = parser.parse_args()
    x, y, yaw = start(options.recording)
    run(options, ROOT / "config/jackal.yaml", options.out, f"variables.recording={options.recording}", f"initial.x_m={x}", f"initial.y_m={y}",
        f"initial.yaw_deg={math.degrees(yaw)}", more=["--seed", str(options.seed)])
    reference = options.out / "reference_without_old_poses.txt"
    without_old_poses(options.out / "reference.txt", reference)
    scored = evaluate(options, "--estimate", options.out / "trajectory.txt", "--covariance", options.out / "covariance.csv",
                      "--reference", reference, "--max-time-gap", GAP_S)
    claimed = scored["consistency"]
    print_scores({"nees": claimed["nees_mean"], "inside": claimed["nees_share_within_95"], "rms_m": scored["trajectory"]["ate_rms_m"],
                  "yaw_rms_rad": scored["trajectory"]["yaw_rms_rad"], "sigma_by_rms_x": claimed["sigma_by_rms_x"],
                  "sigma_by_rms_y": claimed["sigma_by_rms_y"], "sigma_by_rms_yaw": claimed["sigma_by_rms_yaw"]})


if __name__ == "__main__":
    main()
