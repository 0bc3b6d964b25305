#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Faults injected into running robots, as a table of what happened. Outside of CI: it takes about an hour.

A robot drives a circle at 1 m/s and sends wheels (50 Hz) and fixes (5 Hz) as JSON; waymark runs on them as it would on a robot. The
position is compared with the circle. `replay`, `commands` and `latency` run config/quickstart.yaml in real time instead (LIDAR,
landmarks, 25 particles). `topics_*` send samples of ROS 2 by tests/peers/publish_bytes, which lies beside the program in build/dev.
`disk` mounts a tmpfs, `interface` and `topics_interface` use a network of their own: they need root.

Example:
  tests/results/live_faults.py --waymark build/release/bin/waymark --data "$WAYMARK_DATA"
  tests/results/live_faults.py --case kills --kills 24
"""
import argparse
import os
import pathlib
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time

from live_cases import CASES, case, row, tcp_robot, end, interrupt
from live_inputs import interface_in_its_network
from live_robot import Driver, Tcp, Waymark, circle, counted, eventually, fix_line, free_port, same_files, twist_line
from live_topics import topics_in_their_network

QUICKSTART = pathlib.Path(__file__).resolve().parents[2] / "config/quickstart.yaml"


@case
def cold_start(arguments, folder):
    """A receiver without a fix yet may begin with any date, such as 1024 weeks ago."""
    for name, error in (("1024 weeks ago", -1024 * 7 * 86400.0), ("tomorrow", 86400.0)):
        port = free_port()
        robot = Waymark(arguments.waymark, folder / name.split()[-1], f"plugin: json, from: tcp, port: {port}", "")
        robot.start()
        driver = Driver(Tcp(port), clock_error_s={"gps": error})
        robot.wait_until_under_way()
        time.sleep(5)
        driver.clock_error_s["gps"] = 0.0
        time.sleep(7)
        _, report, text = end(robot, driver)
        gps = counted(report, "gps")
        row(f"the GPS's date is that of {name} for 5 s, then right",
            f"{gps['fused']} fixes fused, {gps['mistimed'] + gps['late']} refused; {text}")


@case
def stall(arguments, folder):
    robot, driver, _ = tcp_robot(arguments, folder)
    report, seen, text = interrupt(robot, driver, lambda: robot.send(signal.SIGSTOP), 10, lambda: robot.send(signal.SIGCONT), look=False)
    steps = sum("was set" in event["text"] for event in report["run"]["events"])
    row("stopped for 10 s (SIGSTOP)", f"{seen}, {steps} steps of clocks reported; {text}")


@case
def disk(arguments, folder):
    small = folder / "small"
    small.mkdir(parents=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(small)], check=True)
    try:
        port = free_port()
        robot = Waymark(arguments.waymark, folder, f"plugin: json, from: tcp, port: {port}", "record: { compression: none, flush_s: 0.1 }")
        robot.out = small / "out"
        driver = Driver(Tcp(port))
        robot.start()
        robot.wait_until_under_way()
        filler = small / "filler"
        time.sleep(2)
        file = os.open(filler, os.O_WRONLY | os.O_CREAT)
        try:
            while True:
                os.write(file, b"\0" * 4096)
        except OSError:
            os.close(file)
        ended = eventually(lambda: "ended early" in robot.messages(), 20)
        time.sleep(3)
        status = robot.status()
        filler.unlink(missing_ok=True)
        time.sleep(1)
        _, _, text = end(robot, driver)
        replay = subprocess.run([arguments.waymark, "run", str(robot.out / "flight.mcap"), "--out", str(folder / "replay"), "--quiet"],
                                capture_output=True, text=True)
        row("disk full while recording", f"{'event: the recording ended early' if ended else 'NO EVENT'}; the robot goes on "
            f"(health {status['health']}); {text}; what was recorded replays with exit code {replay.returncode}")
    finally:
        subprocess.run(["umount", str(small)], check=False)


@case
def kills(arguments, folder):
    """Everything that the robot sent is counted by the filter, but for what came after the last checkpoint."""
    period = 1.0
    more = ""
    options = ["--set", f"live.checkpoint={{every_s: {period}, resume: true}}"]
    port = free_port()
    robot = Waymark(arguments.waymark, folder, f"plugin: json, from: tcp, port: {port}", more, options)
    feed = Tcp(port)
    driver = Driver(feed)
    noise = random.Random(7)
    lost, counted_before, sent_before, failures = [], 0, 0, 0
    robot.start().wait_until_under_way()
    for number in range(arguments.kills + 1):
        time.sleep(noise.uniform(1.2, 4.0))
        driver.silent = True
        time.sleep(0.1)
        if number == arguments.kills:
            break
        status = robot.status()
        known = sum(one["received"] for one in status["sensors"].values()) + counted_before
        robot.send(signal.SIGKILL)
        robot.process.wait()
        feed.disconnect()
        robot.start()
        eventually(lambda: robot.socket.exists() and robot.status() != {})
        checkpointed = robot.status()
        kept = checkpointed.get("measurements", 0)
        lost.append((known - kept) / 55.0)
        failures += not checkpointed.get("started", False)
        counted_before = kept - sum(one["received"] for one in checkpointed["sensors"].values())
        feed.closed = False
        driver.silent = False
    _, report, text = end(robot, driver)
    lost.sort()
    row(f"{arguments.kills} × kill -9 at random times, checkpoints every {period:g} s",
        f"{arguments.kills - failures} of {arguments.kills} resumed; lost min / median / max {lost[0]:.2f} / {lost[len(lost) // 2]:.2f} / {lost[-1]:.2f} s of measurements; {text.split(', ')[0]}, "
        f"{text.split(', ')[-1]}")


def outputs_of_replay(arguments, folder, options=(), during=lambda robot: time.sleep(1)):
    robot = Waymark(arguments.waymark, folder, "", yaml=QUICKSTART, options=[
        "--set", "live.real_time=true", "--set", f"live.control={folder / 'ctl'}", "--set", "record={}", *options])
    robot.start().wait_until_under_way()
    during(robot)
    code, report = robot.stop()
    replay = subprocess.run([arguments.waymark, "run", str(robot.out / "flight.mcap"), "--out", str(folder / "replay"), "--quiet"],
                            capture_output=True, text=True)
    differ, names = same_files(robot.out, folder / "replay")
    dropped = sum(one["dropped"] for one in report["live"]["streams"])
    received = sum(one["received"] for one in report["live"]["streams"])
    return code, replay.returncode, differ, names, received, dropped


@case
def replay(arguments, folder):
    equal, received, names = 0, 0, []
    for number in range(arguments.runs):
        code, replayed, differ, names, count, _ = outputs_of_replay(
            arguments, folder / str(number), ["--set", f"source.seed={number}"], lambda robot: time.sleep(arguments.seconds))
        equal += code == 0 and replayed == 0 and not differ
        received += count
        if differ:
            print(f"run {number}: {differ} differ", file=sys.stderr)
    row(f"{arguments.runs} live runs of {arguments.seconds:g} s against their flight records replayed",
        f"{equal} of {arguments.runs} the same byte for byte ({', '.join(names)}), {received} measurements")


@case
def commands(arguments, folder):
    said = [("shadow", "gps"), ("set", "sensors.gps.sigma_m=0.5"), ("disable", "pillars"), ("set-pose", "5", "1", "10"), ("enable", "pillars"),
            ("enable", "gps"), ("set", "maps.pillars.noise.range_m=0.06"), ("save-maps",), ("checkpoint",)]

    def give(robot):
        for words in said:
            time.sleep(0.7)
            if robot.ctl(*words) is None:
                print(f"{words} is refused", file=sys.stderr)
        time.sleep(2)

    equal = 0
    for number in range(3):
        code, replayed, differ, _, _, _ = outputs_of_replay(arguments, folder / str(number), [], give)
        differ = [name for name in differ if not name.startswith("maps/")]  # saved by command
        equal += code == 0 and replayed == 0 and not differ
        if differ:
            print(f"run {number}: {differ} differ", file=sys.stderr)
    row("the same with commands: " + "; ".join(" ".join(words) for words in said), f"{equal} of 3 the same byte for byte")


@case
def overload(arguments, folder):
    options = ["--set", "filter.particles=1500", "--set", "filter.threads=1"]
    code, replayed, differ, _, received, dropped = outputs_of_replay(arguments, folder, options, lambda robot: time.sleep(15))
    row("too many particles for the machine", f"{received} received, {dropped} scans dropped; exit code {code}; replay: "
        f"{'the same byte for byte' if replayed == 0 and not differ else str(differ)}")


@case
def latency(arguments, folder):
    robot = Waymark(arguments.waymark, folder, "", yaml=QUICKSTART,
                    options=["--set", "live.real_time=true", "--set", f"live.control={folder / 'ctl'}", "--set", "record={}"])
    robot.start().wait_until_under_way()
    time.sleep(arguments.latency_seconds)
    load = os.getloadavg()[0]
    _, report = robot.stop()
    live = report["live"]

    def text(times):
        return " / ".join(f"{1e3 * times[key]:.2f}" for key in ("median", "p99", "max"))

    each = "; ".join(f"{one['sensor']} {text(one['latency_s'])} ms, {one['received']} received, {one['dropped']} dropped" for one in live["streams"])
    row(f"latency median / p99 / max over {arguments.latency_seconds:g} s (load of the machine {load:.1f})",
        f"pose now {text(live['front_latency_s'])} ms; {each}; {100 * live['cpu_share']:.0f} % of a core, all threads")


SIMULATED = QUICKSTART.with_name("live_ros2_robot.yaml")
ON_TOPICS = QUICKSTART.with_name("live_ros2.yaml")


def with_log(yaml, folder):
    """A copy of a robot with one more sink, which writes what its source delivers; without pictures, which would cost a lot."""
    folder.mkdir(parents=True, exist_ok=True)
    copy = folder / yaml.name
    copy.write_text(yaml.read_text() + "  - { plugin: log, leave_out: [camera] }\n")
    return copy


def stamps(folder, sensor):
    rows = (folder / "log" / f"{sensor}.csv").read_text().splitlines()[1:]
    return [int(row.split(",", 1)[0]) for row in rows]


@case
def ros2(arguments, folder):
    """A simulated robot in another process publishes all its sensors over DDS; waymark runs on them with both maps."""
    domain = 1 + os.getpid() % 199
    seconds = arguments.latency_seconds
    robot = Waymark(arguments.waymark, folder / "robot", "", yaml=with_log(SIMULATED, folder / "robot"), options=[
        "--set", f"sinks.ros2_publisher.domain={domain}", "--set", f"source.duration_s={seconds + 60:g}",
        "--set", f"live.control={folder / 'robot/ctl'}"])
    run = Waymark(arguments.waymark, folder / "run", "", yaml=with_log(ON_TOPICS, folder / "run"), options=[
        "--set", f"source.domain={domain}", "--set", f"sinks.ros2_publisher.domain={domain}", "--set", f"live.control={folder / 'run/ctl'}",
        "--set", "record={}"])
    run.start()  # it waits for /tf_static
    robot.start().wait_until_under_way()
    run.wait_until_under_way()
    time.sleep(seconds)
    load = os.getloadavg()[0]
    _, sent = robot.stop()
    time.sleep(1)
    code, report = run.stop()
    live = report["live"]

    def text(times):
        return " / ".join(f"{1e3 * times[key]:.2f}" for key in ("median", "p99", "max"))

    print("| sensor | received | of those published meanwhile, missing | dropped | arrival to the filter's pose: median / p99 / max [ms] |\n"
          "|---|---|---|---|---|", flush=True)
    for one in live["streams"]:
        missing = "not compared"
        if one["sensor"] != "camera":
            received = set(stamps(run.out, one["sensor"]))
            published = stamps(robot.out, one["sensor"])
            missing = sum(min(received) <= stamp <= max(received) and stamp not in received for stamp in published)
        print(f"| {one['sensor']} | {one['received']} | {missing} | {one['dropped']} | {text(one['latency_s'])} |", flush=True)
    lost = [event["text"] for event in report["run"]["events"] if "lost so far" in event["text"] or "bad message" in event["text"]
            or event["text"].endswith(" missing")]
    replayed = subprocess.run([arguments.waymark, "run", str(run.out / "flight.mcap"), "--out", str(folder / "replay"), "--quiet"],
                              capture_output=True, text=True)
    differ, names = same_files(run.out, folder / "replay")
    row(f"topics of ROS 2 over {live['duration_s']:.0f} s (load of the machine {load:.1f})",
        f"exit code {code}; pose now {text(live['front_latency_s'])} ms; CPU: waymark {100 * live['cpu_share']:.0f} %, the robot "
        f"{100 * sent['live']['cpu_share']:.0f} % of a core; events of lost or bad messages: {lost or 'none'}; replay: "
        f"{'the same byte for byte (' + ', '.join(names) + ')' if replayed.returncode == 0 and not differ else 'differs: ' + str(differ) + replayed.stderr}")


def looped(first, count, start, speed):
    """Lines of the measurements of that many steps of 20 ms, of a robot on a circle or one that stands."""
    lines = []
    for k in range(first, first + count):
        t = 0.02 * k
        stamp = int((start + t) * 1e9)
        if k % 11 == 10:
            lines.append(fix_line(stamp, *(circle(t) if speed else (0.0, 0.0))))
        else:
            lines.append(twist_line(stamp) if speed else twist_line(stamp).replace("1.0", "0.0").replace("0.1", "0.0"))
    return "".join(lines)


@case
def soak(arguments, folder):
    """Stamps end at the present, so that none lies ahead. The first ones come at once: the queue is full before memory is compared, since
    how full it becomes later depends on the machine. So does what waits at a moment: medians are compared."""
    for name, speed in (("standing", 0.0), ("driving circles", 1.0)):
        port = free_port()
        # The log is of the past: its stamps lie hours behind their arrival.
        robot = Waymark(arguments.waymark, folder / name[:5], f"plugin: json, from: tcp, port: {port}",
                        options=["--set", "clock.max_jump_s=1e8"])
        robot.start()
        eventually(lambda: robot.socket.exists())
        feed, memory = Tcp(port), []
        count = arguments.measurements
        start = time.time() - 0.02 * count - 10
        begin = time.monotonic()
        at_once = min(200_000, count // 10)
        feed(looped(0, at_once, start, speed))
        for first in range(at_once, count, 1000):
            feed(looped(first, min(1000, count - first), start, speed))
            if first % (count // 300) < 1000:
                memory.append((first, robot.resident_kb() / 1024))
        eventually(lambda: sum(one["received"] for one in robot.status()["sensors"].values()) >= count, 600)
        seconds = time.monotonic() - begin
        in_sixth = lambda sixth: statistics.median(mb for first, mb in memory if sixth - 1 <= 6 * first / count < sixth)
        at_third, at_end = in_sixth(3), in_sixth(6)
        code, report = robot.stop()
        streams = report["live"]["streams"]
        row(f"{count} measurements in a loop, {name}", f"{count / seconds:.0f} a second; memory {at_third:.1f} MB in the third sixth (median), {at_end:.1f} MB in the last: "
            f"{at_end - at_third:+.1f} MB; exit code {code}, {sum(one['dropped'] for one in streams)} dropped, "
            f"the queue was full {sum(one['waits'] for one in streams)} times")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", type=lambda text: pathlib.Path(text).resolve(), default="build/release/bin/waymark")
    parser.add_argument("--data", default=os.environ.get("WAYMARK_DATA", ""), help="folder of the recordings, for gpsd and serial")
    parser.add_argument("--case", choices=CASES, action="append", help="only this one; may be repeated")
    parser.add_argument("--kills", type=int, default=24)
    parser.add_argument("--runs", type=int, default=10, help="of `replay`")
    parser.add_argument("--seconds", type=float, default=20, help="length of each run of `replay`")
    parser.add_argument("--latency-seconds", type=float, default=120)
    parser.add_argument("--measurements", type=int, default=3_000_000)
    parser.add_argument("--inner-interface", help=argparse.SUPPRESS)
    parser.add_argument("--inner-topics", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.inner_interface:
        return interface_in_its_network(arguments, pathlib.Path(arguments.inner_interface))
    if arguments.inner_topics:
        return topics_in_their_network(arguments, pathlib.Path(arguments.inner_topics))
    folder = pathlib.Path(tempfile.mkdtemp(prefix="live_faults_"))
    print("| fault | what happened |\n|---|---|", flush=True)
    for name in arguments.case or CASES:
        (folder / name).mkdir()
        try:
            CASES[name](arguments, folder / name)
        except Exception as error:  # the other cases are worth their time
            row(name, f"THE CASE FAILED: {error!r}; its files are in {folder / name}")
            continue
        shutil.rmtree(folder / name, ignore_errors=True)


if __name__ == "__main__":
    main()
