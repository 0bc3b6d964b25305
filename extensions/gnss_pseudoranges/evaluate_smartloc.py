#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs smartloc.yaml and scores the horizontal error against the true positions, which are given in ECEF.

    WAYMARK_PLUGIN_PATH=build ./evaluate_smartloc.py --waymark WAYMARK --out OUT [--draws 10] [--set KEY=VALUE …]

`--draws N`: N runs more, each with other noise on the odometry (5 cm/s white, a constant error of the yaw rate of 0.1 °/s and of the
speed of 1 %, each σ). Ends with 77 if WAYMARK_DATA is not set.
"""
import argparse
import gzip
import math
import os
import pathlib
import random
import statistics
import subprocess
import sys

A, E2 = 6378137.0, 6.69437999014e-3  # WGS-84
FOLDER = pathlib.Path(__file__).parent
NAME = "Berlin_Potsdamer_Platz"


def datum():
    line = next(line for line in (FOLDER / "smartloc.yaml").read_text().splitlines() if line.startswith("datum:"))
    words = line.replace(",", " ").split()
    return tuple(float(words[words.index(key) + 1]) for key in ("latitude_deg:", "longitude_deg:", "height_m:"))


def true_places(folder):
    """{t: (east, north)} in the map."""
    latitude, longitude, height = (math.radians(v) if i < 2 else v for i, v in enumerate(datum()))
    sa, ca, so, co = math.sin(latitude), math.cos(latitude), math.sin(longitude), math.cos(longitude)
    n = A / math.sqrt(1.0 - E2 * sa * sa)
    origin = ((n + height) * ca * co, (n + height) * ca * so, (n * (1.0 - E2) + height) * sa)
    places = {}
    for line in gzip.open(folder / f"{NAME}_GT.txt.gz", "rt"):
        words = [float(word) for word in line.split()[1:5]]
        x, y, z = (a - b for a, b in zip(words[1:], origin))
        places[round(words[0], 3)] = (-so * x + co * y, -sa * co * x - sa * so * y + ca * z)
    return places


def with_noise(log, out, seed):
    noise = random.Random(seed)
    rate, scale = noise.gauss(0.0, math.radians(0.1)), noise.gauss(1.0, 0.01)
    with gzip.open(out, "wt", compresslevel=1) as copy:
        for line in gzip.open(log, "rt"):
            words = line.split()
            if words[0] == "odom3" and float(words[2]) != 0.0:
                words[2] = repr(scale * float(words[2]) + noise.gauss(0.0, 0.05))
                words[7] = repr(float(words[7]) + rate)
            copy.write(" ".join(words) + "\n")


def errors_of(trajectory, places):
    errors = {}  # several poses of one time: the last one, after all its measurements
    for line in trajectory.read_text().splitlines():
        if line.startswith("#"):
            continue
        t, x, y = (float(word) for word in line.split()[:3])
        if round(t, 3) in places:
            errors[t] = math.dist((x, y), places[round(t, 3)])
    return sorted(errors.items())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", required=True)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("--draws", type=int, default=0)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--mean-below", type=float, help="fails if the mean error [m] is not smaller")
    arguments = parser.parse_args()
    if not os.environ.get("WAYMARK_DATA"):
        print("skipped: WAYMARK_DATA is not set")
        sys.exit(77)
    data = pathlib.Path(os.environ["WAYMARK_DATA"]) / "tuc_smartloc_berlin"
    places = true_places(data)
    arguments.out.mkdir(parents=True, exist_ok=True)

    def run(name, settings):
        out = arguments.out / name
        command = [arguments.waymark, "run", FOLDER / "smartloc.yaml", "--out", out, "--quiet"]
        for setting in arguments.set + settings:
            command += ["--set", setting]
        ended = subprocess.run(command)
        if ended.returncode not in (0, 4):  # 4: the position is too uncertain at the end
            sys.exit(ended.returncode)
        errors = errors_of(out / "trajectory.txt", places)
        if len(errors) < 1200:
            sys.exit(f"{len(errors)} poses at the times of true positions; at least 1200 are expected")
        return errors

    errors = run("given", [])
    values = sorted(error for _, error in errors)
    mean = statistics.fmean(values)
    middle = 0.5 * (errors[0][0] + errors[-1][0])
    halves = [statistics.fmean(e for t, e in errors if (t < middle) == first) for first in (True, False)]
    print(f"{len(values)} poses: mean {mean:.2f} m (halves {halves[0]:.2f}, {halves[1]:.2f}), RMS "
          f"{math.sqrt(statistics.fmean(v * v for v in values)):.2f} m, median {statistics.median(values):.2f} m, 95 % "
          f"{values[int(0.95 * len(values))]:.2f} m, max {values[-1]:.2f} m")
    means = []
    for seed in range(1, arguments.draws + 1):
        log = arguments.out / f"noisy_{seed}.txt.gz"
        with_noise(data / f"{NAME}_Input.txt.gz", log, seed)
        means.append(statistics.fmean(e for _, e in run(f"draw_{seed}", [f"variables.log={log.resolve()}"])))
        log.unlink()
    if means:
        print(f"mean of {len(means)} draws of the odometry's noise: {min(means):.2f} / {statistics.median(means):.2f} / {max(means):.2f} m")
    if arguments.mean_below and not mean < arguments.mean_below:
        sys.exit(f"mean {mean:.2f} m; expected less than {arguments.mean_below} m")


if __name__ == "__main__":
    main()
