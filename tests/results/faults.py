#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What faults of time and of sensors cost, on the simulator, as a table over seeds (config/faults.yaml).

Example:
  tests/results/faults.py --waymark build/release/bin/waymark --runs 10
"""
import argparse
import json
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

SENSORS = ("wheels", "imu", "gps")
LATE = {f"source.{s}.delay_jitter_s": 1 for s in SENSORS}
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
        ("the same; max_latency_s 0", {**LATE, "filter.max_latency_s": 0}),
    ]
)


def run(arguments, settings, seed):
    with tempfile.TemporaryDirectory() as out:
        command = [arguments.waymark, "run", arguments.config, "--quiet", "--out", out]
        for key, value in {**settings, "filter.seed": seed, "source.seed": seed}.items():
            command += ["--set", f"{key}={value}"]
        subprocess.run(command, check=True, stderr=subprocess.PIPE)
        scored = subprocess.run(
            [arguments.waymark, "evaluate", "--json", "--estimate", f"{out}/trajectory.txt", "--reference", f"{out}/reference.txt",
             "--covariance", f"{out}/covariance.csv"],
            check=True, stdout=subprocess.PIPE)
        result = json.loads(scored.stdout)
        trajectory, consistency = result["trajectory"], result["consistency"]
        return (trajectory["ate_rms_m"], trajectory["ate_max_m"], 57.29577951308232 * trajectory["yaw_rms_rad"],
                consistency["nees_mean"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", default="config/faults.yaml")
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--runs", type=int, default=10, help="seeds 1..N (default 10)")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    print("| fault | position, RMS [m] | largest [m] | yaw, RMS [°] | NEES, mean |")
    print("|---|---|---|---|---|")
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for name, settings in CONDITIONS:
            results = list(pool.map(lambda seed: run(arguments, settings, seed), range(1, arguments.runs + 1)))
            cells = [f"{min(v):.2f} / **{statistics.median(v):.2f}** / {max(v):.2f}" for v in zip(*results)]
            print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
