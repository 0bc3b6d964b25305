#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A dense map on a log of CARMEN that has no relations: distance to the poses that another particle filter gave to its scans, and what was claimed online.

Those poses are an estimate, good to about 0.05 m, not the truth. All places have the same values of the YAML but for the lengths of the match outdoors.

Examples:
  tests/results/places.py --place fhw --seed 3 --out out/fhw
  tests/results/places.py --place fhw --set maps=[] --out out/fhw_wheels
  tests/results/places.py --place fhw --steps --out out/fhw
  tests/results/places.py --place csail --backwards --out out/csail_backwards
"""
import bisect
import gzip
import json
import math
import os
import statistics

from one_run import ROOT, evaluate, heading_of, parser_of, print_scores, rows_of, run, states_of

# Place: time of its lines, x of the laser [m], and outdoors other lengths, as in the YAML.
PLACES = {
    "freiburg-101": ("ipc", -0.04, {}),
    "fhw": ("ipc", 0, {}),
    "belgioioso": ("lines", -0.04, {}),
    "csail": ("lines", 0, {}),
    "infinite-corridor": ("lines", 0, {}),
    "freiburg-campus": ("lines", -0.04, {"cell_m": 0.1, "range_max_m": 80, "wide_sigma_m": 0.24, "narrow_sigma_m": 0.07, "search_m": 0.56}),
    "mit-csail": ("ipc", 0, {}),
}
LINE_INTERVAL_S = 0.1
# A map is wrong if some pose of it is farther off than this [m]; right maps have 0.1 to 0.9, and on these two large places up to 2.6.
WRONG_M = {"infinite-corridor": 4.0, "freiburg-campus": 4.0}

FIRST = 30  # poses of the reference that show how its frame lies to that of the run
REFERENCE_SIGMA_M = 0.05


def log_of(place):
    return os.path.join(os.environ["WAYMARK_DATA"], "carmen_mit_csail/mit-csail.clf.gz" if place == "mit-csail" else f"carmen_rbpf_corrected/{place}.log.gz")


def write_backwards(place, folder):
    """The log with its lines from the last to the first, as if the robot had driven back all the way in reverse."""
    if PLACES[place][0] != "lines":
        raise SystemExit(f"{place} has times; only logs whose lines count can be turned round")
    with gzip.open(log_of(place), "rt") as log:
        lines = log.readlines()
    is_head = lambda line: line.startswith(("#", "PARAM"))
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{place}.log.gz"
    with gzip.open(file, "wt") as log:
        log.writelines([line for line in lines if is_head(line)] + [line for line in reversed(lines) if not is_head(line)])
    return file


def scans(place, file):
    """Stamp and pose of odometry of every scan, in the order of the lines."""
    times = PLACES[place][0]
    found, line = [], 0
    with gzip.open(file, "rt") as log:
        for words in map(str.split, log):
            if not words or words[0].startswith("#") or words[0] == "PARAM":
                continue
            line += 1
            if words[0] == "FLASER":
                pose = [float(word) for word in words[2 + int(words[1]):5 + int(words[1])]]
                found.append((line * LINE_INTERVAL_S if times == "lines" else float(words[-3]), pose))
    return found


def reference(place, file, backwards=False):
    """Stamp and pose that the other filter gave to scans."""
    name = "carmen_mit_csail/mit-csail.rbpf.txt" if place == "mit-csail" else f"carmen_rbpf_corrected/{place}.rbpf.txt"
    with open(os.path.join(os.environ["WAYMARK_DATA"], name)) as poses:
        rows = [[float(word) for word in line.split()] for line in poses if not line.startswith("#")]
    if place == "mit-csail":
        return [(row[0], row[1:]) for row in rows]
    if backwards:
        rows.reverse()
    stamps = [stamp for stamp, _ in scans(place, file)]
    if len(stamps) != len(rows):
        raise SystemExit(f"{place}: {len(stamps)} scans, but {len(rows)} poses")
    return [(stamp, row[1:]) for stamp, row in zip(stamps, rows)]


def motion(begin, end):
    x, y = end[0] - begin[0], end[1] - begin[1]
    c, s = math.cos(begin[2]), math.sin(begin[2])
    return x * c + y * s, y * c - x * s, math.remainder(end[2] - begin[2], 2 * math.pi)


def steps(place):
    """How far odometry and the other filter's poses differ from one scan to the next, per square root of the time between: RMS along, across, yaw."""
    poses = dict(reference(place, log_of(place)))
    both = [(stamp, odometry, poses[stamp]) for stamp, odometry in scans(place, log_of(place)) if stamp in poses]
    squares = [0.0, 0.0, 0.0]
    for (t0, o0, p0), (t1, o1, p1) in zip(both, both[1:]):
        for axis, (one, other) in enumerate(zip(motion(o0, o1), motion(p0, p1))):
            squares[axis] += math.remainder(one - other, 2 * math.pi) ** 2 / max(t1 - t0, 0.1) if axis == 2 else (one - other) ** 2 / max(t1 - t0, 0.1)
    return [math.sqrt(square / (len(both) - 1)) for square in squares]


def write_reference(place, poses, out):
    """The other filter's poses in the frame of the run: turned and moved to where the robot was at the first of them."""
    rows = rows_of(out / "trajectory.txt")
    laser = PLACES[place][1]
    stamps = [row[0] for row in rows]
    offsets = []
    for stamp, (x, y, heading) in poses[:FIRST]:
        row = rows[max(0, bisect.bisect_right(stamps, stamp + 1e-6) - 1)]
        own = heading_of(row)
        offsets.append((row[1] + laser * math.cos(own), row[2] + laser * math.sin(own), own - heading, x, y))
    turn = math.atan2(sum(math.sin(offset[2]) for offset in offsets), sum(math.cos(offset[2]) for offset in offsets))
    c, s = math.cos(turn), math.sin(turn)
    east = statistics.fmean(own_x - (c * x - s * y) for own_x, _, _, x, y in offsets)
    north = statistics.fmean(own_y - (s * x + c * y) for _, own_y, _, x, y in offsets)
    with open(out / "other.txt", "w") as file:
        for stamp, (x, y, heading) in poses:
            half = (heading + turn) / 2
            file.write(f"{stamp:.6f} {c * x - s * y + east} {s * x + c * y + north} 0 0 0 {math.sin(half)} {math.cos(half)}\n")


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--place", choices=PLACES, required=True)
    parser.add_argument("--noise", help="of the wheels, instead of that of the YAML: along,across,yaw")
    parser.add_argument("--backwards", action="store_true", help="the log from its end to its begin: the robot drives in reverse")
    parser.add_argument("--steps", action="store_true", help="only what odometry and the other filter's poses differ by from scan to scan")
    options = parser.parse_args()
    if options.steps:
        print_scores(dict(zip(("along_m_per_sqrt_s", "across_m_per_sqrt_s", "yaw_rad_per_sqrt_s"), steps(options.place))))
        return
    times, laser, outdoors = PLACES[options.place]
    settings, config = [], "config/carmen_mit_csail.yaml"
    if options.noise:
        along, across, yaw = options.noise.split(",")
        settings = [f"sensors.wheels.speed_noise_m_per_sqrt_s=[{along}, 0]", f"sensors.wheels.lateral_noise_m_per_sqrt_s=[{across}, 0]",
                    f"sensors.wheels.yaw_noise_rad_per_sqrt_s=[{yaw}, 0, 0]"]
    if options.place != "mit-csail":
        config = "config/carmen_sparse.yaml"
        settings += [f"variables.place={options.place}", f"variables.times={times}", f"variables.laser_x_m={laser}",
                     *(f"variables.{key}={value}" for key, value in outdoors.items())]
    file = log_of(options.place)
    if options.backwards:
        file = write_backwards(options.place, options.out.with_name(options.out.name + "_log"))
        settings.append(f"variables.log={file.parent}")
    run(options, ROOT / config, options.out, *settings, more=["--seed", str(options.seed)])
    write_reference(options.place, reference(options.place, file, options.backwards), options.out)
    other = ("--reference", options.out / "other.txt", "--max-time-gap", 100, "--lever-arm", f"{laser},0,0")
    scored = evaluate(options, "--estimate", options.out / "path.txt", "--align", "se2", *other)["trajectory"]
    online = evaluate(options, "--estimate", options.out / "trajectory.txt", "--covariance", options.out / "covariance.csv",
                      "--reference-sigma", REFERENCE_SIGMA_M, *other)["consistency"]
    diagnostics = json.loads((options.out / "diagnostics.json").read_text())
    maps, health = diagnostics["landmarks"], diagnostics["health"]
    figures = maps[0]["figures"] if maps else {}
    is_wrong = scored["ate_max_m"] > WRONG_M.get(options.place, 1.0)
    ends_ok = states_of(health["changes"])[1][-1] == "ok"
    ok = health["ok_s"] / sum(health[f"{state}_s"] for state in ("ok", "degraded", "lost"))
    print_scores({"rms_m": scored["ate_rms_m"], "median_m": scored["ate_median_m"], "max_m": scored["ate_max_m"], "poses": scored["scored"],
                  "failed_matches": figures.get("failed_matches"), "matches": figures.get("matches"), "is_wrong": is_wrong,
                  "wrong_ends_ok": ends_ok if is_wrong else None, "right_time_ok": None if is_wrong else ok,
                  "nees_median": online["nees_median"], "inside": online["nees_share_within_95"],
                  **{f"sigma_by_rms_{axis}": online[f"sigma_by_rms_{axis}"] for axis in ("x", "y", "yaw")}})


if __name__ == "__main__":
    main()
