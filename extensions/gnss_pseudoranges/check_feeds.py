#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Feeds the plugin's own payload by csv, json and mcap, and fails unless all runs leave the same bytes.

    WAYMARK_PLUGIN_PATH=build ./check_feeds.py WAYMARK OUT
"""
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys

A, E2 = 6378137.0, 6.69437999014e-3  # WGS-84
OMEGA, C = 7.2921151467e-5, 299792458.0
LATITUDE, LONGITUDE = math.radians(52.5), math.radians(13.4)

CSV = """source:
  plugin: csv
  files:
    - { path: odometry.csv, sensor: odometry, payload: BodyTwist, time: t, columns: { v_x_mps: v, w_z_radps: w } }
    - path: satellites.csv
      sensor: gnss
      payload: Pseudoranges
      time: t
      group_by_time: true
      columns: { system: system, number: number, range_m: range, x_m: x, y_m: y, z_m: z, cn0_dbhz: cn0 }
"""
JSON = """source:
  plugin: json
  from: file
  file: log.jsonl
  channels:
    - { sensor: odometry, payload: BodyTwist }
    - { sensor: gnss, payload: gnss/Pseudoranges@1 }
"""
MCAP = """source:
  plugin: mcap
  file: out_csv/flight.mcap
  channels:
    - { topic: /waymark/odometry, sensor: odometry }
    - { topic: /waymark/gnss, sensor: gnss }
"""
RECORD = "source: { plugin: mcap, file: out_csv/flight.mcap }\n"
ROBOT = """initial: { yaw_deg: 0 }
motion: { kind: planar }
sensors:
  - { name: odometry, plugin: odometry, model: twist }
  - { name: gnss, plugin: gnss_pseudoranges, base_p_antenna_m: none, systems: [1, 4], error_time_s: 0 }
sinks: [{ plugin: tum }, { plugin: recorder }]
"""


def rotated(p, angle):
    return (math.cos(angle) * p[0] - math.sin(angle) * p[1], math.sin(angle) * p[0] + math.cos(angle) * p[1], p[2])


def ecef(east, north, up):
    n = A / math.sqrt(1.0 - E2 * math.sin(LATITUDE) ** 2)
    sa, ca, so, co = math.sin(LATITUDE), math.cos(LATITUDE), math.sin(LONGITUDE), math.cos(LONGITUDE)
    return (n * ca * co - so * east - sa * co * north + ca * co * up,
            n * ca * so + co * east - sa * so * north + ca * so * up,
            n * (1.0 - E2) * sa + ca * north + sa * up)


def sky():
    for number in range(10):
        azimuth, elevation = 2.4 * number, 0.2 + 0.12 * number
        flat = 2.2e7 * math.cos(elevation)
        yield number, ecef(flat * math.sin(azimuth), flat * math.cos(azimuth), 2.2e7 * math.sin(elevation))


def drive():
    """(t, v, w, satellites) of a circle at 5 Hz, with noise of 1 m."""
    noise = random.Random(1)
    satellites = list(sky())
    for k in range(200):
        t, v, w = round(100.0 + 0.2 * k, 1), 5.0, 0.1
        yaw = w * 0.2 * k
        place = ecef(v / w * math.sin(yaw), v / w * (1.0 - math.cos(yaw)), 0.0)
        seen = []
        for number, p in satellites:
            travel = math.dist(place, p) / C
            distance = math.dist(place, rotated(p, -OMEGA * travel))
            late = 7.0 if number % 2 else 0.0
            seen.append({"system": 4 if number % 2 else 1, "number": number,
                         "range_m": distance + 1e5 - 50.0 * 0.2 * k + late + noise.gauss(0.0, 1.0),
                         "x_m": p[0], "y_m": p[1], "z_m": p[2], "cn0_dbhz": 50.0})
        yield t, v, w, seen


def main():
    waymark, out = sys.argv[1], pathlib.Path(sys.argv[2])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    with open(out / "odometry.csv", "w") as odometry, open(out / "satellites.csv", "w") as satellites, \
            open(out / "log.jsonl", "w") as log:
        odometry.write("t,v,w\n")
        satellites.write("t,system,number,range,x,y,z,cn0\n")
        for t, v, w, seen in drive():
            odometry.write(f"{t},{v},{w}\n")
            log.write(json.dumps({"sensor": "odometry", "stamp_ns": round(10 * t) * 10**8, "v_x_mps": v, "w_z_radps": w}) + "\n")
            for one in seen:
                satellites.write(f"{t}," + ",".join(repr(value) for value in one.values()) + "\n")
            log.write(json.dumps({"sensor": "gnss", "stamp_ns": round(10 * t) * 10**8, "satellites": seen}) + "\n")
    results = {}
    for name, source in {"csv": CSV, "json": JSON, "mcap": MCAP, "record": RECORD}.items():
        (out / f"{name}.yaml").write_text(source + ROBOT)
        subprocess.run([waymark, "run", out / f"{name}.yaml", "--out", out / f"out_{name}", "--quiet"], check=True)
        results[name] = (out / f"out_{name}/trajectory.txt").read_bytes()
    last = results["csv"].decode().splitlines()[-1].split()
    yaw = 0.1 * (float(last[0]) - 100.0)
    # The map begins at the first fix, so only the way across is known: the chord of the circle.
    first = [line for line in results["csv"].decode().splitlines() if not line.startswith("#")][0].split()
    start = 0.1 * (float(first[0]) - 100.0)
    chord = math.dist((float(first[1]), float(first[2])), (float(last[1]), float(last[2])))
    right = 2.0 * 50.0 * abs(math.sin(0.5 * (yaw - start)))
    if abs(chord - right) > 3.0:
        sys.exit(f"the robot is {chord:.2f} m from where it started; expected {right:.2f} m within 3 m")
    wrong = [name for name, result in results.items() if result != results["csv"]]
    if wrong:
        sys.exit(f"not the trajectory of csv: {', '.join(wrong)}")
    print(f"csv, json and mcap: {len(results['csv'].splitlines())} equal rows; {chord:.2f} m from the start, {right:.2f} m is right")


if __name__ == "__main__":
    main()
