#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How well `waymark calibrate` finds what is wrong: a simulated drive of five minutes with errors of its own.

The robot of config/calibration.yaml, whose drive is written as a log first, since the simulator reads the mountings from the same YAML;
drawn for each seed: wheel scales, track, lever arm, the GPS's delay, the compass's mounting. For each parameter: whether the truth lies
within 2σ, error / σ, σ and |error|.

Example:
  tests/results/calibration.py --seed 3 --out out/calibration
"""
import json
import random
import re
import subprocess
import sys

from one_run import ROOT, parser_of, print_scores, run


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
        f"source.compass.offset_deg={compass}", "sinks=[{plugin: log}]",
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


def scores_of(row, truth):
    error, sigma = row["estimated"] - truth, row["sigma"]
    return {"within_2_sigma": abs(error) < 2 * sigma, "error_in_sigma": error / sigma, "sigma": sigma, "error": abs(error)}


def main():
    options = parser_of(__doc__).parse_args()
    overrides, truth = drive(options.seed)
    run(options, ROOT / "config/calibration.yaml", options.out / "drive", *overrides)
    found = options.out / "found.json"
    ended = subprocess.run([options.waymark, "calibrate", options.out / "drive/log/replay.yaml", "--json", found, "--out", options.out / "found.yaml"],
                           capture_output=True, text=True)
    converged = "not converged" not in ended.stderr  # its figures are written all the same
    if ended.returncode != 0 and converged:
        sys.exit(ended.stderr)
    rows = {row["name"]: row for row in json.loads(found.read_text())}
    scores = {re.sub(r"\W+", "_", name).strip("_"): scores_of(rows[name], true) for name, true in truth.items() if rows[name]["determined"]}
    print_scores({"converged": converged, "determined": len(scores), **scores})


if __name__ == "__main__":
    main()
