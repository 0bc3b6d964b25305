#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What outages of the GPS of 5, 10 and 30 s cost with other sensors and without, on the simulator (config/faults.yaml).

Example:
  tests/results/outages.py --waymark build/release/bin/waymark --runs 30
"""
import argparse
import tempfile
from concurrent.futures import ThreadPoolExecutor

from faults import cell, drive, evaluate
from subsets import SENSORS, without

OUTAGES = ((50, 55), (100, 110), (180, 210))  # s
SUBSETS = (("wheels", "gps"), ("wheels", "gps", "compass"), ("wheels", "imu", "gps"), SENSORS, ("imu", "gps"), ("imu", "gps", "compass"))


def run(arguments, subset, seed):
    outages = "[" + ", ".join(str(t) for outage in OUTAGES for t in outage) + "]"
    with tempfile.TemporaryDirectory() as out:
        drive(arguments, {**without(subset), "source.gps.outages_s": outages}, seed, out)
        return evaluate(arguments, out, *(f"--outage={begin}:{end}" for begin, end in OUTAGES))["outages"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", default="config/faults.yaml")
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--runs", type=int, default=30, help="seeds 1..N (default 30)")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    print("| sensors | outage [s] | error at its end [m] | predicted σ [m] | error [σ] | largest step after it [m] | step [σ] | steps within 3σ |")
    print("|---|---|---|---|---|---|---|---|")
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for subset in SUBSETS:
            results = list(pool.map(lambda seed: run(arguments, subset, seed), range(1, arguments.runs + 1)))
            for k, (begin, end) in enumerate(OUTAGES):
                of = lambda key: [result[k][key] for result in results]
                steps = of("step_sigma")
                cells = [cell(of(key)) for key in ("position_end_m", "sigma_end_m", "error_end_sigma", "step_m")]
                print(f"| {', '.join(subset)} | {end - begin} | " + " | ".join(cells)
                      + f" | {cell(steps)} | {sum(step <= 3 for step in steps)} of {len(steps)} |", flush=True)


if __name__ == "__main__":
    main()
