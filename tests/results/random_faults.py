#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Random faults in the log of a simulated robot, one or two at a time, and how the filter copes with them.

The robot of config/faults.yaml drives for 120 s, in one of ten worlds. Its log is recorded, and replayed with faults between
20 s and 80 s: clocks, loss, duplicates, reordering, NaN, jumps, dead and frozen sensors. A run

  diverges      if the position is more than 2 m and 5 sigma from the truth for 2 s,
  is reported   if an event, or a health that is not ok, comes before the end of the first such 2 s,
  locks out     if faults that are over leave the robot more than 3 m from the truth, or without a pose, in the log's last second,
  is lost       if that is so at the end, whatever the faults, with exit code 0 and a health that is not "lost".

The scores are under `all`, and under the name of each fault that the run has.

Example:
  tests/results/random_faults.py --seed 18 --out out/run_18
"""
import bisect
import json
import math
import random
import shutil
import subprocess

from one_run import ROOT, parser_of, print_scores, rows_of, run, states_of

SECOND = 10**9
DAY = 86400 * SECOND
LENGTH_S, FIRST_S, LAST_S = 120, 20, 80
WORLDS = 10
SENSORS = ("wheels", "imu", "gps", "compass")
NUMBERS = {"wheels": (2, 3), "imu": (2, 3, 4, 5, 6, 7), "gps": (2, 3), "compass": (2,)}  # columns of its readings
STAMP, ARRIVAL = 0, 1


class Log:
    """The rows of each sensor: stamp and arrival [ns], then texts. `sets` is when the clock of all was set, and by how much."""

    def __init__(self, folder):
        self.heads, self.rows, self.sets = {}, {}, []
        for sensor in SENSORS:
            lines = (folder / f"{sensor}.csv").read_text().splitlines()
            self.heads[sensor] = lines[0]
            self.rows[sensor] = [[int(stamp), int(arrival), *rest]
                                 for stamp, arrival, *rest in (line.split(",") for line in lines[1:])]

    def write(self, folder):
        for sensor, rows in self.rows.items():
            rows.sort(key=lambda row: row[ARRIVAL])
            text = "\n".join(",".join(map(str, row)) for row in rows)
            (folder / f"{sensor}.csv").write_text(f"{self.heads[sensor]}\n{text}\n")

    def end(self):
        """The true time of the last arrival [s], wrong clocks aside."""
        times = (self.true_time(row[ARRIVAL] / SECOND) for rows in self.rows.values() for row in rows)
        return max(time for time in times if time <= LENGTH_S)

    def true_time(self, stamp):
        """The time of the truth [s] that belongs to a stamp [s]."""
        for begin, by in reversed(self.sets):
            if stamp >= begin + by:
                return stamp - by
        return stamp


class Span:
    """When a fault is at work [ns], and whether it ends before the log does."""

    def __init__(self, dice, for_good=0.15):
        self.begin = int(dice.uniform(FIRST_S, LAST_S - 1) * SECOND)
        self.ends = dice.random() >= for_good
        length = int(min(dice.expovariate(1 / 15), 40) * SECOND)
        self.end = min(self.begin + length, LAST_S * SECOND) if self.ends else 10**18

    def of(self, rows):
        return [row for row in rows if self.begin <= row[ARRIVAL] < self.end]

    def __str__(self):
        return f"{self.begin / SECOND:.1f} s to {self.end / SECOND:.1f} s" if self.ends else f"from {self.begin / SECOND:.1f} s on"


def some(dice):
    """One sensor, or now and then all."""
    return SENSORS if dice.random() < 0.25 else (dice.choice(SENSORS),)


def clock_of_all_set(log, dice):
    begin = int(dice.uniform(FIRST_S, LAST_S) * SECOND)
    by = dice.choice((10 * SECOND, 70 * SECOND, 1000 * SECOND, 5000 * SECOND, DAY, 8 * DAY, 365 * DAY, 18000 * DAY))
    for rows in log.rows.values():
        for row in rows:
            if row[ARRIVAL] >= begin:
                row[STAMP] += by
                row[ARRIVAL] += by
    log.sets.append((begin / SECOND, by / SECOND))
    return f"all clocks set forward by {by / SECOND:g} s at {begin / SECOND:.1f} s", True


def clock_of_one_wrong(log, dice):
    sensor, span = dice.choice(SENSORS), Span(dice)
    by = int(dice.choice((-1, 1)) * 10 ** dice.uniform(-1.5, 5) * SECOND)
    for row in span.of(log.rows[sensor]):
        row[STAMP] += by
    return f"clock of {sensor} wrong by {by / SECOND:.3g} s, {span}", span.ends


def single_stamps_wrong(log, dice):
    sensor, span = dice.choice(SENSORS), Span(dice)
    share = dice.choice((0.01, 0.1, 0.5))
    for row in span.of(log.rows[sensor]):
        if dice.random() < share:
            by = int(dice.choice((-1, 1)) * 10 ** dice.uniform(-1, 9.5) * SECOND)
            row[STAMP] += by
    return f"{100 * share:g} % of the stamps of {sensor} wrong, {span}", span.ends


def stamps_stuck(log, dice):
    sensor, span, zero = dice.choice(SENSORS), Span(dice), dice.random() < 0.5
    rows = span.of(log.rows[sensor])
    for row in rows:
        row[STAMP] = 0 if zero else rows[0][STAMP]
    return f"stamps of {sensor} {'zero' if zero else 'stuck'}, {span}", span.ends


def loss(log, dice):
    sensors, span, share = some(dice), Span(dice), dice.uniform(0.05, 0.95)
    for sensor in sensors:
        hit = {id(row) for row in span.of(log.rows[sensor]) if dice.random() < share}
        log.rows[sensor] = [row for row in log.rows[sensor] if id(row) not in hit]
    return f"{100 * share:.0f} % of {' '.join(sensors)} lost, {span}", span.ends


def silence(log, dice):
    sensors, span = some(dice), Span(dice)
    for sensor in sensors:
        hit = {id(row) for row in span.of(log.rows[sensor])}
        log.rows[sensor] = [row for row in log.rows[sensor] if id(row) not in hit]
    return f"{' '.join(sensors)} dead, {span}", span.ends


def duplicates(log, dice):
    sensors, span, share = some(dice), Span(dice), dice.uniform(0.05, 1)
    for sensor in sensors:
        for row in span.of(log.rows[sensor]):
            if dice.random() < share:
                again = list(row)
                again[ARRIVAL] += int(dice.choice((0, 0.01, 1)) * SECOND)
                log.rows[sensor].append(again)
    return f"{100 * share:.0f} % of {' '.join(sensors)} twice, {span}", span.ends


def reordering(log, dice):
    sensors, span, longest = some(dice), Span(dice), 10 ** dice.uniform(-2, 0.7)
    for sensor in sensors:
        for row in span.of(log.rows[sensor]):
            row[ARRIVAL] += int(dice.uniform(0, longest) * SECOND)
    return f"{' '.join(sensors)} up to {longest:.2g} s late, {span}", span.ends


def not_a_number(log, dice):
    sensors, span, share = some(dice), Span(dice), dice.uniform(0.05, 1)
    for sensor in sensors:
        for row in span.of(log.rows[sensor]):
            if dice.random() < share:
                for column in NUMBERS[sensor]:
                    row[column] = ""
    return f"{100 * share:.0f} % of {' '.join(sensors)} NaN, {span}", span.ends


def jump(log, dice):
    sensor, span = dice.choice(SENSORS), Span(dice, for_good=0)
    size = {"wheels": 3.0, "imu": 1.0, "gps": 10 ** dice.uniform(0, 3), "compass": 1.0}[sensor]
    by = [dice.uniform(-size, size) for _ in NUMBERS[sensor]]
    for row in span.of(log.rows[sensor]):
        for column, step in zip(NUMBERS[sensor], by):
            if row[column]:
                row[column] = repr(float(row[column]) + step)
    return f"{sensor} off by {', '.join(f'{step:.2g}' for step in by)}, {span}", span.ends


def outliers(log, dice):
    sensor, span, share = dice.choice(SENSORS), Span(dice), dice.uniform(0.01, 0.5)
    size = {"wheels": 10.0, "imu": 10.0, "gps": 1000.0, "compass": 3.0}[sensor]
    for row in span.of(log.rows[sensor]):
        if dice.random() < share:
            for column in NUMBERS[sensor]:
                if row[column]:
                    row[column] = repr(float(row[column]) + dice.uniform(-size, size))
    return f"{100 * share:.0f} % outliers of {sensor}, {span}", span.ends


def frozen(log, dice):
    sensor, span = dice.choice(SENSORS), Span(dice)
    rows = span.of(log.rows[sensor])
    for row in rows:
        row[2:] = rows[0][2:]
    return f"{sensor} frozen, {span}", span.ends


FAULTS = (clock_of_all_set, clock_of_one_wrong, single_stamps_wrong, stamps_stuck, loss, silence, duplicates, reordering,
          not_a_number, jump, outliers, frozen)


def spoil(log, number):
    """One fault or two; the texts, the kinds, and whether all of them end."""
    dice = random.Random(number)
    kinds = dice.sample(FAULTS, dice.choice((1, 2)))
    kinds.sort(key=FAULTS.index, reverse=True)  # the clock of all is set last: spans are in true time
    texts, ends = zip(*(kind(log, dice) for kind in kinds))
    return texts, [kind.__name__ for kind in kinds], all(ends)


def errors(out, truth, log):
    """(stamp, true time, error [m], larger sigma [m]) of the estimates, in the order of the file."""
    times = [row[0] for row in truth]
    estimate = {row[0]: row for row in rows_of(out / "trajectory.txt")}
    result = []
    for t, xx, xy, _, yy, *_ in rows_of(out / "covariance.csv"):
        if t not in estimate:
            continue
        true_t = log.true_time(t)
        if not 0 <= true_t <= times[-1]:
            continue
        after = min(max(bisect.bisect(times, true_t), 1), len(times) - 1)
        a, b = truth[after - 1], truth[after]
        share = min(max((true_t - a[0]) / (b[0] - a[0]), 0), 1)
        x, y = (a[i] + share * (b[i] - a[i]) for i in (1, 2))
        mean = (xx + yy) / 2
        sigma = math.sqrt(max(mean + math.sqrt(max(mean**2 - xx * yy + xy**2, 0)), 0))
        error = math.hypot(estimate[t][1] - x, estimate[t][2] - y)
        result.append((t, true_t, error if math.isfinite(error) else math.inf, sigma if math.isfinite(sigma) else 0))
    return result


def first_divergence(samples):
    """The stamp at which the position has been off for 2 s, if any."""
    since = None
    for t, true_t, error, sigma in samples:
        if error <= max(2, 5 * sigma):
            since = None
        elif since is None:
            since = true_t
        elif true_t - since > 2:
            return t
    return None


def judge(code, out, truth, log, ends):
    scores = {"diverged": False, "unreported": False, "locked_out": False, "lost_with_0": False, "exit_4": code == 4, "other_exit": code not in (0, 4)}
    if not (out / "diagnostics.json").exists():
        return {**scores, "locked_out": ends, "lost_with_0": code == 0}
    diagnostics = json.loads((out / "diagnostics.json").read_text())
    samples = errors(out, truth, log)
    times, states = states_of(diagnostics["health"]["changes"])
    at = first_divergence(samples)
    if at is not None:
        warnings = [event["t_s"] for event in diagnostics["run"]["events"]] + [t for t, state in zip(times, states) if state != "ok"]
        scores["diverged"] = True
        scores["unreported"] = not any(t <= at for t in warnings)
    last_second = log.end() - 1
    end = [sample for sample in samples if sample[1] > last_second]
    error = end[-1][2] if end else math.inf
    return {**scores, "locked_out": ends and error > 3, "lost_with_0": error > 3 and code == 0 and states[-1] != "lost"}


def main():
    options = parser_of(__doc__).parse_args()
    number = options.seed - 1
    world, recorded, spoiled = number % WORLDS + 1, options.out / "recorded", options.out / "spoiled"
    run(options, ROOT / "config/faults.yaml", recorded, f"source.duration_s={LENGTH_S}", f"source.seed={world}",
        "sinks=[plugin: tum, plugin: log]", more=["--seed", str(world)])
    log = Log(recorded / "log")
    texts, kinds, ends = spoil(log, number)
    spoiled.mkdir(parents=True, exist_ok=True)
    log.write(spoiled)
    for name in ("replay.yaml", "reference_trajectory.csv"):
        shutil.copy(recorded / "log" / name, spoiled)
    command = [options.waymark, "run", spoiled / "replay.yaml", "--quiet", "--out", spoiled / "out"]
    for setting in ("source.max_bad_rows=1000000", "source.max_time_jump_s=9e9", "source.max_ahead_s=9e9", "sinks=[plugin: tum, plugin: diagnostics]"):
        command += ["--set", setting]
    code = subprocess.run(command, stderr=subprocess.DEVNULL).returncode  # whatever it is: it is judged
    scores = judge(code, spoiled / "out", rows_of(recorded / "reference.txt"), log, ends)
    print("; ".join(texts))
    print_scores({"all": scores, **{kind: scores for kind in kinds}})


if __name__ == "__main__":
    main()
