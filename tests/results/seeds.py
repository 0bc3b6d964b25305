#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a configuration over seeds and prints min / median / max of what `waymark evaluate` says.

Example:
  tests/results/seeds.py --waymark build/release/bin/waymark --seeds 10 config/acfr_car_park.yaml \\
      --set filter.particles=25 --evaluate --reference '{out}/held_out.csv' --lever-arm 3.78,0.5,0 --align se2 \\
      --landmarks '{out}/landmarks.csv' --survey "$WAYMARK_DATA/acfr_car_park/beacons.csv"
"""
import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor


def numbers(node, path=""):
    """All numbers of a JSON document as (dotted path, value)."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield from numbers(value, f"{path}.{key}" if path else key)
    elif isinstance(node, list):
        if path.endswith("missed"):
            yield path, len(node)
        for index, item in enumerate(node):
            if isinstance(item, dict):
                yield from numbers(item, f"{path}.{item.get('sensor', index)}")
    elif isinstance(node, (int, float)) and not isinstance(node, bool):
        yield path, node


def run_seed(arguments, seed):
    with tempfile.TemporaryDirectory() as out:
        command = [arguments.waymark, "run", arguments.config, "--out", out, "--seed", str(seed), "--quiet"]
        for override in arguments.set:
            command += ["--set", override.replace("{seed}", str(seed))]
        subprocess.run(command, check=True, stderr=subprocess.PIPE)
        evaluate = [a.replace("{out}", out) for a in arguments.evaluate]
        result = subprocess.run([arguments.waymark, "evaluate", "--estimate", f"{out}/trajectory.txt", "--json"] + evaluate,
                                check=True, stdout=subprocess.PIPE)
        return dict(numbers(json.loads(result.stdout)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("config")
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--seeds", type=int, default=10, help="seeds 1..N (default 10)")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], help="override of the YAML; {seed} becomes the seed, for source.seed={seed}")
    parser.add_argument("--each", action="store_true", help="also every seed's figure, in the order of the seeds")
    parser.add_argument("--show", default="", help="only figures whose name contains one of these, comma-separated")
    parser.add_argument("--evaluate", nargs=argparse.REMAINDER, default=[], help="the rest goes to `waymark evaluate`; {out} is the run's folder")
    arguments = parser.parse_args()
    try:
        with ThreadPoolExecutor(arguments.jobs) as pool:
            results = list(pool.map(lambda seed: run_seed(arguments, seed), range(1, arguments.seeds + 1)))
    except subprocess.CalledProcessError as error:
        sys.exit(f"{' '.join(error.cmd)}: exit code {error.returncode}\n{(error.stderr or b'').decode()}")
    wanted = [w for w in arguments.show.split(",") if w]
    print(f"{arguments.seeds} seeds, {' '.join(arguments.set) or 'as configured'}: min / median / max")
    for name in results[0]:
        if wanted and not any(w in name for w in wanted):
            continue
        values = [r[name] for r in results if r.get(name) is not None]
        if values:
            print(f"  {name:<44} {min(values):9.4g} / {statistics.median(values):9.4g} / {max(values):9.4g}")
            if arguments.each:
                print("    " + " ".join(f"{v:.3g}" for v in values))


if __name__ == "__main__":
    main()
