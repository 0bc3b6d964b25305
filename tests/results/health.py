#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Errors of one run of a robot with truth, and whether its health can be believed: the share of the time with the position outside
the 3σ ellipse of its own covariance, in each state of the health, and whether a sensor was reported.

Example:
  tests/results/health.py config/faults.yaml --seed 3 --set source.seed=3 --set source.gps.outages_s=[100,220] --reports gps --out out/health
"""
import bisect
import json
import math

from one_run import ROOT, evaluate, parser_of, print_scores, rows_of, run, states_of

STATES = ("ok", "degraded", "lost")
STEP = 0.1  # s between two samples


def samples(out, changes):
    """(state of the health, whether the position is outside) at every STEP."""
    truth, poses, covariances = (rows_of(out / name) for name in ("reference.txt", "trajectory.txt", "covariance.csv"))
    times, states = states_of(changes)
    stamps, at = [row[0] for row in truth], [row[0] for row in covariances]
    due = -math.inf
    for t, x, y, *_ in poses:
        k, c = bisect.bisect_left(stamps, t), bisect.bisect_right(at, t) - 1
        if t < due or not 0 < k < len(stamps) or c < 0 or stamps[k] - stamps[k - 1] > 1.0:
            continue
        due = t + STEP
        share = (t - stamps[k - 1]) / (stamps[k] - stamps[k - 1])
        ex, ey = (value - (1 - share) * truth[k - 1][i] - share * truth[k][i] for i, value in ((1, x), (2, y)))
        xx, xy, _, yy = covariances[c][1:5]
        determinant = xx * yy - xy * xy
        is_outside = determinant <= 0.0 or yy * ex * ex - 2 * xy * ex * ey + xx * ey * ey > 9.0 * determinant
        yield states[bisect.bisect_right(times, t) - 1], is_outside


def percent(part, whole):
    return 100.0 * len(part) / len(whole) if whole else None


def main():
    parser = parser_of(__doc__)
    parser.add_argument("config", help="relative to the repository")
    parser.add_argument("--reports", metavar="SENSORS", help="comma-separated; the score `reported` is 1 if the health of one of them was not ok at some time")
    options = parser.parse_args()
    run(options, ROOT / options.config, options.out, more=["--seed", str(options.seed)])
    changes = json.loads((options.out / "diagnostics.json").read_text())["health"]["changes"]
    scored = evaluate(options, options.out)
    found = list(samples(options.out, changes))
    outside = [state for state, is_outside in found if is_outside]
    of_sensors = [change for change in changes if change["of"] != "all" and change["state"] != "ok"]
    named = {change["of"] for change in of_sensors}
    print("; ".join(sorted({f"{change['of']} {change['state']}: {change['reason']}" for change in of_sensors})))
    yaw = scored["trajectory"]["yaw_rms_rad"]  # none if the reference has no yaw
    print_scores({
        "rms_m": scored["trajectory"]["ate_rms_m"], "max_m": scored["trajectory"]["ate_max_m"],
        "yaw_rms_deg": None if yaw is None else math.degrees(yaw), "nees": scored["consistency"]["nees_mean"],
        "outside_percent": percent(outside, found),
        "time_percent": {state: percent([s for s, _ in found if s == state], found) for state in STATES},
        "outside_while_percent": {state: percent([s for s in outside if s == state], [s for s, _ in found if s == state]) for state in STATES},
        "of_outside_percent": {state: percent([s for s in outside if s == state], outside) for state in STATES},
        "reported": bool(named & set(options.reports.split(","))) if options.reports else None, "sensors_named": len(named)})


if __name__ == "__main__":
    main()
