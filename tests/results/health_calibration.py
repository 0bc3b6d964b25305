#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How far the health can be believed: of the time with the position outside the 3σ ellipse of its own covariance, the share
that was called ok; and of the time called ok, the share that was outside. On the shipped configurations with truth.

Example:
  tests/results/health_calibration.py --waymark build/release/bin/waymark --runs 10
"""
import argparse
import bisect
import json
import os
import pathlib
import statistics
import subprocess
import tempfile

# Configuration, what is changed, and whether it needs WAYMARK_DATA. All have a reference trajectory.
CASES = [
    ("quickstart", [], False),
    ("quickstart", ["sensors.gps.enabled=false"], False),
    ("indoor", [], False),
    ("hybrid", [], False),
    ("simulated_3d", [], False),
    ("paper_outages", [], False),
    ("faults", [], False),
    ("faults", ["source.wheels.spins_s=[50, 55, 120, 125, 200, 205]"], False),
    ("faults", ["source.gps.drift_s=[60, 80, 160, 180]"], False),
    ("faults", ["source.gps.outages_s=[100, 220]"], False),
    ("lego_cylinders", [], True),
]
STATES = ("ok", "degraded", "lost")
STEP = 0.1  # s between two samples


def rows_of(file):
    with open(file) as lines:
        return [list(map(float, line.replace(",", " ").split())) for line in lines if line[:1].isdigit() or line[:1] == "-"]


def states_of(changes):
    """Times and states of the whole."""
    times, states = [float("-inf")], ["ok"]
    for change in changes:
        if change["of"] == "all":
            times.append(change["t_s"])
            states.append(change["state"])
    return times, states


def run(arguments, name, changes, seed, folder):
    command = [arguments.waymark, "run", f"config/{name}.yaml", "--quiet", "--out", folder, "--seed", str(seed)]
    for change in changes + ([] if name == "lego_cylinders" else [f"source.seed={seed}"]):
        command += ["--set", change]
    ended = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    if ended.returncode not in (0, 4):
        raise SystemExit(f"{name}: {ended.stderr}")
    folder = pathlib.Path(folder)
    truth, poses, covariances = (rows_of(folder / file) for file in ("reference.txt", "trajectory.txt", "covariance.csv"))
    times, states = states_of(json.loads((folder / "diagnostics.json").read_text())["health"]["changes"])
    stamps, at = [row[0] for row in truth], [row[0] for row in covariances]
    outside, inside, due = dict.fromkeys(STATES, 0), dict.fromkeys(STATES, 0), float("-inf")
    for t, x, y, *_ in poses:
        k, c = bisect.bisect_left(stamps, t), bisect.bisect_right(at, t) - 1
        if t < due or not 0 < k < len(stamps) or c < 0 or stamps[k] - stamps[k - 1] > 1.0:
            continue
        due = t + STEP
        share = (t - stamps[k - 1]) / (stamps[k] - stamps[k - 1])
        ex, ey = (value - (1 - share) * truth[k - 1][i] - share * truth[k][i] for i, value in ((1, x), (2, y)))
        xx, xy, _, yy = covariances[c][1:5]
        determinant = xx * yy - xy * xy
        off = determinant <= 0.0 or yy * ex * ex - 2 * xy * ex * ey + xx * ey * ey > 9.0 * determinant
        (outside if off else inside)[states[bisect.bisect_right(times, t) - 1]] += 1
    return outside, inside


def percent(part, whole):
    return f"{100.0 * part / whole:.1f} %" if whole else "–"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--runs", type=int, default=10, help="seeds from 1 on")
    parser.add_argument("--only", help="configurations whose name begins so")
    arguments = parser.parse_args()
    print("| configuration | outside 3σ | of that called ok; degraded; lost | time called ok | outside while ok | per run, outside while ok |")
    print("|---|---|---|---|---|---|")
    for name, changes, needs_data in CASES:
        if (arguments.only and not name.startswith(arguments.only)) or (needs_data and "WAYMARK_DATA" not in os.environ):
            continue
        out, within, each = dict.fromkeys(STATES, 0), dict.fromkeys(STATES, 0), []
        for seed in range(1, arguments.runs + 1):
            with tempfile.TemporaryDirectory() as folder:
                outside, inside = run(arguments, name, changes, seed, folder)
            for state in STATES:
                out[state] += outside[state]
                within[state] += inside[state]
            if outside["ok"] + inside["ok"]:
                each.append(100.0 * outside["ok"] / (outside["ok"] + inside["ok"]))
        off, ok = sum(out.values()), out["ok"] + within["ok"]
        whole = off + sum(within.values())
        print(f"| {name}{' with ' + ', '.join(changes) if changes else ''} | {percent(off, whole)} | "
              + "; ".join(percent(out[state], off) for state in STATES)
              + f" | {percent(ok, whole)} | {percent(out['ok'], ok)} | "
              + (f"{min(each):.1f} / **{statistics.median(each):.1f}** / {max(each):.1f} % |" if each else "– |"), flush=True)


if __name__ == "__main__":
    main()
