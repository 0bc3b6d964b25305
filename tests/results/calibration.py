#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How well `waymark calibrate` finds what is wrong: simulated drives of five minutes, each with errors of its own, as a table.

The robot of config/calibration.yaml, whose drive is written as a log first, since the simulator reads the mountings from the same YAML; drawn for each seed: wheel scales, track, lever arm, the GPS's delay, the compass's mounting. For each
parameter: how often the truth lies within 2σ, error / σ, σ and |error| (min / median / max).

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


def calibrate(seed, waymark, folder):
    """The truth of one drive, and what was found."""
    overrides, truth = drive(seed)
    found = folder / "found.json"
    drive_out = folder / str(seed)
    record = [waymark, "run", CONFIG, "--quiet", "--out", drive_out, "--set", "sinks=[{plugin: log}]"]
    for one in overrides:
        record += ["--set", one]
    run = subprocess.run(record, capture_output=True, text=True)
    if run.returncode == 1:
        sys.exit(f"seed {seed}: {run.stderr}")
    run = subprocess.run([waymark, "calibrate", drive_out / "log/replay.yaml", "--json", found, "--out", folder / "found.yaml"],
                         capture_output=True, text=True)
    converged = "not converged" not in run.stderr  # its figures are written all the same
    if run.returncode != 0 and converged:
        sys.exit(f"seed {seed}: {run.stderr}")
    return {"truth": truth, "found": json.loads(found.read_text()), "converged": converged}


def table(drives):
    """One row for each parameter whose truth is known."""
    lines = ["| parameter | within 2σ | error / σ, min / median / max | σ, min / median / max | unsigned error, min / median / max | unit | not determined |",
             "|---|---|---|---|---|---|---|"]
    for name in drives[0]["truth"]:
        rows = [(row, one["truth"][name]) for one in drives for row in one["found"] if row["name"] == name]
        known = [(row["estimated"] - truth, row["sigma"]) for row, truth in rows if row["determined"]]
        ratios = [error / sigma for error, sigma in known]
        lines.append(f"| {name} | {sum(abs(r) < 2 for r in ratios)} of {len(known)} | {spread(ratios, 2)} | {spread([s for _, s in known], 2)} | "
                     f"{spread([abs(e) for e, _ in known], 2)} | {rows[0][0]['unit']} | {len(rows) - len(known)} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path, help="folder for what calibrate found in each drive, as JSON; a drive that is there is not repeated")
    arguments = parser.parse_args()
    drives = []
    with tempfile.TemporaryDirectory() as temporary:
        for seed in range(arguments.first, arguments.first + arguments.seeds):
            kept = arguments.keep / f"{seed}.json" if arguments.keep else None
            if kept and kept.exists():
                drives.append(json.loads(kept.read_text()))
                continue
            drives.append(calibrate(seed, arguments.waymark, pathlib.Path(temporary)))
            if kept:
                kept.parent.mkdir(parents=True, exist_ok=True)
                kept.write_text(json.dumps(drives[-1]))
            print(f"seed {seed}: done", file=sys.stderr, flush=True)
    print(table(drives))
    print(f"\nConverged: {sum(one['converged'] for one in drives)} of {len(drives)}.")


if __name__ == "__main__":
    main()
