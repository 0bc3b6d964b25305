#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much disturbance SLAM stands, on the simulator, as a table of success rates over worlds.

A run is a success if the estimate is never farther than --bound metres from the truth, nothing aligned: a wrong loop closure
throws it much farther. Every run has its own world, its own noise and its own seed of the filter. GPS is not fused.

Example:
  tests/results/robustness.py --waymark build/release/bin/waymark --runs 10
"""
import argparse
import json
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

BASE_NOISE = 0.005  # density of the wheels' noise in config/quickstart.yaml
BASE_LANDMARKS = 30
CONDITIONS = (
    [("odometry noise x %g" % f, {"source.wheels.noise_m_per_sqrt_s": BASE_NOISE * f}) for f in (0.5, 1, 2, 4)]
    + [("%d landmarks" % n, {"source.landmarks.count": n}) for n in (8, 15, 60)]
    + [("clutter %g per scan" % c, {"source.lidar.clutter_per_scan": c}) for c in (1, 3, 10)]
    + [("%d %% of landmarks missed" % (100 * p), {"source.lidar.miss_probability": p}) for p in (0.1, 0.3, 0.5)]
)


def run(arguments, settings, particles, seed):
    with tempfile.TemporaryDirectory() as out:
        settings = {**settings, "filter.particles": particles, "filter.seed": seed, "source.seed": seed,
                    "source.landmarks.seed": seed, "sensors.gps.fuse": "none"}
        command = [arguments.waymark, "run", arguments.config, "--quiet", "--out", out]
        for key, value in settings.items():
            command += ["--set", f"{key}={value}"]
        subprocess.run(command, check=True, stderr=subprocess.PIPE)
        scored = subprocess.run(
            [arguments.waymark, "evaluate", "--json", "--estimate", f"{out}/trajectory.txt", "--reference", f"{out}/reference.txt",
             "--landmarks", f"{out}/landmarks.csv", "--survey", f"{out}/reference_landmarks.csv"],
            check=True, stdout=subprocess.PIPE)
        result = json.loads(scored.stdout)
        return result["trajectory"]["ate_max_m"], result["landmarks"]["duplicates"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", default="config/quickstart.yaml")
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--particles", default="1,10,25,100")
    parser.add_argument("--bound", type=float, default=1.0, help="farthest that a success may be from the truth [m]")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    particles = [int(m) for m in arguments.particles.split(",")]
    print("| disturbance | " + " | ".join(f"M = {m}" for m in particles) + " |")
    print("|---|" + "---|" * len(particles))
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for name, settings in CONDITIONS:
            cells = []
            for m in particles:
                results = list(pool.map(lambda seed: run(arguments, settings, m, seed), range(1, arguments.runs + 1)))
                good = sum(far <= arguments.bound for far, _ in results)
                farthest = sorted(far for far, _ in results)
                cells.append(f"{100 * good // len(results)} % ({farthest[len(farthest) // 2]:.2f} m, {farthest[-1]:.2f} m)")
            print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
