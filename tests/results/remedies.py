#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The three remedies against the zero-covariance trap (docs/math/rbpf.md) in all combinations, as a table per data set.

Errors are min / median / max over seeds of the RMS position error on fixes or truth that the filter did not see, nothing aligned
(UTIAS has no absolute sensor: only the sampling fraction applies, aligned by SE(2), robots 1 to 5 pooled).

Example (WAYMARK_DATA is the folder of the recordings):
  tests/results/remedies.py --waymark build/release/bin/waymark --seeds 10 --sets simulation,car_park,victoria_park,utias
"""
import argparse
import os
import statistics
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

from seeds import run_seed

FRACTIONS = (1, 0.2, 0.1)
FIXES = ["--reference", "{out}/held_out.csv", "--lever-arm", "3.78,0.5,0"]
SETS = {
    "simulation": ("config/quickstart.yaml", ["source.seed={seed}", "initial.yaw_deg=5", "initial.yaw_sigma_deg=5"],
                   ["--reference", "{out}/reference.txt"]),
    "car_park": ("config/acfr_car_park.yaml", ["variables.gps=alternate"], FIXES),
    "victoria_park": ("config/victoria_park.yaml", ["variables.gps=stretches"], FIXES),
}


def utias(robot):
    folder = os.path.join(os.environ["WAYMARK_DATA"], "utias_mrclam_7")
    return ("config/utias_mrclam.yaml", [f"variables.robot={robot}"],
            ["--reference", f"{folder}/Robot{robot}_Groundtruth.dat.gz", "--reference-columns", "t=0,x=1,y=2,yaw=3", "--align", "se2"])


def errors(arguments, pool, jobs_of, extra):
    jobs = [(SimpleNamespace(waymark=arguments.waymark, config=config, set=[*overrides, *extra], evaluate=evaluate), seed)
            for config, overrides, evaluate in jobs_of for seed in range(1, arguments.seeds + 1)]
    return [figures["trajectory.ate_rms_m"] for figures in pool.map(lambda job: run_seed(*job), jobs)]


def cell(values):
    return f"{min(values):.3g} / **{statistics.median(values):.3g}** / {max(values):.3g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--sets", default="simulation,car_park,victoria_park,utias")
    parser.add_argument("--particles", default="25")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for name in arguments.sets.split(","):
            print(f"\n{name}, {arguments.particles} particles, {arguments.seeds} seeds\n\n| georeference | GNSS offset block | a = 1 | a = 0.2 | a = 0.1 |\n|---|---|---|---|---|")
            if name == "utias":
                cells = [cell(errors(arguments, pool, [utias(r) for r in range(1, 6)],
                                     [f"filter.particles={arguments.particles}", f"filter.sampling_fraction={a}"])) for a in FRACTIONS]
                print("| - | - | " + " | ".join(cells) + " |", flush=True)
                continue
            for georeference in ("off", "on"):
                for offset in ("off", "on"):
                    extra = [f"filter.particles={arguments.particles}", f"georeference.enabled={'true' if georeference == 'on' else 'false'}"]
                    if offset == "off":
                        extra.append("sensors.gps.offset_sigma_m=0")
                    cells = [cell(errors(arguments, pool, [SETS[name]], [*extra, f"filter.sampling_fraction={a}"])) for a in FRACTIONS]
                    print(f"| {georeference} | {offset} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
