#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Dense maps on logs of CARMEN over seeds: error of all relations, CPU, memory of the maps, as a table.

The memory is that of all particles' maps over the run, looked at every `--every` seconds of the log: its peak, the peak of
what as many copies would take that share nothing, and the ratio of the two.

Examples:
  tests/results/dense.py --waymark build/release/bin/waymark --log intel --particles 1,10,30 --seeds 10
  tests/results/dense.py --waymark build/release/bin/waymark --log fr079 --maps occupancy_grid,octomap_grid --jobs 1
"""
import argparse
import csv
import json
import os
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

from faults import cell

LOGS = {
    "intel": ("config/carmen_intel.yaml", "carmen_intel/intel.relations", "0,0"),
    "fr079": ("config/carmen_fr079.yaml", "carmen_fr079/fr079.relations", "-0.04,0"),
}


def tempering(particles):
    """About 1/particles, as docs/math/occupancy_grid.md says, between the bounds that it gives."""
    return min(0.1, max(0.02, 1 / particles))


def peaks(file):
    """Largest value of every figure over the run [MB], of those that are bytes."""
    largest = {}
    with open(file) as rows:
        for row in csv.DictReader(rows):
            if row["figure"].startswith("memory"):
                largest[row["figure"]] = max(largest.get(row["figure"], 0), float(row["value"]) / 1e6)
    return largest


def timed_run(arguments, config, out, seed, settings):
    """One run into the folder `out`: what it used of CPU and memory."""
    command = [arguments.waymark, "run", config, "--quiet", "--out", out, "--seed", str(seed)]
    for override in [f"{key}={value}" for key, value in settings.items()] + arguments.set:
        command += ["--set", override]
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(" ".join(command) + " failed")
    return usage


def evaluate_path(arguments, out, *more):
    """What `waymark evaluate` says of the best particle's path of the run in `out`."""
    command = [arguments.waymark, "evaluate", "--json", "--estimate", f"{out}/path.txt", *more]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def run(arguments, config, relations, sensor, particles, plugin, seed):
    with tempfile.TemporaryDirectory() as out:
        settings = {"filter.particles": particles, "maps.building.match.evidence_tempering": tempering(particles),
                    "maps.building.plugin": plugin, "sinks.diagnostics.map_figures_every_s": arguments.every}
        usage = timed_run(arguments, config, out, seed, settings)
        scored = evaluate_path(arguments, out, "--relations", relations, f"--relations-sensor={sensor}")["relations"]["all"]
        return {"translation": scored["translation_mean_m"], "rotation": scored["rotation_mean_rad"] * 57.29577951308232,
                "cpu": usage.ru_utime + usage.ru_stime, "process": usage.ru_maxrss / 1024, **peaks(f"{out}/map_figures.csv")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--log", choices=LOGS, default="intel")
    parser.add_argument("--particles", default="10", help="numbers, comma-separated")
    parser.add_argument("--seeds", type=int, default=10, help="seeds 1..N (default 10)")
    parser.add_argument("--maps", default="occupancy_grid", help="map modules, comma-separated; their runs alternate")
    parser.add_argument("--every", type=float, default=5, help="how often the maps' memory is looked at [s of the log] (default 5)")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], help="override of the YAML")
    arguments = parser.parse_args()
    config, relations, sensor = LOGS[arguments.log]
    relations = os.path.join(os.environ["WAYMARK_DATA"], relations)
    plugins = arguments.maps.split(",")
    seeds = range(1, arguments.seeds + 1)
    print("| log | maps | particles | seeds | translation [m] | rotation [deg] | CPU [s] | process, peak [MB] "
          "| maps, peak [MB] | as deep copies, peak [MB] | ratio of the peaks |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for particles in (int(number) for number in arguments.particles.split(",")):
            runs = [(plugin, seed) for seed in seeds for plugin in plugins]
            all_results = list(pool.map(lambda each: run(arguments, config, relations, sensor, particles, *each), runs))
            for index, plugin in enumerate(plugins):
                results = all_results[index::len(plugins)]
                of = lambda key: [result[key] for result in results]
                shared, deep = of("memory_all_bytes"), of("memory_deep_bytes")
                ratio = [one / other for one, other in zip(shared, deep)]
                print(f"| {arguments.log} | {plugin} | {particles} | {arguments.seeds} | {cell(of('translation'), 4)} | {cell(of('rotation'), 3)} "
                      f"| {cell(of('cpu'), 1)} | {max(of('process')):.0f} | {cell(shared)} | {cell(deep)} | {cell(ratio)} |", flush=True)


if __name__ == "__main__":
    main()
