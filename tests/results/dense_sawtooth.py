#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a GPS does to a dense map: the experiment of `waymark paper --experiment sawtooth` on an occupancy grid.

The robot of config/dense_gps.yaml, without compass and with a start that is known to a centimetre. A GPS (rate, σ of its slowly varying
error) goes to the filter of the paper, to one with that error as states, or to one with the map's place on the Earth as states. A map is
right in itself if 95 % of its occupied cells lie within 0.15 m of a true wall after the best fit of the path to the truth.

Examples:
  tests/results/dense_sawtooth.py --filter paper --rate 1 --error 0.5 --seed 3 --out out/sawtooth
  tests/results/dense_sawtooth.py --filter none --out out/sawtooth
"""
import csv
import json
import math

from one_run import ROOT, evaluate, parser_of, print_scores, run

CONFIG = ROOT / "config/dense_gps.yaml"
START = ["initial.x_m=0", "initial.y_m=0", "initial.position_sigma_m=0.01", "initial.yaw_deg=0", "initial.yaw_sigma_deg=0.1",
         "sensors.compass.enabled=false", "source.gps.outages_s=[]", "health.max_lost_share=1"]
FILTERS = {
    "none": lambda error: ["sensors.gps.enabled=false"],
    "paper": lambda error: ["georeference.enabled=false", "sensors.gps.offset_sigma_m=0", "sensors.gps.adaptive_noise=false"],
    "error_as_states": lambda error: ["georeference.enabled=false", f"sensors.gps.offset_sigma_m={error}"],
    "place_as_states": lambda error: ["sensors.gps.offset_sigma_m=0", "sensors.gps.adaptive_noise=false"],
}
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


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--filter", choices=FILTERS, default="paper")
    parser.add_argument("--rate", type=float, default=1, help="of the GPS [Hz]")
    parser.add_argument("--error", type=float, default=0.5, help="σ of its slowly varying error [m]")
    options = parser.parse_args()
    surfaces = options.out.resolve() / "surfaces.csv"
    of_gps = [] if options.filter == "none" else [f"source.gps.rate_hz={options.rate}", f"source.gps.correlated_sigma_m={options.error}"]
    run(options, CONFIG, options.out / "run", f"source.seed={options.seed}", f"source.surfaces_file={surfaces}", *START, *of_gps,
        *FILTERS[options.filter](options.error), more=["--seed", str(options.seed), "--allow-outside"])
    of_run = ["--reference", options.out / "run/reference.txt", "--align"]
    aligned = evaluate(options, "--estimate", options.out / "run/path.txt", *of_run, "se2")["trajectory"]
    online = evaluate(options, "--estimate", options.out / "run/trajectory.txt", *of_run, "none")["trajectory"]
    fit = aligned["reference_T_estimate"]
    share = share_right(occupied_cells(f"{options.out}/run/campus.yaml"), outlines(surfaces), (fit["x_m"], fit["y_m"], fit["yaw_rad"]))
    print_scores({"is_right": share >= RIGHT, "right_percent": 100 * share, "rms_m": online["ate_rms_m"], "path_rms_m": aligned["ate_rms_m"]})


if __name__ == "__main__":
    main()
