#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A robot that is carried to another place of a loaded map while it does not look: how soon is it found?

A log of CARMEN is mapped once, and run once in its own map without a cut: the reference. Then 60 s of the log are removed at
a random time, and the odometry begins anew behind them. The run recovers if its pose is within 0.5 m and 5 degrees of the
reference from some time on, for at least 20 s; what counts as found is the begin of that.

Examples:
  tests/results/kidnapped.py --seed 3 --out out/kidnapped
  tests/results/kidnapped.py --config config/carmen_fr079.yaml --log carmen_fr079/fr079.clf.gz --out out/kidnapped
"""
import bisect
import gzip
import json
import math
import os
import random

from one_run import ROOT, heading_of, parser_of, print_scores, rows_of, run, states_of

CUT_S = 60.0
FOUND_M, FOUND_DEG = 0.5, 5.0
HELD_S = 20.0
WRONG_M = 1.0


def compose(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    return (a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], math.remainder(a[2] + b[2], 2 * math.pi))


def inverse(p):
    c, s = math.cos(p[2]), math.sin(p[2])
    return (-c * p[0] - s * p[1], s * p[0] - c * p[1], -p[2])


def read_log(path):
    with gzip.open(path, "rt") as log:
        return [line.split() for line in log]


def is_measurement(fields):
    return bool(fields) and fields[0] in ("ODOM", "FLASER")


def stamp(fields):
    return float(fields[-3])


def write_cut(lines, cut, closes, path):
    """Without the lines of CUT_S seconds from `cut` on; if `closes`, later stamps follow on at once."""
    begin_anew = None
    with open(path, "w") as out:
        for fields in lines:
            if not is_measurement(fields):
                out.write(" ".join(fields) + "\n")
                continue
            t = stamp(fields)
            if cut <= t < cut + CUT_S:
                continue
            if t >= cut + CUT_S:
                fields = list(fields)
                for at in [1] if fields[0] == "ODOM" else [len(fields) - 9, len(fields) - 6]:
                    pose = tuple(float(x) for x in fields[at:at + 3])
                    begin_anew = begin_anew or inverse(pose)
                    fields[at:at + 3] = [f"{x:.6f}" for x in compose(begin_anew, pose)]
                if closes:
                    fields[-3] = f"{t - CUT_S + 0.2:.6f}"
            out.write(" ".join(fields) + "\n")


def poses(folder):
    return [(*row[:3], heading_of(row)) for row in rows_of(folder / "trajectory.txt")]


def times_ok(changes, end):
    """Stretches in which the health is ok."""
    times, states = states_of(changes)
    return [(begin, after) for begin, after, state in zip(times, [*times[1:], end], states) if state == "ok"]


def judge(folder, reference, cut, shift):
    """Time until found [s] or None, longest time ok while wrong [s]."""
    stamps = [row[0] for row in reference]
    changes = json.loads((folder / "diagnostics.json").read_text())["health"]["changes"]
    begin = cut + (CUT_S - shift)
    wrong, errors = [], []
    for t, x, y, yaw in poses(folder):
        if t < begin:
            continue
        k = min(bisect.bisect_left(stamps, t + shift), len(stamps) - 1)
        if abs(stamps[k] - t - shift) > 0.05:
            continue
        _, rx, ry, ryaw = reference[k]
        off = math.hypot(x - rx, y - ry)
        turn = abs(math.degrees(math.remainder(yaw - ryaw, 2 * math.pi)))
        errors.append((t, off < FOUND_M and turn < FOUND_DEG))
        wrong.append((t, off > WRONG_M))
    found = None
    since = None
    for t, is_right in errors:
        since = (since or t) if is_right else None
        if since is not None and t - since >= HELD_S:
            found = since - begin
            break
    longest = 0.0
    for first, last in times_ok(changes, wrong[-1][0]):
        since = None
        for t, is_wrong in wrong:
            since = (since or t) if is_wrong and first <= t <= last else None
            if since is not None:
                longest = max(longest, t - since)
    return found, longest


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--config", default="config/carmen_intel.yaml", help="relative to the repository")
    parser.add_argument("--log", default="carmen_intel/intel.clf.gz", help="below WAYMARK_DATA")
    parser.add_argument("--map", default="building", help="its name in the configuration")
    parser.add_argument("--close", action="store_true", help="stamps go on at once, as if there was no gap")
    options = parser.parse_args()
    config, out = ROOT / options.config, options.out.resolve()
    lines = read_log(os.path.join(os.environ["WAYMARK_DATA"], options.log))
    stamps = sorted(stamp(fields) for fields in lines if is_measurement(fields))
    shift = CUT_S - 0.2 if options.close else 0.0
    jumps = ["source.max_bad_records=2"] if options.close else []  # the step of the odometry is none
    run(options, config, out / "map")
    localize = [f"maps.{options.map}.load={out}/map/{options.map}.yaml", f"maps.{options.map}.mode=localize"]
    run(options, config, out / "uncut", *localize)
    cut = random.Random(options.seed).uniform(stamps[0] + 60.0, stamps[-1] - CUT_S - 120.0)
    write_cut(lines, cut, options.close, out / "cut.clf")
    run(options, config, out / "run", f"source.file={out}/cut.clf", f"filter.seed={options.seed}", *localize, *jumps)
    found, ok = judge(out / "run", poses(out / "uncut"), cut, shift)
    print_scores({"cut_at_s": cut - stamps[0], "found": found is not None, "time_to_find_s": found, "ok_while_wrong_s": ok})


if __name__ == "__main__":
    main()
