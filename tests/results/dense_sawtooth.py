#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a GPS does to a dense map: the experiment of `waymark paper --experiment sawtooth` on an occupancy grid, over seeds.

The robot of config/dense_gps.yaml, without compass and with a start that is known to a centimetre. Every GPS (rate, σ of its slowly varying
error) goes to the filter of the paper, to one with that error as states, and to one with the map's place on the Earth as states. A map is
right in itself if 95 % of its occupied cells lie within 0.15 m of a true wall after the best fit of the path to the truth.

Example:
  tests/results/dense_sawtooth.py --waymark build/release/bin/waymark --seeds 10
"""
import argparse
import csv
import json
import math
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

from faults import cell

CONFIG = "config/dense_gps.yaml"
START = ["initial.x_m=0", "initial.y_m=0", "initial.position_sigma_m=0.01", "initial.yaw_deg=0", "initial.yaw_sigma_deg=0.1",
         "sensors.compass.enabled=false", "source.gps.outages_s=[]", "health.max_lost_share=1"]
FILTERS = (
    ("The paper's filter", lambda error: ["georeference.enabled=false", "sensors.gps.offset_sigma_m=0", "sensors.gps.adaptive_noise=false"]),
    ("With the slowly varying error as states", lambda error: ["georeference.enabled=false", f"sensors.gps.offset_sigma_m={error}"]),
    ("With the map's place on the Earth as states", lambda error: ["sensors.gps.offset_sigma_m=0", "sensors.gps.adaptive_noise=false"]),
)
TOLERANCE_M = 0.15
RIGHT = 0.95


def occupied_cells(yaml):
    """Middles of the occupied cells of a map of map_server [m]."""
    keys = dict(line.split(": ", 1) for line in open(yaml).read().splitlines() if ": " in line)
    x0, y0, yaw = json.loads(keys["origin"])
    side = float(keys["resolution"])
    data = open(yaml.rsplit("/", 1)[0] + "/" + keys["image"].strip(), "rb").read()
    head = data.split(maxsplit=4)
    width, height = int(head[1]), int(head[2])
    pixels = data[-width * height:]
    cells = []
    for index, value in enumerate(pixels):
        if value == 0:
            u, v = (index % width + 0.5) * side, (height - index // width - 0.5) * side
            cells.append((x0 + math.cos(yaw) * u - math.sin(yaw) * v, y0 + math.sin(yaw) * u + math.cos(yaw) * v))
    return cells


def outlines(surfaces):
    """Rectangles of the true boxes: x_min, y_min, x_max, y_max [m]. A box is a line with half its width."""
    boxes = []
    for row in csv.DictReader(open(surfaces)):
        if row["kind"] == "box":
            x, y, x2, y2, half = (float(row[key]) for key in ("x_m", "y_m", "x2_m", "y2_m", "half_width_m"))
            along_x = abs(x2 - x) > abs(y2 - y)
            boxes.append((min(x, x2) - (0 if along_x else half), min(y, y2) - (half if along_x else 0),
                          max(x, x2) + (0 if along_x else half), max(y, y2) + (half if along_x else 0)))
    return boxes


def distance(x, y, box):
    """From a point to the outline of a rectangle [m]."""
    outside = math.hypot(max(box[0] - x, 0, x - box[2]), max(box[1] - y, 0, y - box[3]))
    return outside if outside > 0 else min(x - box[0], box[2] - x, y - box[1], box[3] - y)


def share_right(cells, boxes, pose):
    x0, y0, yaw = pose
    c, s = math.cos(yaw), math.sin(yaw)
    right = sum(any(distance(x0 + c * x - s * y, y0 + s * x + c * y, box) < TOLERANCE_M for box in boxes) for x, y in cells)
    return right / len(cells)


def evaluate(waymark, estimate, out, align):
    command = [waymark, "evaluate", "--json", "--estimate", estimate, "--reference", f"{out}/reference.txt", "--align", align]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)["trajectory"]


def run(arguments, boxes, overrides, seed):
    """One run: shares of right cells and RMS of the pose."""
    with tempfile.TemporaryDirectory() as out:
        command = [arguments.waymark, "run", CONFIG, "--out", out, "--seed", str(seed), "--quiet"]
        for override in [f"source.seed={seed}", *START, *overrides, *arguments.set]:
            command += ["--set", override]
        subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
        aligned = evaluate(arguments.waymark, f"{out}/path.txt", out, "se2")
        fit = aligned["reference_T_estimate"]
        cells = occupied_cells(f"{out}/campus.yaml")
        return {"itself": share_right(cells, boxes, (fit["x_m"], fit["y_m"], fit["yaw_rad"])),
                "rms": evaluate(arguments.waymark, f"{out}/trajectory.txt", out, "none")["ate_rms_m"], "path": aligned["ate_rms_m"]}


TABLES = (
    ("Map right in itself", lambda results: f"{100 * sum(one['itself'] >= RIGHT for one in results) / len(results):.0f} %"),
    ("Cells within 0.15 m of a wall, in itself [%], median (least)",
     lambda r: f"{100 * statistics.median(o['itself'] for o in r):.0f} ({100 * min(o['itself'] for o in r):.0f})"),
    ("Pose, RMS [m], median (largest)", lambda r: f"{statistics.median(o['rms'] for o in r):.2f} ({max(o['rms'] for o in r):.2f})"),
)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--seeds", type=int, default=10, help="seeds 1..N (default 10)")
    parser.add_argument("--rates", default="0.2,1,5", help="of the GPS [Hz], comma-separated")
    parser.add_argument("--errors", default="0,0.5,1,2", help="σ of its slowly varying error [m], comma-separated")
    parser.add_argument("--filters", default="1,2,3", help="of the three, comma-separated")
    parser.add_argument("--particles", default="25", help="numbers, comma-separated; one after the other in each cell")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], help="override of the YAML")
    arguments = parser.parse_args()
    rates = arguments.rates.split(",")
    errors = arguments.errors.split(",")
    with tempfile.TemporaryDirectory() as world:
        subprocess.run([arguments.waymark, "run", CONFIG, "--until", "1", "--out", world + "/out", "--quiet", "--allow-outside",
                        "--set", f"source.surfaces_file={world}/surfaces.csv"], check=True, stderr=subprocess.DEVNULL)
        boxes = outlines(world + "/surfaces.csv")
    with ThreadPoolExecutor(arguments.jobs) as pool:
        def seeds(overrides):
            return list(pool.map(lambda seed: run(arguments, boxes, overrides, seed), range(1, arguments.seeds + 1)))

        def both(overrides):
            return [seeds([f"filter.particles={particles}", *overrides]) for particles in arguments.particles.split(",")]

        without = both(["sensors.gps.enabled=false"])
        print("Without GPS: " + "; ".join(f"{title}: {', '.join(text(one) for one in without)}" for title, text in TABLES))
        print(f"path of the best particle, aligned, RMS [m]: {', '.join(cell([o['path'] for o in one]) for one in without)}", flush=True)
        for title, overrides in (FILTERS[int(number) - 1] for number in arguments.filters.split(",")):
            results = {(rate, error): both([f"source.gps.rate_hz={rate}", f"source.gps.correlated_sigma_m={error}", *overrides(error)])
                       for rate in rates for error in errors}
            print(f"\n## {title}")
            for name, text in TABLES:
                print(f"\n{name}:\n\n| GPS | " + " | ".join(f"{error} m" for error in errors) + " |\n|---|" + "---|" * len(errors))
                for rate in rates:
                    print(f"| {rate} Hz | " + " | ".join(", ".join(text(one) for one in results[rate, error]) for error in errors) + " |", flush=True)


if __name__ == "__main__":
    main()
