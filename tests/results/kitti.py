#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the extraction finds of the poles and trunks in the excerpt of KITTI, as the tables of docs/results/kitti.md.

Runs config/kitti_raw.yaml with `extraction_table` and needs nothing but that table. The car's own motion is taken out by
matching the accepted candidates of each scan with those before (nearest within 0.6 m) and a rigid motion in the plane by robust
least squares (weights of Geman and McClure down to 0.05 m): cars move. Which pole is which comes from a list counted by hand.

Example:
  tests/results/kitti.py --waymark build/dev/bin/waymark
  tests/results/kitti.py --waymark build/dev/bin/waymark --heights 0.5,1.5 --heights 1.7,2.1 --heights 1.7,2.4
"""
import argparse
import csv
import math
import os
import statistics
import subprocess
import tempfile
from collections import Counter, defaultdict

# Counted by hand in the cloud of all 20 turns: what is narrower than 1.2 m and upright between 1.2 and 3.2 m above the road in
# at least 8 turns. A crate and a piece of a lorry that are so, too, are left out. Place in the base frame of the first scan and
# thickness [m] (5 % to 95 % of the points across the line of sight, over 0.9, where there is no board or signal).
SURVEY = [
    ("trunk", -9.9, 6.2, 0.58), ("trunk", -13.3, 6.2, 0.74), ("trunk", -10.9, -11.8, 0.62), ("trunk", -30.2, -14.7, 0.42),
    ("trunk", -30.0, -24.1, 0.23), ("trunk", -49.8, -25.3, 0.52), ("trunk", -54.4, 14.9, 0.40), ("trunk", -50.2, 32.4, 0.56),
    ("trunk", -51.3, -30.8, 0.67), ("post", 1.5, 15.1, 0.37), ("post, board above 2 m", 7.7, 14.2, 0.16), ("post", -28.6, 6.1, 0.30),
    ("post, board above 2.4 m", -28.5, 14.9, 0.33), ("post", 12.8, 29.6, 0.30), ("mast", 29.1, 28.6, 0.22), ("mast", 31.7, 28.3, 0.17),
    ("mast, crate beside", 35.9, 29.8, 0.29), ("mast", -39.2, 28.5, 0.27), ("mast", 44.6, 18.6, 0.17), ("mast", 54.2, 8.8, 0.33),
    ("mast, signals above 2 m", 35.5, 5.8, 0.16), ("mast, signals above 2 m", 32.9, 18.1, 0.20),
    ("mast, signals above 2.4 m", 48.0, -8.0, 0.22)]
SAME_M = 0.8  # a candidate this near to a place of the survey is that thing
SCANNER_X_M, START_DEG, STEP_DEG = 0.76, -180.0, 0.2  # as in config/kitti_raw.yaml


def to_map(pose, x, y):
    px, py, yaw = pose
    return px + math.cos(yaw) * x - math.sin(yaw) * y, py + math.sin(yaw) * x + math.cos(yaw) * y


def to_base(pose, x, y):
    px, py, yaw = pose
    return math.cos(yaw) * (x - px) + math.sin(yaw) * (y - py), -math.sin(yaw) * (x - px) + math.cos(yaw) * (y - py)


def rigid_motion(pairs):
    """(x, y, yaw) that takes the first points to the second ones, weighted least squares."""
    total = sum(w for w, _, _ in pairs)
    ax, ay, bx, by = (sum(w * p for w, p in values) / total for values in (
        [(w, a[0]) for w, a, _ in pairs], [(w, a[1]) for w, a, _ in pairs],
        [(w, b[0]) for w, _, b in pairs], [(w, b[1]) for w, _, b in pairs]))
    cross = sum(w * ((a[0] - ax) * (b[1] - by) - (a[1] - ay) * (b[0] - bx)) for w, a, b in pairs)
    dot = sum(w * ((a[0] - ax) * (b[0] - bx) + (a[1] - ay) * (b[1] - by)) for w, a, b in pairs)
    yaw = math.atan2(cross, dot)
    return bx - math.cos(yaw) * ax + math.sin(yaw) * ay, by - math.sin(yaw) * ax - math.cos(yaw) * ay, yaw


def own_motion(scans):
    """Pose of the base at each scan, from the accepted candidates alone; the first one is the origin."""
    poses, known = [], []  # known: what was seen last where
    for scan in scans:
        seen = [(c["x"], c["y"]) for c in scan if c["verdict"] == "accepted"]
        pose = poses[-1] if poses else (0.0, 0.0, 0.0)
        if len(poses) > 1:  # as far again as last time
            pose = tuple(2 * a - b for a, b in zip(poses[-1], poses[-2]))
        for n in range(40 if poses else 0):
            scale = max(0.05, 0.5 * 0.8**n)  # what lies farther off counts less and less: cars drive
            pairs = []
            for p in seen:
                m = to_map(pose, *p)
                near = min(known, key=lambda k: math.dist(k, m))
                off = math.dist(near, m)
                if off < 0.6:
                    pairs.append((1 / (0.05**2 + (0.003 * math.hypot(*p))**2) / (1 + (off / scale)**2)**2, p, near))
            if len(pairs) < 3:
                break  # too few for a result
            pose = rigid_motion(pairs)
        poses.append(pose)
        for p in seen:
            m = to_map(pose, *p)
            if all(math.dist(k, m) > 0.6 for k in known):
                known.append(m)
    return poses


def distance(p, q):
    """D of (4.7): 1 - sum of the roots of products."""
    return 1.0 - sum(math.sqrt(a * b) for a, b in zip(p, q))


def read_table(file):
    scans = defaultdict(list)
    with open(file, newline="", encoding="utf-8") as text:
        for row in csv.DictReader(text):
            bins = [float(b) for b in row["signature"].split(";")] if row["signature"] else []
            scans[row["t_s"]].append({
                "verdict": row["verdict"], "beams": (int(row["first_beam"]), int(row["last_beam"])), "range": float(row["range_m"]), "x": float(row["x_m"]), "y": float(row["y_m"]), "radius": float(row["radius_m"]),
                "in_image": row["in_image"] == "1", "signature": [b / sum(bins) for b in bins]})
    return [scans[t] for t in sorted(scans, key=float)]


def extract(arguments, settings):
    with tempfile.TemporaryDirectory() as out:
        table = os.path.join(out, "table.csv")
        command = [arguments.waymark, "run", arguments.config, "--quiet", "--out", out, "--set", f"maps.poles.extraction_table={table}"]
        for key, value in settings.items():
            command += ["--set", f"{key}={value}"]
        subprocess.run(command, check=True)
        return read_table(table)


def why_not(scan, place):
    """What became of a thing that was not found at this place of the base frame, in words."""
    d, n = min((math.dist((c["x"], c["y"]), place), n) for n, c in enumerate(scan))
    if d < SAME_M:
        return scan[n]["verdict"].replace("_", " ")
    x, y = place[0] - SCANNER_X_M, place[1]
    beam = (math.degrees(math.atan2(y, x)) - START_DEG) / STEP_DEG
    for c in scan:  # it may be part of something wide, or behind it
        if c["beams"][0] - 1 <= beam <= c["beams"][1] + 1:
            if c["range"] < math.hypot(x, y) - SAME_M:
                return "hidden by what is nearer"
            if c["range"] < math.hypot(x, y) + SAME_M:
                return c["verdict"].replace("_", " ")
    return "no return"


def find(scans, poses):
    """Per thing of the survey and scan the accepted candidate that is it; and what all others were."""
    sightings, reasons, others = defaultdict(dict), defaultdict(Counter), 0
    for k, (scan, pose) in enumerate(zip(scans, poses)):
        used = set()
        for i, (_, x, y, _) in enumerate(SURVEY):
            place = to_base(pose, x, y)
            near = [(math.dist((c["x"], c["y"]), place), n) for n, c in enumerate(scan)]
            good = min(((d, n) for d, n in near if scan[n]["verdict"] == "accepted"), default=(math.inf, -1))
            if good[0] < SAME_M:
                sightings[i][k] = scan[good[1]]
                used.update(n for d, n in near if d < SAME_M)
            else:
                reasons[i][why_not(scan, place)] += 1
        others += sum(c["verdict"] == "accepted" and n not in used for n, c in enumerate(scan))
    return sightings, reasons, others


def longest_run(frames):
    best = run = 0
    for k in range(max(frames) + 1):
        run = run + 1 if k in frames else 0
        best = max(best, run)
    return best


def spread(sightings, poses):
    """Standard deviations of range, bearing and radius about the thing's mean place in the map, and the mean radius."""
    places = {k: to_map(poses[k], c["x"], c["y"]) for k, c in sightings.items()}
    mean = tuple(statistics.median(p[i] for p in places.values()) for i in (0, 1))
    ranges, bearings = [], []
    for k, c in sightings.items():
        x, y = to_base(poses[k], *mean)
        ranges.append(math.hypot(c["x"], c["y"]) - math.hypot(x, y))
        bearings.append(math.degrees(math.atan2(c["y"], c["x"]) - math.atan2(y, x)))
    radii = [c["radius"] for c in sightings.values()]
    return tuple(map(statistics.stdev, (ranges, bearings, radii))), statistics.mean(radii)


def print_things(scans, poses):
    sightings, reasons, others = find(scans, poses)
    print("| what | x, y [m] | thick [m] | scans | longest run | σ range [m] | σ bearing [°] | 2 × radius [m] | σ radius [m] | in the image | else |")
    print("|---" * 11 + "|")
    every = []
    for i, (name, x, y, thickness) in enumerate(SURVEY):
        seen = sightings[i]
        cells = ["", "", "", ""]
        if len(seen) >= 5:
            sigmas, radius = spread(seen, poses)
            cells = [f"{sigmas[0]:.3f}", f"{sigmas[1]:.3f}", f"{2 * radius:.2f}", f"{sigmas[2]:.3f}"]
            every.append(sigmas)
        looks = sum(bool(c["signature"]) for c in seen.values())
        print(f"| {name} | {x:.1f}, {y:.1f} | {thickness:.2f} | {len(seen)} | {longest_run(seen) if seen else 0} | " + " | ".join(cells) +
              f" | {looks if looks else ''} | {', '.join(f'{n} {why}' for why, n in reasons[i].most_common())} |")
    middle = [statistics.median(s[j] for s in every) for j in range(3)]
    print(f"\nmedian over things: range {middle[0]:.3f} m, bearing {middle[1]:.3f} deg, radius {middle[2]:.3f} m")
    print(f"own motion {math.hypot(*poses[-1][:2]):.2f} m, {math.degrees(poses[-1][2]):.2f} deg; "
          f"other accepted candidates {others / len(scans):.1f} per scan; not found: "
          + ", ".join(f"{n} {why}" for why, n in sum(reasons.values(), Counter()).most_common()))
    print_signatures(sightings)


def print_signatures(sightings):
    def known(i):
        return {k: c["signature"] for k, c in sightings[i].items() if c["signature"]}

    same, consecutive, different = [], [], []
    for i in range(len(SURVEY)):
        a = known(i)
        same += [distance(a[k], a[m]) for k in a for m in a if k < m]
        consecutive += [distance(a[k], a[k + 1]) for k in a if k + 1 in a]
        for j in range(i):
            b = known(j)
            different += [distance(a[k], b[m]) for k in a for m in b]
    print("\n| D between | pairs | median | 10 % to 90 % |\n|---|---|---|---|")
    for name, values in (("one thing in neighbouring scans", consecutive), ("one thing in any two scans", same),
                         ("different things", different)):
        if len(values) < 2:
            print(f"| {name} | {len(values)} | | |")
            continue
        tenths = statistics.quantiles(values, n=10)
        print(f"| {name} | {len(values)} | {statistics.median(values):.2f} | {tenths[0]:.2f} to {tenths[8]:.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--config", default="config/kitti_raw.yaml")
    parser.add_argument("--heights", action="append", help="low,high of the cut [m]; any number of times: a table over cuts")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as for waymark run")
    arguments = parser.parse_args()
    settings = dict(pair.split("=", 1) for pair in arguments.set)
    if not arguments.heights:
        scans = extract(arguments, settings)
        poses = own_motion(scans)
        totals = Counter(c["verdict"] for scan in scans for c in scan)
        print("candidates:", ", ".join(f"{count} {verdict.replace('_', ' ')}" for verdict, count in totals.most_common()), "\n")
        print_things(scans, poses)
        return
    print("| cut [m] | found per scan | in all scans | in 10 or more | others accepted per scan | σ radius, median [m] |")
    print("|---|---|---|---|---|---|")
    for heights in arguments.heights:
        scans = extract(arguments, {**settings, "source.lidar.height_m": f"[{heights}]"})
        poses = own_motion(scans)
        sightings, _, others = find(scans, poses)
        counts = [len(sightings[i]) for i in range(len(SURVEY))]
        sigmas = [spread(s, poses)[0][2] for s in sightings.values() if len(s) >= 5]
        radius = f"{statistics.median(sigmas):.3f}" if sigmas else ""
        print(f"| {heights.replace(',', ' to ')} | {sum(counts) / len(scans):.1f} | {sum(n == len(scans) for n in counts)} | "
              f"{sum(n >= 10 for n in counts)} | {others / len(scans):.1f} | {radius} |")


if __name__ == "__main__":
    main()
