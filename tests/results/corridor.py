#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error and claimed uncertainty of one run of config/corridor.yaml, along the corridor (x) and across it (y), and how straight its map is.

The wheels' noise before the first scan turns the whole map: so the end is given against the first scan's pose, too, and the path against a
straight line.

Example:
  tests/results/corridor.py --seed 3 --set maps.place.plugin=octomap_grid --out out/corridor
"""
import bisect
import math

from one_run import ROOT, heading_of, parser_of, print_scores, rows_of, run

SETTLED = 5.0  # s; before it error and σ are those of the start


def against_first(path):
    """How far the last scan lies beside the straight way of the first one [m]."""
    (_, x0, y0, *_), (_, x1, y1, *_) = path[0], path[-1]
    heading = heading_of(path[0])
    return abs((y1 - y0) * math.cos(heading) - (x1 - x0) * math.sin(heading))


def bend(path):
    """Largest distance of a scan from the line that fits all of them best [m]."""
    mean_x, mean_y = (sum(row[i] for row in path) / len(path) for i in (1, 2))
    slope = sum((row[1] - mean_x) * (row[2] - mean_y) for row in path) / sum((row[1] - mean_x) ** 2 for row in path)
    return max(abs(row[2] - mean_y - slope * (row[1] - mean_x)) for row in path)


def main():
    options = parser_of(__doc__).parse_args()
    run(options, ROOT / "config/corridor.yaml", options.out, f"source.seed={options.seed}", more=["--seed", str(options.seed)])
    truth, poses, covariances = (rows_of(options.out / name) for name in ("reference.txt", "trajectory.txt", "covariance.csv"))
    stamps, at = [row[0] for row in truth], [row[0] for row in poses]
    errors, variances, scores = [], [], {}
    for t, xx, _, _, yy, *_ in covariances:
        k, j = bisect.bisect_left(stamps, t), bisect.bisect_left(at, t)
        if t - stamps[0] < SETTLED or k >= len(stamps) or j >= len(at):
            continue
        share = (t - stamps[k - 1]) / (stamps[k] - stamps[k - 1])
        errors.append([poses[j][i] - (1 - share) * truth[k - 1][i] - share * truth[k][i] for i in (1, 2)])
        variances.append([xx, yy])
    for axis, name in enumerate(("along", "across")):
        squares = [error[axis] ** 2 / variance[axis] for error, variance in zip(errors, variances)]
        scores[f"{name}_m"], scores[f"{name}_sigma_m"] = abs(errors[-1][axis]), variances[-1][axis] ** 0.5
        scores[f"{name}_nees"] = sum(squares) / len(squares)
    path = rows_of(options.out / "path.txt")
    print_scores(scores | {"against_first_m": against_first(path), "bend_m": bend(path)})


if __name__ == "__main__":
    main()
