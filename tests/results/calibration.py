#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How well `waymark calibrate` finds what is wrong: simulated drives of five minutes, each with errors of its own, as a table.

The robot of config/calibration.yaml, whose drive is written as a log first, since the simulator reads the mountings from the same YAML; drawn for each seed: wheel scales, track, lever arm, the GPS's delay, the compass's mounting. For each
parameter: how often the truth lies within 2σ, the largest |error| / σ, σ and |error| (min / median / max).

Example:
  tests/results/calibration.py --waymark build/release/bin/waymark --seeds 50
"""
import argparse
import json
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config/calibration.yaml"


def drive(seed):
    """Overrides of the simulator, and the true values of the parameters."""
    draw = random.Random(seed)
    left, right = (draw.uniform(-0.03, 0.03) for _ in range(2))
    track = 0.5 * (1 + draw.uniform(-0.05, 0.05))
    antenna = [draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3), 0.5]
    delay = draw.uniform(-0.15, 0.15)
    compass = draw.uniform(-8, 8)
    overrides = [
        f"source.seed={seed}", f"source.wheels.track_m={track}", f"source.wheels.scale_error_left={left}",
        f"source.wheels.scale_error_right={right}", f"source.gps.base_p_antenna_m={antenna}", f"source.gps.stamp_offset_s={delay}",
        f"source.compass.offset_deg={compass}",
    ]
    # What the wheels give is v_l (1 + left), v_r (1 + right): v = (v_l + v_r) / 2, w = (v_r - v_l) / track.
    mean = 0.5 * (1 / (1 + left) + 1 / (1 + right))
    half_difference = 0.5 * (1 / (1 + right) - 1 / (1 + left))
    truth = {
        "wheels.speed_scale": mean,
        "wheels.curvature_per_m": 2 * half_difference / track,
        "wheels.track_m": track,
        "gps.base_p_antenna_m[0]": antenna[0], "gps.base_p_antenna_m[1]": antenna[1],
        "gps.delay_s": delay, "compass.delay_s": 0.0, "gps.sigma_m": 0.05,
        "compass.base_T_sensor.yaw_deg": -compass,
    }
    return overrides, truth


def spread(values, digits):
    return " / ".join(f"{v:.{digits}g}" for v in (min(values), statistics.median(values), max(values)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", type=pathlib.Path, help="folder for what calibrate found in each drive, as JSON")
    arguments = parser.parse_args()
    errors, sigmas, units, undetermined = {}, {}, {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(arguments.first, arguments.first + arguments.seeds):
            overrides, truth = drive(seed)
            found = pathlib.Path(folder) / "found.json"
            drive_out = pathlib.Path(folder) / str(seed)
            record = [arguments.waymark, "run", CONFIG, "--quiet", "--out", drive_out, "--set", "sinks=[{plugin: log}]"]
            for one in overrides:
                record += ["--set", one]
            run = subprocess.run(record, capture_output=True, text=True)
            if run.returncode == 1:
                sys.exit(f"seed {seed}: {run.stderr}")
            run = subprocess.run([arguments.waymark, "calibrate", drive_out / "log/replay.yaml", "--jobs", str(arguments.jobs), "--json", found,
                                  "--out", pathlib.Path(folder) / "found.yaml"], capture_output=True, text=True)
            if run.returncode != 0:
                sys.exit(f"seed {seed}: {run.stderr}")
            if arguments.keep:
                arguments.keep.mkdir(parents=True, exist_ok=True)
                (arguments.keep / f"{seed}.json").write_text(json.dumps({"truth": truth, "found": json.loads(found.read_text())}))
            for row in json.loads(found.read_text()):
                if row["name"] not in truth:
                    continue
                if not row["determined"]:
                    undetermined[row["name"]] = undetermined.get(row["name"], 0) + 1
                    continue
                errors.setdefault(row["name"], []).append(row["estimated"] - truth[row["name"]])
                sigmas.setdefault(row["name"], []).append(row["sigma"])
                units[row["name"]] = row["unit"]
            if errors:
                print(f"seed {seed}: {max(abs(e[-1]) / s[-1] for e, s in zip(errors.values(), sigmas.values())):.1f} sigma at most",
                      file=sys.stderr, flush=True)
    print("| parameter | within 2σ | largest error / σ | σ, min / median / max | error, min / median / max | unit | not determined |\n|---|---|---|---|---|---|---|")
    for name, list_ in errors.items():
        ratios = [abs(e) / s for e, s in zip(list_, sigmas[name])]
        print(f"| {name} | {sum(r < 2 for r in ratios)} of {len(ratios)} | {max(ratios):.1f} | {spread(sigmas[name], 2)} | "
              f"{spread([abs(e) for e in list_], 2)} | {units[name]} | {undetermined.get(name, 0)} |")


if __name__ == "__main__":
    main()
