#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How far runs have drifted: the error of the position at the end and at worst, in percent of the way driven until the end.

Reads trajectory.txt and reference.txt (sink tum) of each run. With --limit it fails if the end of any run is worse.
"""
import argparse
import bisect
import math
import sys


def read_tum(path):
    with open(path) as file:
        rows = [[float(word) for word in line.split()[:3]] for line in file if line.strip() and line[0] != "#"]
    if len(rows) < 2:
        sys.exit(f"{path}: fewer than two rows")
    return rows


def drift(run):
    estimate, reference = read_tum(f"{run}/trajectory.txt"), read_tum(f"{run}/reference.txt")
    times = [row[0] for row in estimate]
    way = sum(math.dist(a[1:], b[1:]) for a, b in zip(reference, reference[1:]))
    errors = []
    for t, x, y in reference:
        i = bisect.bisect_left(times, t)
        if i == 0 or i == len(times):
            continue
        (t0, x0, y0), (t1, x1, y1) = estimate[i - 1], estimate[i]
        share = (t - t0) / (t1 - t0) if t1 > t0 else 1.0
        errors.append(math.hypot(x0 + share * (x1 - x0) - x, y0 + share * (y1 - y0) - y))
    if not errors:
        sys.exit(f"{run}: no time in common with the reference")
    return way, errors[-1], max(errors)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", help="output folders of runs")
    parser.add_argument("--limit", type=float, metavar="PERCENT", help="the drift at the end may be so large")
    arguments = parser.parse_args()
    worst = 0.0
    for run in arguments.runs:
        way, end, most = drift(run)
        print(f"{run}: end {end:.2f} m of {way:.1f} m: {100.0 * end / way:.3f} %; at worst {most:.2f} m: {100.0 * most / way:.3f} %")
        worst = max(worst, 100.0 * end / way)
    if arguments.limit is not None and worst > arguments.limit:
        sys.exit(f"the drift is {worst:.3f} %; at most {arguments.limit} % is expected")


if __name__ == "__main__":
    main()
