#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs cougars.yaml and compares where the vehicle ends with the DVL's own reckoning, in the plane (its depth is wrong by metres).

    WAYMARK_PLUGIN_PATH=build ./check_end.py --waymark WAYMARK --out OUT --attitude dvl|modem [--percent-below 2]

Ends with 77 if WAYMARK_DATA is not set.
"""
import argparse
import csv
import gzip
import math
import os
import pathlib
import subprocess
import sys

FOLDER = pathlib.Path(__file__).parent


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", required=True)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("--attitude", choices=["dvl", "modem"], default="modem")
    parser.add_argument("--percent-below", type=float)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    arguments = parser.parse_args()
    if not os.environ.get("WAYMARK_DATA"):
        print("skipped: WAYMARK_DATA is not set")
        sys.exit(77)
    file = pathlib.Path(os.environ["WAYMARK_DATA"]) / "cougars_auv_mcap/dvl_dead_reckoning.csv.gz"
    reckoned = [(float(row["t_rec_s"]), float(row["x_m"]), -float(row["y_m"])) for row in csv.DictReader(gzip.open(file, "rt"))]
    command = [arguments.waymark, "run", FOLDER / "cougars.yaml", "--out", arguments.out, "--quiet", "--set",
               f"variables.attitude={'dvl_dead_reckoning' if arguments.attitude == 'dvl' else 'imu'}"]
    for setting in arguments.set:
        command += ["--set", setting]
    subprocess.run(command, check=True)
    poses = [tuple(map(float, line.split()[:4])) for line in (arguments.out / "trajectory.txt").read_text().splitlines()
             if not line.startswith("#")]
    pairs, k = [], 0
    for t, x, y in reckoned:
        while k + 1 < len(poses) and poses[k + 1][0] <= t:
            k += 1
        if abs(poses[k][0] - t) < 0.3:
            pairs.append(((poses[k][1], poses[k][2]), (x, y)))
    if len(pairs) < 300:
        sys.exit(f"{len(pairs)} poses near the times of the reckoning; at least 300 are expected")
    way = sum(math.dist(a, b) for (_, a), (_, b) in zip(pairs, pairs[1:]))
    off = [math.dist(*(tuple(p - q for p, q in zip(now, begin)) for now, begin in zip(pair, pairs[0]))) for pair in pairs]
    percent = 100.0 * off[-1] / way
    print(f"attitude of the {arguments.attitude}: {off[-1]:.2f} m beside its own reckoning at the end, {percent:.1f} % of {way:.1f} m; "
          f"at worst {max(off):.2f} m")
    if arguments.percent_below and not percent < arguments.percent_below:
        sys.exit(f"{percent:.2f} %; expected less than {arguments.percent_below} %")


if __name__ == "__main__":
    main()
