#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A wall of mistakes: robots whose configuration has one mistake each, and what `waymark doctor` says about it.

Two simulated robots are recorded once (config/faults.yaml without faults, and config/indoor.yaml) and replayed with the
mistake; two recordings are read with it. A row is

  named           the sensor that is wrong is named, and no other one
  one of two      the sensor that is wrong is among those that are named together
  refused         the log is not read: an error names file, line and column
  detected        something is found, but the sensor is not named
  not observable  nothing is found, and the row says why nothing there can show it
  WRONG           another sensor is named
  silent          nothing is found

All files in config/ are examined as they are, too: whatever is found there is a false alarm (faults.yaml excepted).

Example:
  tests/results/mistakes.py --waymark build/release/bin/waymark --out tests/results/mistakes.txt
  tests/results/mistakes.py --waymark build/release/bin/waymark --robots outdoor indoor --no-configs
"""
import argparse
import collections
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DEGREE = 0.0174532925199433

# How the logs of the simulated robots are made.
SIMULATED = {
    "outdoor": ("faults.yaml", ["source.duration_s=300"]),
    "indoor": ("indoor.yaml", ["source.duration_s=150", "source.course.laps=5", "filter.particles=1"]),
}
RECORDED = {"dresden": "car_gps_imu_dresden.yaml", "car_park": "acfr_car_park.yaml", "intel": "carmen_intel.yaml",
            "husky": "rl_husky.yaml"}
# The files of the simulated logs, in the order of their source.
FILES = {"outdoor": ["wheels", "imu", "gps", "compass"], "indoor": ["wheels", "lidar"], "dresden": ["imu", "gps"],
         "car_park": ["wheels", "lidar", "gps"]}

# robot | mistake and its size | sensor that is wrong | overrides | why nothing there can show it, if that is so. `wheels.left_mps*10` stands for the scale of a column,
# `wheels.time+0.5` for an offset of stamps.
ROWS = """
outdoor | wheels ten times too fast | wheels | wheels.left_mps*10 wheels.right_mps*10
outdoor | wheels in mm/s | wheels | wheels.left_mps*1000 wheels.right_mps*1000
outdoor | wheels in km/h | wheels | wheels.left_mps*3.6 wheels.right_mps*3.6
outdoor | wheels 15 % too fast | wheels | wheels.left_mps*1.15 wheels.right_mps*1.15
outdoor | left and right wheel swapped | wheels | wheels.left_mps=right_mps wheels.right_mps=left_mps
outdoor | both wheels count backwards | wheels | wheels.left_mps*-1 wheels.right_mps*-1
outdoor | track width 20 % too large | wheels | sensors.wheels.track_m=0.6
outdoor | track width half | wheels | sensors.wheels.track_m=0.25
outdoor | left wheel 15 % too fast | wheels | wheels.left_mps*1.15
outdoor | gyro turns the other way | imu | imu.w_z_radps*-1
outdoor | gyro in degrees per second | imu | imu.w_x_radps*57.29578 imu.w_y_radps*57.29578 imu.w_z_radps*57.29578
outdoor | gyro's axes x and z swapped | imu | imu.w_x_radps=w_z_radps imu.w_z_radps=w_x_radps
outdoor | specific force in g | imu | imu.f_x_mps2*0.10197 imu.f_y_mps2*0.10197 imu.f_z_mps2*0.10197
outdoor | acceleration in place of specific force | imu | imu.f_x_mps2*-1 imu.f_y_mps2*-1 imu.f_z_mps2*-1
outdoor | IMU mounted on its side | imu | sensors.imu.base_T_sensor.roll_deg=90
outdoor | compass in degrees | compass | compass.heading_rad*57.29578
outdoor | compass mounted +90 degrees | compass | sensors.compass.base_T_sensor.yaw_deg=90
outdoor | compass mounted -90 degrees | compass | sensors.compass.base_T_sensor.yaw_deg=-90
outdoor | compass mounted 180 degrees | compass | sensors.compass.base_T_sensor.yaw_deg=180
outdoor | compass mounted 25 degrees | compass | sensors.compass.base_T_sensor.yaw_deg=25
outdoor | compass counts counter-clockwise | compass | compass.heading_rad*-1
outdoor | GPS by the clock of GPS, 18 s ahead | gps | gps.time+18
outdoor | east and north swapped | gps | gps.east_m=north_m gps.north_m=east_m
outdoor | east counts to the west | gps | gps.east_m*-1
outdoor | course in degrees | gps | gps.course_rad*57.29578
outdoor | speed of the receiver in km/h | gps | gps.speed_mps*3.6
outdoor | positions in feet | gps | gps.east_m*3.28084 gps.north_m*3.28084
outdoor | GPS 1 s late | gps | gps.time+1
outdoor | IMU 0.5 s late | imu | imu.time+0.5
outdoor | wheels 0.5 s late | wheels | wheels.time+0.5
outdoor | compass 0.7 s late | compass | compass.time+0.7
outdoor | antenna 2 m off | gps | sensors.gps.base_p_antenna_m=[2.2,0,1]
outdoor | stamps of the IMU in ms | imu | imu.time*1e-6
outdoor | stamps of the wheels in ms | wheels | wheels.time*1e-6
indoor | wheels ten times too fast | wheels | wheels.left_mps*10 wheels.right_mps*10
indoor | wheels 20 % too slow | wheels | wheels.left_mps*0.8 wheels.right_mps*0.8
indoor | left and right wheel swapped | wheels | wheels.left_mps=right_mps wheels.right_mps=left_mps
indoor | both wheels count backwards | wheels | wheels.left_mps*-1 wheels.right_mps*-1
indoor | track width 30 % too large | wheels | sensors.wheels.track_m=0.65
indoor | left wheel 30 % too fast | wheels | wheels.left_mps*1.3
indoor | ranges in mm | lidar | lidar.ranges_m*1000
indoor | ranges 15 % too long | lidar | lidar.ranges_m*1.15
indoor | scan mirrored, from the left | lidar | source.files.lidar.scan={start_deg:90,step_deg:-1}
indoor | scan mirrored, step alone | lidar | source.files.lidar.scan={start_deg:-90,step_deg:-1}
indoor | scanner mounted +90 degrees | lidar | sensors.lidar.base_T_sensor.yaw_deg=90
indoor | scanner mounted 180 degrees | lidar | sensors.lidar.base_T_sensor.yaw_deg=180
indoor | scanner mounted 10 degrees | lidar | sensors.lidar.base_T_sensor.yaw_deg=10
indoor | scanner 0.5 m off | lidar | sensors.lidar.base_T_sensor.xyz_m=[0.7,0,0.3]
indoor | beams of a scan take 9 s | lidar | source.files.1.scan.beam_interval_s=0.05
indoor | scanner 0.4 s late | lidar | lidar.time+0.4
indoor | stamps of the wheels in ms | wheels | wheels.time*1e-6
dresden | specific force as acceleration | imu | imu.f_x_mps2*1 imu.f_y_mps2*1 imu.f_z_mps2*1
dresden | specific force in g | imu | imu.f_x_mps2*-0.10197 imu.f_y_mps2*-0.10197 imu.f_z_mps2*-0.10197
dresden | gyro in degrees per second | imu | imu.w_x_radps=rollrate imu.w_y_radps=pitchrate imu.w_z_radps=yawrate
dresden | gyro turns the other way | imu | imu.w_z_radps*-0.0174532925199433
dresden | roll rate taken for yaw rate | imu | imu.w_z_radps={column:rollrate,scale:0.0174532925199433}
dresden | latitude and longitude swapped | gps | gps.latitude_deg=longitude gps.longitude_deg=latitude
dresden | speed in km/h | gps | gps.speed_mps=speed
dresden | course in degrees | gps | gps.course_rad=course
dresden | stamps in milliseconds as seconds | imu,gps | source.files.0.time=millis source.files.1.time=millis
dresden | IMU 1 s late | imu | source.files.0.time={column:millis,scale:1.0e-3,offset_s:1} | its receiver's velocity is 1 s behind the gyro in the recording, so now they agree
dresden | gyro 30 % too fast | imu | imu.w_z_radps*0.0226892802759263
car_park | wheels in km/h | wheels | wheels.speed_mps={column:rear_wheel_speed_mps,scale:3.6}
car_park | wheels 15 % too slow | wheels | wheels.speed_mps={column:rear_wheel_speed_mps,scale:0.85}
car_park | steering to the right positive | wheels | wheels.steering_rad*-1
car_park | steering in degrees | wheels | wheels.steering_rad*57.29578
car_park | wheelbase 40 % too long | wheels | sensors.wheels.wheelbase_m=4
car_park | east and north swapped | gps | gps.east_m=y_m gps.north_m=x_m
car_park | GPS 1.5 s late | gps | source.files.2.time={column:t_s,offset_s:1.5}
car_park | antenna at the rear axle | gps | sensors.gps.base_p_antenna_m=[0,0,0]
car_park | scanner turned by 180 degrees | lidar | sensors.lidar.base_T_sensor.yaw_deg=180
car_park | scan mirrored | lidar | source.files.1.scan={start_deg:90,step_deg:-0.5}
intel | scan mirrored | lidar | source.lasers.0.start_deg=89.5 source.lasers.0.step_deg=-1
intel | scanner mounted 180 degrees | lidar | sensors.lidar.base_T_sensor.yaw_deg=180
intel | scanner mounted +90 degrees | lidar | sensors.lidar.base_T_sensor.yaw_deg=90
husky | IMU not on its side | imu | sensors.imu.base_T_sensor.roll_deg=0
husky | IMU upside down | imu | sensors.imu.base_T_sensor.roll_deg=-90
husky | GPS 1.5 s early | gps | sensors.gps.delay_s=1.5
husky | IMU 0.6 s early | imu | sensors.imu.delay_s=0.6
"""


def overrides_of(robot, text):
    """The overrides of a row, with what stands for columns written out."""
    result = []
    for word in text.split():
        sensor, _, rest = word.partition(".")
        files = FILES.get(robot, [])
        if word.startswith("source.files.") and word.split(".")[2] in files:
            word = word.replace(f"source.files.{word.split('.')[2]}", f"source.files.{files.index(word.split('.')[2])}", 1)
        if sensor not in files:
            result.append(word)
            continue
        place = f"source.files.{files.index(sensor)}"
        if rest.startswith("time"):
            scale, offset = ("1e-9", rest[5:]) if rest[4] == "+" else (rest[5:], "0")
            result.append(f"{place}.time={{ column: t_ns, scale: {scale}, offset_s: {offset} }}")
            result.append(f"{place}.arrival={{ column: arrival_ns, scale: {scale}, offset_s: {offset} }}")
        elif "*" in rest:
            field, scale = rest.split("*")
            column = COLUMNS.get((robot, field), field)
            if field == "ranges_m":
                result.append(f"{place}.columns.{field}.scale={scale}")
            else:
                result.append(f"{place}.columns.{field}={{ column: {column}, scale: {scale} }}")
        else:
            field, column = rest.split("=", 1)
            result.append(f"{place}.columns.{field}={column}")
    return [w.replace(":", ": ") if "{" in w and ": " not in w else w for w in result]


# Columns of the recordings whose names are not those of the fields.
COLUMNS = {("dresden", "f_x_mps2"): "ax", ("dresden", "f_y_mps2"): "ay", ("dresden", "f_z_mps2"): "az",
           ("dresden", "w_z_radps"): "yawrate", ("car_park", "steering_rad"): "steering_rad"}


def record(waymark, robot, folder):
    """Records a simulated robot; its YAML that replays the log."""
    config, settings = SIMULATED[robot]
    command = [waymark, "run", str(ROOT / "config" / config), "--out", str(folder / robot), "--quiet"]
    for setting in [*settings, "sinks=[plugin: log]", "maps=[]"]:
        command += ["--set", setting]
    subprocess.run(command, check=True)
    return folder / robot / "log" / "replay.yaml"


def examine(waymark, config, overrides):
    """Findings, and the error if there was one."""
    command = [waymark, "doctor", str(config), "--json"]
    for override in overrides:
        command += ["--set", override]
    run = subprocess.run(command, capture_output=True, text=True)
    findings = json.loads(run.stdout)["findings"] if run.stdout.startswith("{") else []
    return findings, run.stderr.strip() if run.returncode == 1 else ""


def said_of(findings, error):
    """What was found, or the error, without the place of the recordings."""
    said = "; ".join(f"{f['certainty']} {', '.join(f['sensors'])}: {f['seen']} -> {f['change']}" for f in findings) or error
    data = os.environ.get("WAYMARK_DATA")
    return said.replace(data.rstrip("/"), "DATA") if data else said


def outcome_of(findings, error, culprits, unobservable):
    named = [f["sensors"][0] for f in findings if f["certainty"] == "named"]
    among = [s for f in findings if f["certainty"] == "one of" for s in f["sensors"]]
    if named and set(named) <= culprits:
        return "named"
    if named:
        return "WRONG"
    if culprits & set(among):
        return "one of two"
    if error:
        return "refused"
    if findings:
        return "detected"
    return "not observable" if unobservable else "silent"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", required=True)
    parser.add_argument("--out", type=Path, help="file for the table")
    parser.add_argument("--robots", nargs="*", help="only these")
    parser.add_argument("--no-configs", action="store_true", help="without the files in config/")
    parser.add_argument("--most-silent", type=int, default=0, help="rows that may be silent without the exit code being 1")
    parser.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args()
    has_data = bool(os.environ.get("WAYMARK_DATA"))
    rows = [[part.strip() for part in line.split("|")] for line in ROWS.strip().splitlines()]
    rows = [row for row in rows if (not arguments.robots or row[0] in arguments.robots) and (row[0] in SIMULATED or has_data)]

    lines, counts, false_alarms = [], collections.Counter(), 0
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(arguments.jobs) as pool:
        folder = Path(name)
        configs = {robot: ROOT / "config" / config for robot, config in RECORDED.items()}
        for robot in sorted({row[0] for row in rows} & set(SIMULATED)):
            configs[robot] = record(arguments.waymark, robot, folder)

        def run_row(row):
            robot, mistake, culprits, overrides, *why = row
            findings, error = examine(arguments.waymark, configs[robot], overrides_of(robot, overrides))
            outcome = outcome_of(findings, error, set(culprits.split(",")), why)
            said = said_of(findings, error) or "; ".join(why)
            return outcome, f"{robot:<9} {mistake:<40} {culprits:<8} {outcome:<14} {said}".rstrip()

        for outcome, line in pool.map(run_row, rows):
            counts[outcome] += 1
            lines.append(line)
            print(line, flush=True)

        healthy = [] if arguments.no_configs else sorted((ROOT / "config").glob("*.yaml"))
        healthy = [(path.stem, path) for path in healthy if path.stem != "faults" and not path.stem.startswith("live_")]
        healthy = [entry for entry in healthy if has_data or "WAYMARK_DATA" not in entry[1].read_text()]
        healthy += [(f"{robot} as it is", configs[robot]) for robot in configs if robot in SIMULATED]
        for (label, _), (findings, error) in zip(healthy, pool.map(lambda e: examine(arguments.waymark, e[1], []), healthy)):
            said = said_of(findings, error)
            false_alarms += len(findings)
            lines.append(f"{label:<40} {'FALSE ALARM  ' + said if said else 'nothing found'}")
            print(lines[-1], flush=True)

    total = sum(counts.values())
    summary = f"{total} mistakes: " + ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    summary += f"; {false_alarms} false alarms on {len(healthy)} robots without a mistake"
    print(summary)
    if arguments.out:
        arguments.out.write_text("\n".join(lines) + "\n\n" + summary + "\n")
    return 0 if counts["silent"] <= arguments.most_silent and counts["WRONG"] + false_alarms == 0 and counts["named"] + counts["refused"] >= 0.9 * total else 1


if __name__ == "__main__":
    sys.exit(main())
