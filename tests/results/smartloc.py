#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A car among houses with nothing given but geometry: fixes by least squares out of the pseudoranges of the smartLoc drive
in Berlin (WAYMARK_DATA/tuc_smartloc_berlin), and the car's odometry, against its true positions.

Example:
  tests/results/smartloc.py --gps "sigma_m: 5" --out out/smartloc
"""
import gzip
import math
import os
import pathlib
import statistics

from one_run import parser_of, print_scores, rows_of, run

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


def spread(values):
    values = sorted(values)
    return {"rms_m": math.sqrt(statistics.fmean(v * v for v in values)), "median_m": statistics.median(values),
            "within_95_m": values[int(0.95 * len(values))], "max_m": values[-1], "count": len(values)}


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--gps", default="", help="more keys of the receiver, as in: sigma_m: 5")
    options = parser.parse_args()
    truth, odometry, epochs = read(pathlib.Path(os.environ["WAYMARK_DATA"]) / "tuc_smartloc_berlin")
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
    folder = options.out
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "gps.csv", "w") as out:
        out.write("t,lat,lon\n")
        for t, p in fixes:
            latitude, longitude, _ = geodetic(*p)
            out.write(f"{t:.3f},{math.degrees(latitude):.10f},{math.degrees(longitude):.10f}\n")
    (folder / "odometry.csv").write_text("t,v,w\n" + "".join(f"{t:.3f},{v},{w}\n" for t, v, w in odometry))
    keys = f", {options.gps}" if options.gps else ""
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
    code = run(options, folder / "robot.yaml", folder / "out")
    covariance = {t: parts for t, *parts in rows_of(folder / "out/covariance.csv")}
    own, nees = [], []
    for t, x, y, *_ in rows_of(folder / "out/trajectory.txt"):
        place = true_place(t)
        if place is None:
            continue
        ex, ey = x - place[0], y - place[1]
        own.append(math.hypot(ex, ey))
        if t in covariance:
            xx, xy, _, yy = covariance[t][:4]
            nees.append((yy * ex * ex - 2 * xy * ex * ey + xx * ey * ey) / (xx * yy - xy * xy))
    print_scores({"fixes": spread(errors), "estimate": spread(own), "nees": statistics.fmean(nees), "exit_code": code})


if __name__ == "__main__":
    main()
