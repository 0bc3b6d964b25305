#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A robot that is carried to another place of a loaded map while it does not look: how soon is it found?

A log of CARMEN is mapped once, and run once in its own map without a cut: the reference. For each run 60 s of the log
are removed at a random time, and the odometry begins anew behind them. A run recovers if its pose is within 0.5 m and
5 degrees of the reference from some time on, for at least 20 s; what counts as found is the begin of that.

Example:
  tests/results/kidnapped.py --waymark build/release/bin/waymark --runs 50
  tests/results/kidnapped.py --waymark build/release/bin/waymark --runs 10 --config config/carmen_fr079.yaml --log carmen_fr079/fr079.clf.gz
"""
import argparse
import bisect
import gzip
import json
import math
import os
import random
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
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
    rows = []
    for line in (folder / "trajectory.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        t, x, y, _, _, _, qz, qw = (float(v) for v in line.split())
        rows.append((t, x, y, 2.0 * math.atan2(qz, qw)))
    return rows


def run(waymark, config, out, *overrides):
    command = [waymark, "run", str(config), "--out", str(out), "--quiet"]
    for override in overrides:
        command += ["--set", override]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 4):
        sys.exit(f"{' '.join(command)}\n{done.stderr}")


def times_ok(folder, begin, end):
    """Stretches in which the health is ok."""
    changes = json.loads((folder / "diagnostics.json").read_text())["health"]["changes"]
    state, since, stretches = "ok", begin, []
    for change in changes:
        if change["of"] != "all":
            continue
        if state == "ok":
            stretches.append((since, change["t_s"]))
        state, since = change["state"], change["t_s"]
    if state == "ok":
        stretches.append((since, end))
    return stretches


def judge(folder, reference, cut, shift):
    """Time until found [s] or None, longest time ok while wrong [s]."""
    stamps = [row[0] for row in reference]
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
    for first, last in times_ok(folder, begin, wrong[-1][0]):
        since = None
        for t, is_wrong in wrong:
            since = (since or t) if is_wrong and first <= t <= last else None
            if since is not None:
                longest = max(longest, t - since)
    return found, longest


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", required=True)
    parser.add_argument("--config", type=Path, default=ROOT / "config/carmen_intel.yaml")
    parser.add_argument("--log", default="carmen_intel/intel.clf.gz", help="below WAYMARK_DATA")
    parser.add_argument("--map", default="building", help="its name in the configuration")
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--first", type=int, default=1, help="seed of the first run")
    parser.add_argument("--close", action="store_true", help="stamps go on at once, as if there was no gap")
    parser.add_argument("--set", action="append", default=[], dest="overrides")
    options = parser.parse_args()
    lines = read_log(Path(os.environ["WAYMARK_DATA"]) / options.log)
    stamps = sorted(stamp(fields) for fields in lines if is_measurement(fields))
    shift = CUT_S - 0.2 if options.close else 0.0
    jumps = ["source.max_bad_records=2"] if options.close else []  # the step of the odometry is none
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        run(options.waymark, options.config, folder / "map", *options.overrides)
        localize = [f"maps.{options.map}.load={folder}/map/{options.map}.yaml", f"maps.{options.map}.mode=localize"]
        run(options.waymark, options.config, folder / "uncut", *localize, *options.overrides)
        reference = poses(folder / "uncut")
        times, oks = [], []
        for seed in range(options.first, options.first + options.runs):
            cut = random.Random(seed).uniform(stamps[0] + 60.0, stamps[-1] - CUT_S - 120.0)
            write_cut(lines, cut, options.close, folder / "cut.clf")
            run(options.waymark, options.config, folder / "run", f"source.file={folder}/cut.clf", f"filter.seed={seed}",
                *localize, *jumps, *options.overrides)
            found, ok = judge(folder / "run", reference, cut, shift)
            times.append(found)
            oks.append(ok)
            text = "not found" if found is None else f"found after {found:6.1f} s"
            print(f"cut at {cut - stamps[0]:7.1f} s: {text}, ok while wrong by more than 1 m for {ok:.1f} s", flush=True)
    known = [t for t in times if t is not None]
    print(f"found: {len(known)} of {options.runs}")
    if known:
        print(f"time to find [s]: {min(known):.1f} / {statistics.median(known):.1f} / {max(known):.1f}")
    print(f"longest ok while wrong [s]: {min(oks):.1f} / {statistics.median(oks):.1f} / {max(oks):.1f}; "
          f"above 2 s in {sum(ok > 2.0 for ok in oks)}")


if __name__ == "__main__":
    main()
