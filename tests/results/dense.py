#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Dense maps on logs of CARMEN over seeds: error of all relations, CPU, memory, as a table.

Example:
  tests/results/dense.py --waymark build/release/bin/waymark --log intel --particles 1,10,30 --seeds 10
"""
import argparse
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


def run(arguments, config, relations, sensor, particles, seed):
    with tempfile.TemporaryDirectory() as out:
        settings = {"filter.particles": particles, "maps.building.match.evidence_tempering": tempering(particles)}
        command = [arguments.waymark, "run", config, "--quiet", "--out", out, "--seed", str(seed)]
        for override in [f"{key}={value}" for key, value in settings.items()] + arguments.set:
            command += ["--set", override]
        process = subprocess.Popen(command)
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            raise SystemExit(" ".join(command) + " failed")
        command = [arguments.waymark, "evaluate", "--json", "--estimate", f"{out}/path.txt", "--relations", relations,
                   f"--relations-sensor={sensor}"]
        scored = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)["relations"]["all"]
        with open(f"{out}/diagnostics.json") as file:
            figures = json.load(file)["landmarks"][0]["figures"]
        return {"translation": scored["translation_mean_m"], "rotation": scored["rotation_mean_rad"] * 57.29577951308232,
                "cpu": usage.ru_utime + usage.ru_stime, "peak": usage.ru_maxrss / 1024,
                **{key: value / 1e6 for key, value in figures.items() if key.startswith("memory")}}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--log", choices=LOGS, default="intel")
    parser.add_argument("--particles", default="10", help="numbers, comma-separated")
    parser.add_argument("--seeds", type=int, default=10, help="seeds 1..N (default 10)")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], help="override of the YAML")
    arguments = parser.parse_args()
    config, relations, sensor = LOGS[arguments.log]
    relations = os.path.join(os.environ["WAYMARK_DATA"], relations)
    print("| log | particles | seeds | translation [m] | rotation [deg] | CPU [s] | process, peak [MB] | maps at the end: shared / deep copies [MB] |")
    print("|---|---|---|---|---|---|---|---|")
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for particles in (int(number) for number in arguments.particles.split(",")):
            results = list(pool.map(lambda seed: run(arguments, config, relations, sensor, particles, seed), range(1, arguments.seeds + 1)))
            of = lambda key: [result.get(key) for result in results]
            memory = "–"
            if results[0].get("memory_all_bytes") is not None:
                shared, deep = (statistics.median(of(key)) for key in ("memory_all_bytes", "memory_deep_bytes"))
                memory = f"{shared:.2f} / {deep:.2f} ({shared / deep:.2f})"
            print(f"| {arguments.log} | {particles} | {arguments.seeds} | {cell(of('translation'), 4)} | {cell(of('rotation'), 3)} "
                  f"| {cell(of('cpu'), 1)} | {max(of('peak')):.0f} | {memory} |", flush=True)


if __name__ == "__main__":
    main()
