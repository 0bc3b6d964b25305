#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores a run of config/utias_mrclam.yaml by its landmarks alone, on data sets without motion capture of the robot: the map
is first laid on the survey by the motion that puts most landmarks within 0.5 m of a surveyed one.

Example:
  tests/results/utias.py --data-set 9 --robot 3 --seed 2 --set variables.barcodes=known --out out/utias_9
"""
import os

from one_run import ROOT, evaluate, parser_of, print_scores, run


def read_points(path, x, y, separator=None):
    with open(path) as file:
        rows = [line.split(separator) for line in file if not line.startswith(("#", "map,"))]
    return [complex(float(row[x]), float(row[y])) for row in rows if len(row) > max(x, y)]


def lay_on(points, survey):
    """The points, moved by the best motion among those that lay a pair of them on a pair of the survey."""
    def inliers(moved):
        distances = [min(abs(p - q) for q in survey) for p in moved]
        return sum(d < 0.5 for d in distances), -sum(d for d in distances if d < 0.5)

    best, best_moved = (-1, 0.0), points
    for i, a in enumerate(points):
        for b in points[:i]:
            for c in survey:
                for d in survey:
                    if abs(a - b) < 3.0 or abs(abs(a - b) - abs(c - d)) > 0.3:
                        continue
                    turn = (d - c) / (b - a)
                    turn /= abs(turn)
                    moved = [0.5 * (c + d) + turn * (p - 0.5 * (a + b)) for p in points]
                    score = inliers(moved)
                    if score > best:
                        best, best_moved = score, moved
    return best_moved


def lay_landmarks_on_survey(landmarks, survey):
    with open(landmarks) as file:
        rows = [line.rstrip("\n").split(",") for line in file]
    points = lay_on([complex(float(row[2]), float(row[3])) for row in rows[1:]], read_points(survey, 1, 2))
    for row, point in zip(rows[1:], points):
        row[2:4] = f"{point.real:.6f}", f"{point.imag:.6f}"
    with open(landmarks, "w") as file:
        file.writelines(",".join(row) + "\n" for row in rows)


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--data-set", type=int, default=9, help="9 or 1")
    parser.add_argument("--robot", type=int, default=1, help="1 to 5")
    options = parser.parse_args()
    data = os.path.join(os.environ["WAYMARK_DATA"], f"utias_mrclam_{options.data_set}")
    landmarks, survey = options.out / "landmarks.csv", f"{data}/Landmark_Groundtruth.dat"
    run(options, ROOT / "config/utias_mrclam.yaml", options.out, f"variables.log={data}", f"variables.robot={options.robot}",
        "sinks.plot.enabled=false", more=["--seed", str(options.seed)])
    lay_landmarks_on_survey(landmarks, survey)
    scored = evaluate(options, "--landmarks", landmarks, "--survey", survey, "--survey-columns", "name=0,x=1,y=2")["landmarks"]
    print_scores({"found": scored["own_alignment_matched"], "duplicates": scored["duplicates"], "others": scored["others"],
                  "rms_m": scored["landmark_rms_own_alignment_m"]})


if __name__ == "__main__":
    main()
