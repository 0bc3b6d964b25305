#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores the velocity of a run (poses.csv of the sink pose_csv) against a reference with speed and yaw rate.

The reference is delimited text with column names, plain or gzip. Errors are those of the run's rows, interpolated to
the reference's rows within the time that both have; the way is the integral of the speed forwards over that time.
The reference's speed is scored twice: as its column says, and as its positions do.
"""
import argparse
import bisect
import csv
import gzip
import math
import sys


def read_table(path, names):
    """The named columns as lists of numbers."""
    with open(path, "rb") as file:
        is_gzip = file.read(2) == b"\x1f\x8b"
    with (gzip.open if is_gzip else open)(path, "rt", newline="") as file:
        rows = csv.DictReader(file)
        missing = [name for name in names if name not in (rows.fieldnames or [])]
        if missing:
            sys.exit(f"{path}: no column {', '.join(missing)}; there are {', '.join(rows.fieldnames or [])}")
        columns = [[] for _ in names]
        for row in rows:
            for column, name in zip(columns, names):
                try:
                    column.append(float(row[name]))
                except (TypeError, ValueError):
                    sys.exit(f"{path}:{rows.line_num}: {name}: {row[name]!r} is no number")
    if len(columns[0]) < 2:
        sys.exit(f"{path}: fewer than two rows")
    return columns


def interpolate(times, values, t):
    i = min(max(bisect.bisect_left(times, t), 1), len(times) - 1)
    step = times[i] - times[i - 1]
    share = 0.0 if step <= 0.0 else (t - times[i - 1]) / step
    return values[i - 1] + share * (values[i] - values[i - 1])


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def describe(name, errors, unit, scale=1.0):
    scaled = [scale * e for e in errors]
    mean = sum(scaled) / len(scaled)
    print(f"  {name:<26} rms {rms(scaled):.4f} {unit}   mean {mean:+.4f}   max {max(abs(e) for e in scaled):.4f}")


def integral(times, values):
    return sum(0.5 * (values[i] + values[i - 1]) * (times[i] - times[i - 1]) for i in range(1, len(times)))


def end_error(run, reference, first, last):
    """Difference of the two ends, after the reference's pose at the begin was put on the run's."""
    ends = []
    for t_s, x, y, yaw in (run, reference):
        x0, y0, yaw0 = (interpolate(t_s, values, first) for values in (x, y, yaw))
        dx, dy = interpolate(t_s, x, last) - x0, interpolate(t_s, y, last) - y0
        c, s = math.cos(yaw0), math.sin(yaw0)
        ends.append((c * dx + s * dy, c * dy - s * dx))
    return math.dist(*ends)


def speed_by_positions(t_s, x, y, yaw, i, window_s):
    """Along the heading, from two positions about `window_s` apart; nothing at the ends."""
    a, b = bisect.bisect_left(t_s, t_s[i] - 0.5 * window_s), bisect.bisect_right(t_s, t_s[i] + 0.5 * window_s) - 1
    if a == 0 or b == len(t_s) - 1 or t_s[b] - t_s[a] < 0.5 * window_s:
        return None
    way = math.cos(yaw[i]) * (x[b] - x[a]) + math.sin(yaw[i]) * (y[b] - y[a])
    return way / (t_s[b] - t_s[a])


def unwrapped(angles):
    result = angles[:1]
    for angle in angles[1:]:
        result.append(result[-1] + math.remainder(angle - result[-1], 2.0 * math.pi))
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", help="output folder of the run")
    parser.add_argument("reference", help="table with the truth")
    parser.add_argument("--columns", default="t_s,vx_mps,yaw_rate_radps,x_m,y_m,yaw_rad",
                        help="time, speed, yaw rate, and x, y, yaw or qw, qz of the reference (default: %(default)s)")
    parser.add_argument("--settle", type=float, default=1.0, metavar="S",
                        help="not scored at the begin [s] (default: %(default)s)")
    parser.add_argument("--window", type=float, default=0.5, metavar="S",
                        help="time between two positions that give a speed [s] (default: %(default)s)")
    arguments = parser.parse_args()

    names = arguments.columns.split(",")
    if len(names) not in (6, 7):
        sys.exit(f"--columns: {arguments.columns}: six or seven names are expected")
    t_s, speed, rate, x, y, *heading = read_table(arguments.reference, names)
    yaw = heading[0] if len(heading) == 1 else [2.0 * math.atan2(z, w) for w, z in zip(*heading)]
    yaw = unwrapped(yaw)
    run_t, run_v, run_lateral, run_w, run_x, run_y, run_yaw = read_table(
        f"{arguments.run}/poses.csv", ["t_s", "v_x_mps", "v_y_mps", "w_z_radps", "x_m", "y_m", "yaw_rad"])
    run_yaw = unwrapped(run_yaw)

    first, last = max(t_s[0], run_t[0]) + arguments.settle, min(t_s[-1], run_t[-1])
    scored = [i for i, t in enumerate(t_s) if first <= t <= last]
    if len(scored) < 2:
        sys.exit(f"{arguments.run}: no time in common with {arguments.reference}")
    middle = 0.5 * (first + last)
    v_error = [interpolate(run_t, run_v, t_s[i]) - speed[i] for i in scored]
    w_error = [interpolate(run_t, run_w, t_s[i]) - rate[i] for i in scored]
    second = [e for i, e in zip(scored, w_error) if t_s[i] >= middle]
    lateral = [interpolate(run_t, run_lateral, t_s[i]) for i in scored]

    times = [t_s[i] for i in scored]
    way = integral(times, [speed[i] for i in scored])
    run_way = integral(times, [interpolate(run_t, run_v, t) for t in times])
    print(f"{arguments.run}: {len(scored)} rows, {first:.1f} to {last:.1f} s")
    describe("v_x", v_error, "m/s")
    by_positions = [(i, speed_by_positions(t_s, x, y, yaw, i, arguments.window)) for i in scored]
    describe("v_x, by positions", [interpolate(run_t, run_v, t_s[i]) - s for i, s in by_positions if s is not None], "m/s")
    describe("yaw rate", w_error, "deg/s", math.degrees(1.0))
    describe("yaw rate, second half", second, "deg/s", math.degrees(1.0))
    print(f"  {'v_y of the run':<26} rms {rms(lateral):.4f} m/s")
    print(f"  {'way':<26} {run_way:.1f} of {way:.1f} m: {100.0 * (run_way / way - 1.0):+.3f} %")
    end = end_error((run_t, run_x, run_y, run_yaw), (t_s, x, y, yaw), first, last)
    turn = math.degrees((interpolate(run_t, run_yaw, last) - interpolate(run_t, run_yaw, first)) -
                        (interpolate(t_s, yaw, last) - interpolate(t_s, yaw, first)))
    print(f"  {'end':<26} {end:.2f} m: {100.0 * end / way:.3f} % of the way; yaw {turn:+.2f} deg")


if __name__ == "__main__":
    main()
