#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What faults of time and of sensors cost, on the simulator, as a table over seeds (config/faults.yaml).

Example:
  tests/results/faults.py --waymark build/release/bin/waymark --runs 10
"""
import argparse
import bisect
import collections
import json
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

SENSORS = ("wheels", "imu", "gps", "compass")
LATE = {f"source.{s}.delay_jitter_s": 1 for s in SENSORS}
STATES = ("ok", "degraded", "lost")
EVERY = 10  # rows of the covariance: neighbours say the same
CONDITIONS = (
    [("no fault", {})]
    + [("outliers up to 800 m, %d %% of the fixes" % (100 * p), {"source.gps.outlier_probability": p}) for p in (0.01, 0.1, 0.3)]
    + [
        ("fix frozen for 15 s, twice", {"source.gps.frozen_s": "[60, 75, 160, 175]"}),
        ("fix creeps away with 0.5 m/s for 20 s, twice", {"source.gps.drift_s": "[60, 80, 160, 180]"}),
        ("no fix for 5, 10 and 30 s", {"source.gps.outages_s": "[50, 55, 100, 110, 180, 210]"}),
        ("no fix for 120 s", {"source.gps.outages_s": "[100, 220]"}),
        ("field disturbed for 20 s, twice", {"source.magnetism.disturbances_s": "[60, 80, 160, 180]"}),
        ("wheels slip for 5 s, three times", {"source.wheels.spins_s": "[50, 55, 120, 125, 200, 205]"}),
        ("wheels die for 20 s", {"source.wheels.dead_s": "[100, 120]"}),
        ("IMU dies for 20 s", {"source.imu.dead_s": "[100, 120]"}),
        ("wheels die for 20 s without fix", {"source.wheels.dead_s": "[100, 120]", "source.gps.outages_s": "[100, 120]"}),
        ("5 % of everything NaN", {f"source.{s}.nan_probability": 0.05 for s in SENSORS}),
        ("delays 0 to 1 s, every measurement its own; max_latency_s 1", {**LATE, "filter.max_latency_s": 1}),
        ("the same; max_latency_s 0: replayed", {**LATE, "filter.max_latency_s": 0}),
    ]
)


def drive(arguments, settings, seed, out):
    """One run into the folder `out`."""
    command = [arguments.waymark, "run", arguments.config, "--quiet", "--out", out]
    for key, value in {**settings, "filter.seed": seed, "source.seed": seed}.items():
        command += ["--set", f"{key}={value}"]
    subprocess.run(command, check=True, stderr=subprocess.PIPE)


def evaluate(arguments, out, *more):
    """What `waymark evaluate` says of the run in `out`."""
    command = [arguments.waymark, "evaluate", "--json", "--estimate", f"{out}/trajectory.txt", "--reference", f"{out}/reference.txt",
               "--covariance", f"{out}/covariance.csv", *more]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def cell(values, digits=2):
    values = [value for value in values if value is not None]
    return f"{min(values):.{digits}f} / **{statistics.median(values):.{digits}f}** / {max(values):.{digits}f}" if values else "–"


def run(arguments, settings, seed):
    with tempfile.TemporaryDirectory() as out:
        drive(arguments, settings, seed, out)
        result = evaluate(arguments, out)
        trajectory, consistency = result["trajectory"], result["consistency"]
        figures = (trajectory["ate_rms_m"], trajectory["ate_max_m"], 57.29577951308232 * trajectory["yaw_rms_rad"],
                   consistency["nees_mean"])
        return figures, *judge(out)


def rows(file, separator):
    with open(file) as lines:
        return [[float(field) for field in line.split(separator)] for line in lines if line[0] in "-0123456789"]


def judge(out):
    """How often the position was outside its 3σ ellipse in each state of health, and what was named."""
    truth = rows(f"{out}/reference.txt", " ")
    times = [row[0] for row in truth]
    estimate = {row[0]: row for row in rows(f"{out}/trajectory.txt", " ")}
    with open(f"{out}/diagnostics.json") as file:
        changes = json.load(file)["health"]["changes"]
    whole = [c for c in changes if c["of"] == "all"]
    change_times = [c["t_s"] for c in whole]
    seen, off = collections.Counter(), collections.Counter()
    for t, xx, xy, _, yy, _, _ in rows(f"{out}/covariance.csv", ",")[::EVERY]:
        k = bisect.bisect_right(times, t)
        if not 0 < k < len(times):
            continue
        share = (t - times[k - 1]) / (times[k] - times[k - 1])
        x, y = (estimate[t][i] - truth[k - 1][i] - share * (truth[k][i] - truth[k - 1][i]) for i in (1, 2))
        c = bisect.bisect_right(change_times, t)
        state = whole[c - 1]["state"] if c else "ok"
        seen[state] += 1
        off[state] += (yy * x * x - 2 * xy * x * y + xx * y * y) / (xx * yy - xy * xy) > 9
    named = {f"{c['of']} {c['state']}: {c['reason']}" for c in changes if c["of"] != "all" and c["state"] != "ok"}
    return seen, off, named


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", default="config/faults.yaml")
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--runs", type=int, default=10, help="seeds 1..N (default 10)")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    print("| fault | position, RMS [m] | largest [m] | yaw, RMS [°] | NEES, mean | outside 3σ while ok; degraded; lost (share of the time) "
          "| named, in so many of the runs |")
    print("|---|---|---|---|---|---|---|")
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for name, settings in CONDITIONS:
            results = list(pool.map(lambda seed: run(arguments, settings, seed), range(1, arguments.runs + 1)))
            figures = zip(*(result[0] for result in results))
            cells = [cell(values) for values in figures]
            seen, off, named = (sum((collections.Counter(r[i]) for r in results), collections.Counter()) for i in (1, 2, 3))
            total = sum(seen.values())
            cells.append("; ".join(
                f"{100 * off[s] / seen[s]:.1f} % ({100 * seen[s] / total:.0f} %)" if seen[s] else "–" for s in STATES))
            cells.append("; ".join(f"{what} ({count})" for what, count in named.most_common(3)))
            print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
