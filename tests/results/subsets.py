#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether the filter without maps is as good as it says, for every subset of sensors that makes sense, on the simulator
(config/faults.yaml without a fault): NEES of (x, y, yaw), averaged over the runs at each time step, against its
two-sided 95 % χ² band.

Example:
  tests/results/subsets.py --waymark build/release/bin/waymark --runs 50
"""
import argparse
import bisect
import math
import statistics
import tempfile
from concurrent.futures import ThreadPoolExecutor

from faults import cell, drive, rows

SENSORS = ("wheels", "imu", "gps", "compass")
SUBSETS = (("wheels",), ("wheels", "imu"), ("wheels", "compass"), ("wheels", "gps"), ("wheels", "imu", "compass"),
           ("wheels", "imu", "gps"), ("wheels", "gps", "compass"), ("imu", "gps"), ("imu", "gps", "compass"), SENSORS)
STEP = 1.0  # s
OVAL = [(round(20 + 16 * math.sin(math.tau * k / 36), 2), round(12.5 - 8.5 * math.cos(math.tau * k / 36), 2)) for k in range(36)]


def on_oval():
    """The settings of a course without corners: at these the rate jumps, which the process noise would have to allow at any time."""
    (x0, y0), (x1, y1) = OVAL[:2]
    return {"source.course.waypoints_m": "[" + ", ".join(f"{x}, {y}" for x, y in OVAL) + "]", "initial.x_m": x0, "initial.y_m": y0,
            "initial.yaw_deg": math.degrees(math.atan2(y1 - y0, x1 - x0)), "motion.rate_noise_radps_per_sqrt_s": "[0.1, 0.1, 0.1]"}


def yaw_of(row):
    qx, qy, qz, qw = row[4:8]
    return math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))


def turned(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


def nees(e, P):
    """eᵀ P⁻¹ e by Cholesky's factor of P (xx, xy, xyaw, yy, yyaw, yawyaw)."""
    xx, xy, xw, yy, yw, ww = P
    a = math.sqrt(xx)
    b, c = xy / a, xw / a
    d = math.sqrt(yy - b * b)
    f = (yw - b * c) / d
    g = math.sqrt(ww - c * c - f * f)
    z1 = e[0] / a
    z2 = (e[1] - b * z1) / d
    z3 = (e[2] - c * z1 - f * z2) / g
    return z1 * z1 + z2 * z2 + z3 * z3


def without(subset):
    """The settings that leave only these sensors."""
    settings = {f"sensors.{s}.enabled": "false" for s in SENSORS if s not in subset}
    if "wheels" not in subset:
        settings["sensors.imu.reports_standstill"] = "false"
        settings["sensors.gps.sideslip_sigma_mps"] = 0.02  # the simulator's lateral slip from fix to fix
    return settings


def run(arguments, subset, seed):
    known_start = {"initial.position_sigma_m": 0.001, "initial.yaw_sigma_deg": 0.01}
    with tempfile.TemporaryDirectory() as out:
        drive(arguments, {**known_start, **without(subset), **on_oval()}, seed, out)
        truth = rows(f"{out}/reference.txt", " ")
        times = [row[0] for row in truth]
        estimate = {row[0]: row for row in rows(f"{out}/trajectory.txt", " ")}
        steps, errors, due = [], [], STEP
        for t, *P in rows(f"{out}/covariance.csv", ","):
            if t < due:
                continue
            due += STEP
            k = bisect.bisect_right(times, t)
            if not 0 < k < len(times):
                break
            share = (t - times[k - 1]) / (times[k] - times[k - 1])
            a, b = truth[k - 1], truth[k]
            x, y = (estimate[t][i] - a[i] - share * (b[i] - a[i]) for i in (1, 2))
            yaw = turned(yaw_of(estimate[t]) - yaw_of(a) - share * turned(yaw_of(b) - yaw_of(a)))
            steps.append(nees((x, y, yaw), P))
            errors.append(x * x + y * y)
        return steps, math.sqrt(statistics.fmean(errors))


def band(dof, runs):
    """Two-sided 95 % of χ²(dof · runs) / runs, after Wilson and Hilferty (1931)."""
    n = dof * runs
    return [n * (1 - 2 / (9 * n) + z * math.sqrt(2 / (9 * n))) ** 3 / runs for z in (-1.959964, 1.959964)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", default="config/faults.yaml")
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--runs", type=int, default=50, help="seeds 1..N (default 50)")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    low, high = band(3, arguments.runs)
    print(f"Band of the mean over {arguments.runs} runs: {low:.2f} to {high:.2f}; 3 is right.\n")
    spans = ((0, 60, "first minute"), (0, None, "whole drive"))
    heads = [f"NEES, {name} | below, in, above the band" for *_, name in spans]
    print(f"| sensors | position, RMS [m] | {' | '.join(heads)} |\n|---|---|{'---|---|' * len(spans)}")
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for subset in SUBSETS:
            results = list(pool.map(lambda seed: run(arguments, subset, seed), range(1, arguments.runs + 1)))
            means = [statistics.fmean(step) for step in zip(*(r[0] for r in results))]
            rms = [r[1] for r in results]
            cells = []
            for begin, end, _ in spans:
                span = means[begin:end]
                below = sum(m < low for m in span) / len(span)
                above = sum(m > high for m in span) / len(span)
                cells.append(f"{statistics.fmean(span):.2f} | {100 * below:.0f} %, {100 * (1 - below - above):.0f} %, {100 * above:.0f} %")
            print(f"| {', '.join(subset)} | {cell(rms)} | {' | '.join(cells)} |",
                  flush=True)


if __name__ == "__main__":
    main()
