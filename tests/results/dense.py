#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A dense map on a log of CARMEN: error of all relations, and memory of the maps.

The memory is that of all particles' maps over the run, looked at every 5 s of the log: its peak, the peak of what as many
copies would take that share nothing, and the ratio of the two. The tempering is about 1/particles, as
docs/math/occupancy_grid.md says.

Example:
  tests/results/dense.py --log fr079 --particles 10 --maps octomap_grid --seed 3 --out out/dense
"""
import csv
import math
import os

from one_run import ROOT, evaluate, parser_of, print_scores, run

LOGS = {
    "intel": ("config/carmen_intel.yaml", "carmen_intel/intel.relations", "0,0"),
    "fr079": ("config/carmen_fr079.yaml", "carmen_fr079/fr079.relations", "-0.04,0"),
}


def peaks(file):
    """Largest value of every figure over the run [MB], of those that are bytes."""
    largest = {}
    with open(file) as rows:
        for row in csv.DictReader(rows):
            if row["figure"].startswith("memory"):
                largest[row["figure"]] = max(largest.get(row["figure"], 0), float(row["value"]) / 1e6)
    return largest


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--log", choices=LOGS, default="intel")
    parser.add_argument("--particles", type=int, default=10)
    parser.add_argument("--maps", default="occupancy_grid", help="map module")
    options = parser.parse_args()
    config, relations, sensor = LOGS[options.log]
    run(options, ROOT / config, options.out, f"filter.particles={options.particles}", f"maps.building.plugin={options.maps}",
        f"maps.building.match.evidence_tempering={min(0.1, max(0.02, 1 / options.particles))}", "sinks.diagnostics.map_figures_every_s=5",
        more=["--seed", str(options.seed)])
    scored = evaluate(options, "--estimate", options.out / "path.txt", "--relations", os.path.join(os.environ["WAYMARK_DATA"], relations),
                      f"--relations-sensor={sensor}")["relations"]["all"]
    largest = peaks(options.out / "map_figures.csv")
    shared, deep = largest["memory_all_bytes"], largest["memory_deep_bytes"]
    print_scores({"translation_m": scored["translation_mean_m"], "rotation_deg": math.degrees(scored["rotation_mean_rad"]),
                  "maps_shared_mb": shared, "maps_deep_mb": deep, "ratio": shared / deep})


if __name__ == "__main__":
    main()
