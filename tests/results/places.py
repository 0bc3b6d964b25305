#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Dense maps on the logs of CARMEN that have no relations: distance to the poses that another particle filter gave to their scans, as a table over seeds.

Those poses are an estimate, good to about 0.05 m, not the truth. All places have the same values of the YAML but for the lengths of the match outdoors.

Example:
  tests/results/places.py --waymark build/release/bin/waymark --places freiburg-101,fhw --seeds 5
"""
import argparse
import gzip
import json
import math
import os
import tempfile

from dense import evaluate_path, timed_run
from faults import cell

# Place: time of its lines, x of the laser [m], and outdoors other lengths, as in the YAML.
PLACES = {
    "freiburg-101": ("ipc", -0.04, {}),
    "fhw": ("ipc", 0, {}),
    "belgioioso": ("lines", -0.04, {}),
    "csail": ("lines", 0, {}),
    "infinite-corridor": ("lines", 0, {}),
    "freiburg-campus": ("lines", -0.04, {"cell_m": 0.1, "range_max_m": 80, "wide_sigma_m": 0.24, "narrow_sigma_m": 0.1, "search_m": 0.56}),
    "mit-csail": ("ipc", 0, {}),
}
LINE_INTERVAL_S = 0.1
# A map is wrong if some pose of it is farther off than this [m]; right maps have 0.1 to 0.9, and on these two large places up to 2.6.
WRONG_M = {"infinite-corridor": 4.0, "freiburg-campus": 4.0}


def scans(place):
    """Stamp and pose of odometry of every scan, in the order of the lines."""
    times = PLACES[place][0]
    folder = "carmen_mit_csail/mit-csail.clf.gz" if place == "mit-csail" else f"carmen_rbpf_corrected/{place}.log.gz"
    found, line = [], 0
    with gzip.open(os.path.join(os.environ["WAYMARK_DATA"], folder), "rt") as log:
        for words in map(str.split, log):
            if not words or words[0].startswith("#") or words[0] == "PARAM":
                continue
            line += 1
            if words[0] == "FLASER":
                pose = [float(word) for word in words[2 + int(words[1]):5 + int(words[1])]]
                found.append((line * LINE_INTERVAL_S if times == "lines" else float(words[-3]), pose))
    return found


def reference(place):
    """Stamp and pose that the other filter gave to scans."""
    name = "carmen_mit_csail/mit-csail.rbpf.txt" if place == "mit-csail" else f"carmen_rbpf_corrected/{place}.rbpf.txt"
    with open(os.path.join(os.environ["WAYMARK_DATA"], name)) as file:
        rows = [[float(word) for word in line.split()] for line in file if not line.startswith("#")]
    if place == "mit-csail":
        return [(row[0], row[1:]) for row in rows]
    stamps = [stamp for stamp, _ in scans(place)]
    if len(stamps) != len(rows):
        raise SystemExit(f"{place}: {len(stamps)} scans, but {len(rows)} poses")
    return [(stamp, row[1:]) for stamp, row in zip(stamps, rows)]


def motion(begin, end):
    x, y = end[0] - begin[0], end[1] - begin[1]
    c, s = math.cos(begin[2]), math.sin(begin[2])
    return x * c + y * s, y * c - x * s, math.remainder(end[2] - begin[2], 2 * math.pi)


def steps(place):
    """How far odometry and the other filter's poses differ from one scan to the next, per square root of the time between: RMS along, across, yaw."""
    poses = dict(reference(place))
    both = [(stamp, odometry, poses[stamp]) for stamp, odometry in scans(place) if stamp in poses]
    squares = [0.0, 0.0, 0.0]
    for (t0, o0, p0), (t1, o1, p1) in zip(both, both[1:]):
        for axis, (one, other) in enumerate(zip(motion(o0, o1), motion(p0, p1))):
            squares[axis] += math.remainder(one - other, 2 * math.pi) ** 2 / max(t1 - t0, 0.1) if axis == 2 else (one - other) ** 2 / max(t1 - t0, 0.1)
    return [math.sqrt(square / (len(both) - 1)) for square in squares]


def run(arguments, place, seed, more={}):
    times, laser, outdoors = PLACES[place]
    settings = {}
    if arguments.noise:
        along, across, yaw = arguments.noise.split(",")
        settings = {"sensors.wheels.speed_noise_m_per_sqrt_s": f"[{along}, 0]", "sensors.wheels.lateral_noise_m_per_sqrt_s": f"[{across}, 0]",
                    "sensors.wheels.yaw_noise_rad_per_sqrt_s": f"[{yaw}, 0, 0]"}
    config = "config/carmen_mit_csail.yaml"
    if place != "mit-csail":
        config = "config/carmen_sparse.yaml"
        settings |= {"variables.place": place, "variables.times": times, "variables.laser_x_m": laser, **{f"variables.{key}": value for key, value in outdoors.items()}}
    with tempfile.TemporaryDirectory() as out:
        out = os.path.join(arguments.keep, f"{place}_{seed}") if arguments.keep and not more else out
        usage = timed_run(arguments, config, out, seed, settings | more)
        with open(f"{out}/other.txt", "w") as file:
            for stamp, (x, y, heading) in reference(place):
                file.write(f"{stamp:.6f} {x} {y} 0 0 0 {math.sin(heading / 2)} {math.cos(heading / 2)}\n")
        scored = evaluate_path(arguments, out, "--reference", f"{out}/other.txt", "--align", "se2", "--max-time-gap", "100",
                               "--lever-arm", f"{laser},0,0")["trajectory"]
        with open(f"{out}/diagnostics.json") as file:
            diagnostics = json.load(file)
        maps, health = diagnostics["landmarks"], diagnostics["health"]
        end = [change["state"] for change in health["changes"] if change["of"] == "all"] or ["ok"]
        durations = [health[f"{state}_s"] for state in ("ok", "degraded", "lost")]
        figures = maps[0]["figures"] if maps else {}
        return {"rms": scored["ate_rms_m"], "median": scored["ate_median_m"], "max": scored["ate_max_m"], "scored": scored["scored"],
                "failed": figures.get("failed_matches"), "matches": figures.get("matches"), "cpu": usage.ru_utime + usage.ru_stime,
                "end": end[-1], "ok": durations[0] / sum(durations), "is_wrong": scored["ate_max_m"] > WRONG_M.get(place, 1.0)}


def health(arguments, places):
    """Whether a run with a wrong map ends ok, and for which share of its time a right one is ok."""
    counts = {True: [0, 0], False: [0, 0]}  # wrong, right: runs, and those that end ok
    shares = []
    print("| place | particles | maps that are wrong | of them ok at the end | time that right ones are ok, least / median |")
    print("|---|---|---|---|---|")
    for place in places:
        for particles in arguments.health.split(","):
            results = [run(arguments, place, seed, {"filter.particles": particles}) for seed in range(1, arguments.seeds + 1)]
            for result in results:
                counts[result["is_wrong"]][0] += 1
                counts[result["is_wrong"]][1] += result["end"] == "ok"
            wrong = [result for result in results if result["is_wrong"]]
            right = sorted(result["ok"] for result in results if not result["is_wrong"])
            shares += right
            share = f"{100 * right[0]:.1f} / {100 * right[len(right) // 2]:.1f} %" if right else "–"
            print(f"| {place} | {particles} | {len(wrong)} of {len(results)} | {sum(result['end'] == 'ok' for result in wrong)} | {share} |", flush=True)
    print(f"\n{counts[True][0]} runs with a wrong map, {counts[True][1]} of them ok at the end; {counts[False][0]} with a right one, "
          f"{sum(share >= 0.95 for share in shares)} of them ok for 95 % of their time.")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default="build/release/bin/waymark")
    parser.add_argument("--places", default=",".join(PLACES), help="comma-separated")
    parser.add_argument("--seeds", type=int, default=5, help="seeds 1..N (default 5)")
    parser.add_argument("--keep", help="folder for the results of every run")
    parser.add_argument("--noise", help="of the wheels, instead of that of the YAML: along,across,yaw")
    parser.add_argument("--steps", action="store_true", help="only show what odometry and the other filter's poses differ by")
    parser.add_argument("--health", help="instead, whether the health is right: numbers of particles, comma-separated")
    parser.add_argument("--set", action="append", default=[], help="override of the YAML")
    arguments = parser.parse_args()
    places = arguments.places.split(",")
    if arguments.steps:
        for place in places:
            print(place, *(f"{value:.3f}" for value in steps(place)))
        return
    if arguments.health:
        return health(arguments, places)
    print("| place | poses | wheels alone, RMS [m] | RMS [m] | median [m] | largest [m] | failed of all matches, median | CPU [s] |")
    print("|---|---|---|---|---|---|---|---|")
    for place in places:
        without_maps = argparse.Namespace(**vars(arguments) | {"set": [one for one in arguments.set if not one.startswith("maps.")]})
        wheels = run(without_maps, place, 1, {"maps": "[]"})
        results = [run(arguments, place, seed) for seed in range(1, arguments.seeds + 1)]
        of = lambda key: sorted(result[key] for result in results)
        middle = lambda key: of(key)[len(results) // 2]
        print(f"| {place} | {results[0]['scored']} | {wheels['rms']:.2f} | {cell(of('rms'), 3)} | {cell(of('median'), 3)} | {cell(of('max'))} "
              f"| {middle('failed'):.0f} of {middle('matches') + middle('failed'):.0f} | {cell(of('cpu'), 1)} |", flush=True)


if __name__ == "__main__":
    main()
