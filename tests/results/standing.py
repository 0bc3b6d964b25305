#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much memory a robot takes that drives for 20 s and then stands for a day, as a table of its resident memory.

The log is made here: wheels at 10 Hz, fixes with a slow error at 1 Hz, scans of six pillars at 2 Hz. The memory is that of the
process when its trajectory has reached a time of the log, so the program runs as fast as it can.

Example:
  tests/results/standing.py --waymark build/release/bin/waymark --hours 24 --at 1 8 16 24
"""
import argparse
import math
import pathlib
import random
import subprocess
import tempfile
import time

SPEED = 0.5
DRIVE = 20.0  # s
PILLARS = [(4, 3), (6, -3), (9, 4), (12, -4), (16, 3), (18, -3)]
RADIUS = 0.2
BEAMS = 121  # 1.5 degrees apart, from -90 degrees
NO_RETURN = 40.0
ROBOT = """
source:
  plugin: csv
  files:
    - { path: twist.csv, sensor: wheels, payload: BodyTwist, time: t_s, columns: { v_x_mps: v_mps, w_z_radps: w_radps } }
    - { path: fixes.csv, sensor: gps, payload: GnssFix, time: t_s, columns: { east_m: east_m, north_m: north_m } }
    - { path: scans.csv, sensor: lidar, payload: LaserScan, time: t_s, columns: { ranges_m: { first: 1, last: 121 } },
        scan: { start_deg: -90, step_deg: 1.5 } }
initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1, yaw_deg: 0, yaw_sigma_deg: 2.0 }
motion: { kind: planar }
sensors:
  - { name: wheels, plugin: odometry, model: twist }
  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.3, offset_sigma_m: 0.7, offset_tau_s: 60 }
  - { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0, 0, 0], yaw_deg: 0 } }
sinks: [{ plugin: tum }, { plugin: landmarks }, { plugin: plot }, { plugin: diagnostics }]
"""
FEATURES = """
maps:
  - name: pillars
    plugin: feature_map
    inputs: [lidar]
    extraction: { range_min_m: 0.2, range_max_m: 14.5, no_return_m: 39, segment_jump_m: 0.5, background_m: 0.8, width_max_m: 1.2 }
    noise: { range_m: 0.05, bearing_deg: 0.5 }
    association: { new_landmark_density_per_m2: 0.01 }
    existence: { view_range_m: 12 }
filter: { particles: 25 }
"""
GRID = """
maps: [{ name: grid, plugin: occupancy_grid, inputs: [lidar], resolution_m: 0.1 }]
filter: { particles: 25 }
"""
CASES = {
    "feature map, 25 particles": FEATURES,
    "occupancy grid, 25 particles": GRID,
    "`maps: []`, 25 particles": "maps: []\nfilter: { particles: 25 }\n",
    "`maps: []`": "maps: []\n",
}


def scan(x, noise):
    row = []
    for k in range(BEAMS):
        bearing = math.radians(-90 + 1.5 * k)
        found = NO_RETURN
        for east, north in PILLARS:
            along = (east - x) * math.cos(bearing) + north * math.sin(bearing)
            across = (east - x) * math.sin(bearing) - north * math.cos(bearing)
            if along > 0 and abs(across) < RADIUS:
                found = min(found, along - math.sqrt(RADIUS ** 2 - across ** 2))
        row.append(f"{found + noise.gauss(0, 0.03):.3f}" if found < 14 else f"{NO_RETURN}")
    return ",".join(row)


def write_log(folder, duration):
    noise = random.Random(1)
    with (folder / "twist.csv").open("w") as file:
        file.write("t_s,v_mps,w_radps\n")
        for i in range(int(duration * 10)):
            drives = i < DRIVE * 10
            v, w = (SPEED + noise.gauss(0, 0.01), noise.gauss(0, 0.01)) if drives else (0.0, 0.0)
            file.write(f"{i / 10:.3f},{v:.5f},{w:.5f}\n")
    with (folder / "fixes.csv").open("w") as file:
        file.write("t_s,east_m,north_m\n")
        east = north = 0.0
        for i in range(int(duration)):
            east, north = (0.983 * error + noise.gauss(0, 0.13) for error in (east, north))
            x = SPEED * min(i + 0.25, DRIVE)
            file.write(f"{i + 0.25:.3f},{x + east + noise.gauss(0, 0.3):.4f},{north + noise.gauss(0, 0.3):.4f}\n")
    standing = [scan(SPEED * DRIVE, noise) for _ in range(500)]
    with (folder / "scans.csv").open("w") as file:
        file.write("t_s" + "".join(f",r{k}" for k in range(BEAMS)) + "\n")
        for i in range(int(duration * 2)):
            t = i / 2 + 0.05
            file.write(f"{t:.3f},{scan(SPEED * t, noise) if t < DRIVE else noise.choice(standing)}\n")


def resident_mb(pid):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return None


def reached(file):
    """Time of the last whole line of a trajectory that is being written [s]."""
    try:
        with file.open("rb") as stream:
            stream.seek(0, 2)
            stream.seek(max(0, stream.tell() - 400))
            lines = stream.read().decode().split("\n")[:-1]
        return float(lines[-1].split()[0])
    except (OSError, IndexError, ValueError):
        return 0.0


def measure(waymark, folder, case, hours):
    """Resident memory when the trajectory has reached each of `hours` [MB], and the seconds of processor time of the run."""
    robot = folder / "robot.yaml"
    robot.write_text(ROBOT + CASES[case])
    with tempfile.TemporaryDirectory() as out:
        trajectory = pathlib.Path(out) / "trajectory.txt.partial"
        process = subprocess.Popen([waymark, "run", str(robot), "--quiet", "--out", out], stdout=subprocess.DEVNULL)
        found, memory = [], None
        while process.poll() is None:
            t = reached(trajectory)
            memory = resident_mb(process.pid) or memory
            while len(found) < len(hours) - 1 and t >= hours[len(found)] * 3600:
                found.append(memory)
            if len(found) == len(hours) - 1 and t >= hours[-1] * 3600 - 60 and len(found) < len(hours):
                found.append(memory)
            time.sleep(0.1)
        if process.returncode != 0:
            raise SystemExit(f"{case}: waymark ended with {process.returncode}")
        found += [memory] * (len(hours) - len(found))
        with (pathlib.Path(out) / "path.txt").open() as path:
            rows = sum(1 for line in path if not line.startswith("#"))
        return found, rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--hours", type=float, default=24.0, help="length of the log")
    parser.add_argument("--at", type=float, nargs="+", help="hours of the log at which memory is read; default: thirds")
    parser.add_argument("--case", choices=CASES, action="append", help="only this one; may be repeated")
    arguments = parser.parse_args()
    hours = arguments.at or [arguments.hours * part / 3 for part in (1, 2, 3)]
    print("| robot | " + " | ".join(f"{hour:g} h" for hour in hours) + " | rows of path.txt |")
    print("|---|" + "---|" * (len(hours) + 1))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        write_log(folder, arguments.hours * 3600)
        for case in arguments.case or CASES:
            found, rows = measure(arguments.waymark, folder, case, hours)
            print(f"| {case} | " + " | ".join(f"{mb:.1f} MB" for mb in found) + f" | {rows} |", flush=True)


if __name__ == "__main__":
    main()
