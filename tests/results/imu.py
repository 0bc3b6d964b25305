#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Errors of the attitude that `waymark run` gives on a trial of BROAD or RepoIMU.

A trial is a run of the shipped config/broad.yaml or config/repoimu.yaml with another `variables.trial`. Scored is the online
estimate (trajectory.txt) at the stamps of the truth: r.m.s. of the total error, its heading and its inclination, in degrees, over
the movement phases, as BROAD defines them. The truth of RepoIMU is relative to its first sample: there estimate and truth are
aligned at the first sample that counts, and a trial at rest has the truth "nothing turns".

Example:
  tests/results/imu.py broad 02_undisturbed_slow_rotation_B --out out/broad
"""
import csv
import gzip
import math
import os
import pathlib
from decimal import Decimal

from one_run import ROOT, parser_of, print_scores, run


def product(a, b):
    """Of two quaternions (w, x, y, z)."""
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def normalised(q):
    norm = math.sqrt(sum(x * x for x in q))
    return tuple(x / norm for x in q)


def nanoseconds(text):
    return int(Decimal(text).scaleb(9).to_integral_value())


def broad_truth(file):
    """(stamp, quaternion) of the samples that count."""
    with gzip.open(file, "rt") as rows:
        for row in csv.DictReader(rows):
            if float(row["movement"]) == 1.0 and row["qw"] != "nan":
                yield nanoseconds(row["t_s"]), normalised([float(row[c]) for c in ("qw", "qx", "qy", "qz")])


def repoimu_truth(file):
    at_rest = file.name.endswith("_Static.csv.gz")
    with gzip.open(file, "rt") as rows:
        for number, row in enumerate(csv.reader(rows, delimiter=";")):
            if number < 2 or not row:
                continue
            q = (1.0, 0.0, 0.0, 0.0) if at_rest else tuple(map(float, row[1:5]))
            if math.sqrt(sum(x * x for x in q)) > 0.5:
                yield nanoseconds(row[0]), normalised(q)


def trajectory(file):
    poses = {}
    with open(file) as lines:
        for line in lines:
            if not line.startswith("#"):
                field = line.split()
                poses[nanoseconds(field[0])] = tuple(float(field[i]) for i in (7, 4, 5, 6))
    return poses


def errors(truth, estimate, align):
    """r.m.s. of total error, heading and inclination [deg], the samples that count and those without an estimate."""
    frame = (1.0, 0.0, 0.0, 0.0)
    sums, count, missing = [0.0, 0.0, 0.0], 0, 0
    for stamp, q_truth in truth:
        q = estimate.get(stamp)
        if q is None:
            missing += 1
            continue
        if align and count == 0:
            frame = product(q, conjugate(q_truth))
        w, x, y, z = product(q, conjugate(product(frame, q_truth)))
        angles = (2 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w)), 2 * math.atan2(abs(z), abs(w)),
                  2 * math.atan2(math.hypot(x, y), math.hypot(w, z)))
        sums = [s + a * a for s, a in zip(sums, angles)]
        count += 1
    return [math.degrees(math.sqrt(s / count)) for s in sums], count, missing


def main():
    parser = parser_of(__doc__)
    parser.add_argument("set_of_trials", choices=("broad", "repoimu"))
    parser.add_argument("trial", help="the name of its file without .csv.gz")
    options = parser.parse_args()
    name = options.set_of_trials
    file = pathlib.Path(os.environ["WAYMARK_DATA"]) / name / f"{options.trial}.csv.gz"
    run(options, ROOT / f"config/{name}.yaml", options.out, f"variables.trial={options.trial}", "sinks=[{plugin: tum}]")
    truth = broad_truth(file) if name == "broad" else repoimu_truth(file)
    error, count, missing = errors(truth, trajectory(options.out / "trajectory.txt"), align=name == "repoimu")
    print_scores({"total_deg": error[0], "heading_deg": error[1], "inclination_deg": error[2], "samples": count, "without_estimate": missing})


if __name__ == "__main__":
    main()
