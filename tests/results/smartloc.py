#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A car among houses with nothing given but geometry: fixes by least squares out of the pseudoranges of the smartLoc drive
in Berlin (WAYMARK_DATA/tuc_smartloc_berlin), and the car's odometry, against its true positions.

Example:
  tests/results/smartloc.py --waymark build/release/bin/waymark --data $WAYMARK_DATA/tuc_smartloc_berlin
"""
import argparse
import gzip
import math
import pathlib
import statistics
import subprocess
import tempfile

A, E2 = 6378137.0, 6.69437999014e-3  # WGS-84
OMEGA, C = 7.2921151467e-5, 299792458.0
LEAST_ELEVATION_DEG = 15.0


def solve(rows, values):
    """Least squares by the normal equations, with Gauss elimination; nothing if they are singular."""
    n = len(rows[0])
    m = [[sum(r[i] * r[j] for r in rows) for j in range(n)] + [sum(r[i] * v for r, v in zip(rows, values))] for i in range(n)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(m[k][i]))
        if abs(m[pivot][i]) < 1e-9:
            return None
        m[i], m[pivot] = m[pivot], m[i]
        for k in range(n):
            if k != i:
                factor = m[k][i] / m[i][i]
                m[k] = [a - factor * b for a, b in zip(m[k], m[i])]
    return [m[i][n] / m[i][i] for i in range(n)]


def geodetic(x, y, z):
    longitude, p = math.atan2(y, x), math.hypot(x, y)
    latitude = math.atan2(z, p * (1.0 - E2))
    for _ in range(6):
        n = A / math.sqrt(1.0 - E2 * math.sin(latitude) ** 2)
        height = p / math.cos(latitude) - n
        latitude = math.atan2(z, p * (1.0 - E2 * n / (n + height)))
    return latitude, longitude, height


def fix_of(ranges, guess):
    """ECEF position of one epoch. A clock for each system."""
    systems = sorted({r[5] for r in ranges})
    if len(ranges) < 3 + len(systems):
        return None
    position, clocks = list(guess), [0.0] * len(systems)
    for _ in range(10):
        rows, values = [], []
        for measured, variance, sx, sy, sz, system in ranges:
            d = math.dist(position, (sx, sy, sz))
            clock = systems.index(system)
            sigma = math.sqrt(variance)  # as the receiver has it, larger for low satellites
            rows.append([(position[0] - sx) / d / sigma, (position[1] - sy) / d / sigma, (position[2] - sz) / d / sigma]
                        + [1.0 / sigma if k == clock else 0.0 for k in range(len(systems))])
            turned = OMEGA / C * (sx * position[1] - sy * position[0])  # the Earth turns while the signal travels
            values.append((measured - d - turned - clocks[clock]) / sigma)
        step = solve(rows, values)
        if step is None:
            return None
        position = [p + s for p, s in zip(position, step)]
        clocks = [c + s for c, s in zip(clocks, step[3:])]
        if max(map(abs, step)) < 1e-3:
            return position
    return None


def read(folder):
    truth = [tuple(map(float, line.split()[1:5])) for line in gzip.open(folder / "Berlin_Potsdamer_Platz_GT.txt.gz", "rt")]
    odometry, epochs = [], {}
    for line in gzip.open(folder / "Berlin_Potsdamer_Platz_Input.txt.gz", "rt"):
        words = line.split()
        if words[0] == "odom3":
            odometry.append((float(words[1]), float(words[2]), float(words[7])))
        elif words[0] == "pseudorange3" and float(words[9]) >= LEAST_ELEVATION_DEG:
            epochs.setdefault(float(words[1]), []).append(
                (*map(float, words[2:7]), words[8]))
    return truth, odometry, epochs


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--data", required=True, type=pathlib.Path)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="passed to waymark run")
    parser.add_argument("--gps", default="", help="more keys of the receiver, as in: sigma_m: 5")
    parser.add_argument("--keep", help="folder in which logs and results stay")
    arguments = parser.parse_args()
    truth, odometry, epochs = read(arguments.data)
    latitude0, longitude0, _ = geodetic(*truth[0][1:])
    sin_lat, cos_lat, sin_lon, cos_lon = math.sin(latitude0), math.cos(latitude0), math.sin(longitude0), math.cos(longitude0)

    def enu(p):
        dx, dy, dz = (a - b for a, b in zip(p, truth[0][1:]))
        return -sin_lon * dx + cos_lon * dy, -sin_lat * cos_lon * dx - sin_lat * sin_lon * dy + cos_lat * dz

    places = {t: enu((x, y, z)) for t, x, y, z in truth}
    times = sorted(places)

    def true_place(t):
        near = min(times, key=lambda other: abs(other - t))
        return places[near] if abs(near - t) < 0.05 else None

    fixes, guess = [], truth[0][1:]
    for t in sorted(epochs):
        position = fix_of(epochs[t], guess)
        if position is not None and math.dist(position, guess) < 5000.0:
            fixes.append((t, position))
    errors = [math.dist(enu(p), true_place(t)) for t, p in fixes if true_place(t)]

    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(arguments.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        with open(folder / "gps.csv", "w") as out:
            out.write("t,lat,lon\n")
            for t, p in fixes:
                latitude, longitude, _ = geodetic(*p)
                out.write(f"{t:.3f},{math.degrees(latitude):.10f},{math.degrees(longitude):.10f}\n")
        with open(folder / "odometry.csv", "w") as out:
            out.write("t,v,w\n" + "".join(f"{t:.3f},{v},{w}\n" for t, v, w in odometry))
        keys = f", {arguments.gps}" if arguments.gps else ""
        (folder / "robot.yaml").write_text(f"""source:
  plugin: csv
  files:
    - {{ path: odometry.csv, sensor: odometry, payload: BodyTwist, time: t, columns: {{ v_x_mps: v, w_z_radps: w }} }}
    - {{ path: gps.csv, sensor: gps, payload: GnssFix, time: t, columns: {{ latitude_deg: lat, longitude_deg: lon }} }}
datum: {{ latitude_deg: {math.degrees(latitude0):.10f}, longitude_deg: {math.degrees(longitude0):.10f} }}
sensors:
  - {{ name: odometry, plugin: odometry, model: twist }}
  - {{ name: gps, plugin: dgps, base_p_antenna_m: none{keys} }}
sinks: [{{ plugin: tum }}, {{ plugin: diagnostics }}]
""")
        command = [arguments.waymark, "run", str(folder / "robot.yaml"), "--out", str(folder / "out")]
        for setting in arguments.set:
            command += ["--set", setting]
        ended = subprocess.run(command, stderr=subprocess.PIPE, text=True)
        print("\n".join(line for line in ended.stderr.splitlines() if line.startswith("waymark")))
        covariance = {row.split(",")[0]: tuple(map(float, row.split(",")[1:]))
                      for row in (folder / "out/covariance.csv").read_text().splitlines() if row[:1].isdigit()}
        own, nees = [], []
        for line in (folder / "out/trajectory.txt").read_text().splitlines():
            if line.startswith("#"):
                continue
            stamp, x, y = line.split()[:3]
            place = true_place(float(stamp))
            if place is None:
                continue
            ex, ey = float(x) - place[0], float(y) - place[1]
            own.append(math.hypot(ex, ey))
            if stamp in covariance:
                xx, xy, _, yy = covariance[stamp][:4]
                nees.append((yy * ex * ex - 2 * xy * ex * ey + xx * ey * ey) / (xx * yy - xy * xy))
    for name, values in (("fixes alone", errors), ("waymark", own)):
        values.sort()
        print(f"{name}: {len(values)}, RMS {math.sqrt(statistics.fmean(v * v for v in values)):.2f} m, median "
              f"{statistics.median(values):.2f} m, 95 % {values[int(0.95 * len(values))]:.2f} m, max {values[-1]:.2f} m")
    print(f"NEES mean {statistics.fmean(nees):.2f}, median {statistics.median(nees):.2f}; exit code {ended.returncode}")


if __name__ == "__main__":
    main()
