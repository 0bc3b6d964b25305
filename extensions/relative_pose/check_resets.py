#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes a LIDAR odometry with resets out of true poses, and fails if a reset moves the robot.

    WAYMARK_PLUGIN_PATH=build ./check_resets.py computed|recorded --waymark WAYMARK --out OUT [--seeds 5]

The true poses are a computed drive, or those of a Jackal by motion capture (jackal_mocap_scan, needs WAYMARK_DATA; else it ends with 77).
Every 0.1 s the odometry gives a motion with 3 mm and 0.15° of noise. Its frame begins anew at six random times: the motion of that
interval is then that between two frames, metres. Compared, at the end and at worst (min / median / max over drives and seeds):
  clean     the odometry without resets, and relative_pose
  hidden    with resets that the odometry does not report
  reported  with resets that it reports (`tracked` 0)
  lost      the same, and twice the track is lost for half a second: what the robot does meanwhile nobody knows
  plain     with resets that it does not report, and waymark's `odometry` in the place of relative_pose
"""
import argparse
import gzip
import math
import os
import pathlib
import random
import statistics
import subprocess
import sys

FOLDER = pathlib.Path(__file__).parent
STEP, SIGMA_M, SIGMA_RAD = 0.1, 0.003, math.radians(0.15)
CAMERA = (0.1, 0.0, 0.0)  # in the base frame, as in track.yaml
# What a Jackal does, by its motions without resets; it steers by skidding, in jerks.
JACKAL = {"max_speed_mps": 1.0, "max_rate_degps": 110, "max_acceleration_mps2": 8, "max_angular_acceleration_degps2": 700}
PLAIN = """source:
  plugin: csv
  files:
    - path: "{log}"
      sensor: camera
      payload: PoseIncrement
      time: begin_s
      arrival: end_s
      columns: {{ interval_s: interval_s, x_m: base_x_m, y_m: base_y_m, yaw_rad: yaw_rad }}
initial: {{ x_m: 0, y_m: 0, yaw_deg: 0 }}
motion: {{ kind: planar }}
filter: {{ max_latency_s: 0.3 }}
sensors: [{{ name: camera, plugin: odometry, model: increment }}]
sinks: [{{ plugin: tum }}]
"""


def compose(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], math.remainder(a[2] + b[2], 2.0 * math.pi)


def inverse(a):
    c, s = math.cos(a[2]), math.sin(a[2])
    return -c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]


def computed():
    """(t, pose): two minutes of curves, stops and turns in place."""
    pose, poses, v, w = (0.0, 0.0, 0.0), [], 0.0, 0.0
    for k in range(6001):
        t = 0.02 * k
        poses.append((t, pose))
        to_v, to_w = ((0.8, 0.0), (0.6, 0.5), (0.0, 0.0), (0.0, 0.8), (0.8, -0.4), (0.3, 0.0))[int(t / 4.0) % 6]
        v += max(-0.02, min(0.02, to_v - v))
        w += max(-0.04, min(0.04, to_w - w))
        pose = compose(pose, (0.02 * v, 0.0, 0.02 * w))
    return {"computed": poses}


def recorded():
    if not os.environ.get("WAYMARK_DATA"):
        print("skipped: WAYMARK_DATA is not set")
        sys.exit(77)
    folder = pathlib.Path(os.environ["WAYMARK_DATA"]) / "jackal_mocap_scan"
    drives = {}
    for name in ("2026-02-17-15-18-31", "2026-02-17-16-26-34"):  # the stamps of a third come in bursts: no speeds can be had of it
        poses, last = [], -1.0
        for line in gzip.open(folder / f"{name}_mocap.csv.gz", "rt"):
            if line[0] == "t":
                continue
            t, _, x, y, _, qx, qy, qz, qw = map(float, line.split(","))
            if t > last:  # stamps come in bursts
                poses.append((t, (x, y, math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz)))))
                last = t
        drives[name] = poses
    return drives


def sampled(poses):
    """Every STEP, in the frame of the first pose."""
    first, out = inverse(poses[0][1]), []
    for t, pose in poses:
        if not out or t >= out[-1][0] + STEP:
            out.append((t, compose(first, pose)))
    return out


def write_log(file, truth, resets, lost, reported, noise):
    camera = (CAMERA[0], CAMERA[1], 0.0)
    frame = (0.0, 0.0, 0.0)  # of the odometry, in the map
    with open(file, "w") as log:
        log.write("begin_s,end_s,interval_s,x_m,y_m,q_w,q_z,sigma_m,sigma_rad,tracked,base_x_m,base_y_m,yaw_rad\n")
        for k, ((t0, a), (t1, b)) in enumerate(zip(truth, truth[1:])):
            error = noise.gauss(0.0, SIGMA_M), noise.gauss(0.0, SIGMA_M), noise.gauss(0.0, SIGMA_RAD)
            before = compose(inverse(frame), a)  # the pose in the odometry's frame
            if k in resets:
                frame = b  # it begins anew where the robot is
            motion = compose(compose(inverse(before), compose(inverse(frame), b)), error)
            if k in lost:
                motion = error  # it sees nothing move
            of_camera = compose(compose(inverse(camera), motion), camera)
            tracked = 0 if reported and (k in resets or k in lost) else 1
            log.write(f"{t0:.6f},{t1:.6f},{t1 - t0!r},{of_camera[0]!r},{of_camera[1]!r},{math.cos(0.5 * motion[2])!r},"
                      f"{math.sin(0.5 * motion[2])!r},{SIGMA_M},{SIGMA_RAD},{tracked},{motion[0]!r},{motion[1]!r},{motion[2]!r}\n")


def errors(trajectory, truth):
    """Largest and last error of the position."""
    places = {round(t, 3): pose for t, pose in truth}
    found = []
    for line in trajectory.read_text().splitlines():
        if line.startswith("#"):
            continue
        t, x, y = (float(word) for word in line.split()[:3])
        if round(t, 3) in places:
            found.append(math.dist((x, y), places[round(t, 3)][:2]))
    if len(found) < 100:
        sys.exit(f"{trajectory}: {len(found)} poses at the times of true ones; at least 100 are expected")
    return max(found), found[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drive", choices=["computed", "recorded"])
    parser.add_argument("--waymark", required=True)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("--seeds", type=int, default=2)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    ends, worst = {}, {}
    for name, poses in (computed if arguments.drive == "computed" else recorded)().items():
        truth = sampled(poses)
        for seed in range(1, arguments.seeds + 1):
            draws = random.Random(seed)
            count = len(truth) - 1
            resets = set(draws.sample(range(20, count), 6))
            lost = {k + i for k in draws.sample(range(20, count - 5), 2) for i in range(5)}
            for case in ("clean", "hidden", "reported", "lost", "plain"):
                log = (arguments.out / f"{name}_{seed}_{case}.csv").resolve()
                write_log(log, truth, set() if case == "clean" else resets,
                          lost if case == "lost" else set(), case in ("reported", "lost"), random.Random(seed))
                out = arguments.out / f"{name}_{seed}_{case}"
                yaml = FOLDER / "track.yaml"
                if case == "plain":
                    yaml = arguments.out / "plain.yaml"
                    yaml.write_text(PLAIN.format(log=log))
                settings = [] if case == "plain" else ["--set", f"variables.log={log}"]
                if case != "plain" and arguments.drive == "recorded":
                    settings += [word for key, value in JACKAL.items() for word in ("--set", f"sensors.camera.{key}={value}")]
                subprocess.run([arguments.waymark, "run", yaml, "--out", out, "--quiet"] + settings, check=True)
                largest, last = errors(out / "trajectory.txt", truth)
                ends.setdefault(case, []).append(last)
                worst.setdefault(case, []).append(largest)
    for case in ends:
        print(f"{case:9s} at the end {min(ends[case]):.3f} / {statistics.median(ends[case]):.3f} / {max(ends[case]):.3f} m, at worst "
              f"{min(worst[case]):.3f} / {statistics.median(worst[case]):.3f} / {max(worst[case]):.3f} m")
    # Six tenths of a second of unknown motion are decimetres. A reset that is believed is metres.
    for case in ("hidden", "reported"):
        moved = max(a - b for a, b in zip(worst[case], worst["clean"]))
        if moved > 0.5:
            sys.exit(f"{case}: resets move the robot by {moved:.2f} m; expected at most 0.5 m")
        print(f"{case}: resets move the robot by {moved:.2f} m at most")
    if not statistics.median(worst["plain"]) > 1.0:
        sys.exit("the resets move nothing, even if they are believed: this test shows nothing")


if __name__ == "__main__":
    main()
