#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Faults injected into running robots, as a table of what happened. Outside of CI: it takes about an hour.

A robot drives a circle at 1 m/s and sends wheels (50 Hz) and fixes (5 Hz) as JSON; waymark runs on them as it would on a robot. The
position is compared with the circle. `replay`, `commands` and `latency` run config/quickstart.yaml in real time instead (LIDAR,
landmarks, 25 particles). `disk` mounts a tmpfs and `interface` uses a network of its own: both need root.

Example:
  tests/results/live_faults.py --waymark build/release/bin/waymark --data "$WAYMARK_DATA"
  tests/results/live_faults.py --case kills --kills 24
"""
import argparse
import os
import pathlib
import pty
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import tty

from live_robot import Driver, Tcp, Waymark, circle, counted, eventually, fix_line, free_port, same_files, stream, twist_line

QUICKSTART = pathlib.Path(__file__).resolve().parents[2] / "config/quickstart.yaml"
CASES = {}


def case(function):
    CASES[function.__name__] = function
    return function


def row(name, what):
    print(f"| {name} | {what} |", flush=True)


def tcp_robot(arguments, folder, more="", options=()):
    port = free_port()
    robot = Waymark(arguments.waymark, folder, f"plugin: json, from: tcp, port: {port}", more, options)
    robot.start()
    feed = Tcp(port)
    driver = Driver(feed)
    robot.wait_until_under_way()
    return robot, driver, feed


def count_text(report, driver):
    received = sum(one["received"] for one in report["live"]["streams"])
    dropped = sum(one["dropped"] for one in report["live"]["streams"])
    return f"{driver.sent} sent, {received} received, {dropped} dropped"


def end(robot, driver):
    driver.stop()
    time.sleep(0.5)
    code, report = robot.stop()
    return code, report, f"exit code {code}, {count_text(report, driver)}, {robot.error_m(driver):.2f} m off at the end"


@case
def disconnect(arguments, folder):
    robot, driver, feed = tcp_robot(arguments, folder)
    time.sleep(3)
    feed.disconnect()
    time.sleep(5)
    away = robot.status()
    feed.closed = False
    back = eventually(lambda: robot.status().get("health") == "ok", 30)
    time.sleep(3)
    _, _, text = end(robot, driver)
    row("source disconnects for 5 s and returns", f"meanwhile {away['health']} ({away['reason']}); then {'ok' if back else 'not ok'}; {text}")


def receiver_robot(arguments, folder, receiver, more=""):
    """A robot whose wheels come as JSON over UDP, and whose fixes come from a recorded receiver."""
    port = free_port(socket.SOCK_DGRAM)
    folder.mkdir(parents=True, exist_ok=True)
    yaml = folder / "robot.yaml"
    yaml.write_text(f"""
sources:
  - {{ plugin: json, from: udp, port: {port}, channels: [{{ sensor: wheels, payload: BodyTwist }}] }}
  - {{ {receiver}, gnss: {{ sensor: gps }} }}
initial: {{ x_m: 0, y_m: 0, yaw_deg: 0 }}
sensors:
  - {{ name: wheels, plugin: odometry, model: twist }}
  - {{ name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 2 }}
{more}
live: {{ control: {folder / 'ctl'} }}
sinks: [{{ plugin: tum }}, {{ plugin: diagnostics }}]
""")
    robot = Waymark(arguments.waymark, folder, "", yaml=yaml).start()
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    driver = Driver(lambda line: '"wheels"' in line and sender.sendto(line.encode(), ("127.0.0.1", port)) > 0)
    return robot.wait_until_under_way(), driver


def fixes(robot):
    return robot.status().get("sensors", {}).get("gps", {}).get("received", 0)


def connection_events(report):
    events = [event["text"] for event in report["run"]["events"]]
    return ", ".join(word for word in ("connected", "lost", "restored") if any(word in event for event in events))


def recorded_sentences(arguments):
    log = pathlib.Path(arguments.data) / "nmea_receivers/ublox-zed-f9p-nmea.nmea"
    return log, log.read_bytes().splitlines(keepends=True)


@case
def gpsd(arguments, folder):
    port = free_port()
    robot, driver = receiver_robot(arguments, folder, f"plugin: gpsd, port: {port}")
    log, _ = recorded_sentences(arguments)
    counts = [0]
    for _ in range(2):
        server = subprocess.Popen(["gpsfake", "-c", "0.02", "-q", "-P", str(port), str(log)], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL, start_new_session=True)
        eventually(lambda: fixes(robot) > counts[-1] + 5, 40)
        os.killpg(server.pid, signal.SIGKILL)
        server.wait()
        time.sleep(2)
        counts.append(fixes(robot))
    driver.stop()
    code, report = robot.stop()
    row("gpsd killed and started again", f"{counts[1]} fixes before, {counts[2] - counts[1]} after; events: {connection_events(report)}; exit code {code}")


@case
def serial(arguments, folder):
    _, lines = recorded_sentences(arguments)
    link = folder / "receiver"
    robot, driver = receiver_robot(arguments, folder, f"plugin: nmea, device: {link}, baud: 115200")
    counts, at = [0], 0
    for _ in range(2):
        master, slave = pty.openpty()
        tty.setraw(slave)
        link.unlink(missing_ok=True)
        link.symlink_to(os.ttyname(slave))
        limit = time.monotonic() + 30
        while time.monotonic() < limit and fixes(robot) < counts[-1] + 10:
            for _ in range(20):
                os.write(master, lines[at % len(lines)])
                at += 1
            time.sleep(0.1)
        os.close(slave)
        os.close(master)  # unplugged
        time.sleep(2)
        counts.append(fixes(robot))
    driver.stop()
    code, report = robot.stop()
    row("serial port (pty) closed and opened anew", f"{counts[1]} fixes before, {counts[2] - counts[1]} after; events: {connection_events(report)}; exit code {code}")


@case
def clock_steps(arguments, folder):
    for name, sensors in (("all clocks", ("wheels", "gps")), ("the clock of the GPS", ("gps",))):
        for hours in (1, -1):
            robot, driver, _ = tcp_robot(arguments, folder / f"{len(sensors)}{hours}")
            time.sleep(5)
            for sensor in sensors:
                driver.clock_error_s[sensor] = 3600.0 * hours
            time.sleep(5)
            status = robot.status()
            for sensor in sensors:
                driver.clock_error_s[sensor] = 0.0
            time.sleep(5)
            _, report, text = end(robot, driver)
            steps = sum("was set" in event["text"] for event in report["run"]["events"])
            mistimed = sum(one["mistimed"] + one["late"] for one in report["sensors"])
            row(f"{name} {'forward' if hours > 0 else 'back'} by 1 h, 5 s later back again",
                f"{status['health']} after 5 s; {steps} steps reported, {mistimed} measurements refused until they were sure; {text}")


@case
def two_clocks(arguments, folder):
    for offset in (0.3, -0.3):
        for corrected in (False, True):
            options = ["--set", f"sensors.gps.delay_s={offset}"] if corrected else []
            port = free_port()
            robot = Waymark(arguments.waymark, folder / f"{offset}{corrected}", f"plugin: json, from: tcp, port: {port}", "", options)
            robot.start()
            driver = Driver(Tcp(port))
            driver.clock_error_s["gps"] = offset
            robot.wait_until_under_way()
            time.sleep(12)
            _, report, text = end(robot, driver)
            gap = stream(report, "gps")["clock_offset_s"] - stream(report, "wheels")["clock_offset_s"]
            gps = counted(report, "gps")
            row(f"the GPS's clock is {abs(offset)} s {'fast' if offset > 0 else 'slow'}{', delay_s set' if corrected else ''}",
                f"offset reported {gap:+.3f} s; {gps['fused']} fixes fused, {gps['gated']} gated, {gps['mistimed']} mistimed; {text}")


@case
def stall(arguments, folder):
    robot, driver, _ = tcp_robot(arguments, folder)
    time.sleep(3)
    robot.send(signal.SIGSTOP)
    time.sleep(10)
    robot.send(signal.SIGCONT)
    back = eventually(lambda: robot.status().get("health") == "ok", 30)
    time.sleep(3)
    _, report, text = end(robot, driver)
    steps = sum("was set" in event["text"] for event in report["run"]["events"])
    row("stopped for 10 s (SIGSTOP)", f"{'ok' if back else 'not ok'} afterwards, {steps} steps of clocks reported; {text}")


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
def rubbish(arguments, folder):
    noise = random.Random(1)
    good = twist_line(10 ** 18)

    def line():
        kind = noise.randrange(4)
        if kind == 0:
            return bytes(noise.randrange(256) for _ in range(noise.randrange(200))) + b"\n"
        if kind == 1:
            return (good[:noise.randrange(len(good))] + "\n").encode()
        if kind == 2:
            return b"[" * 5000 + b"\n"
        return (good.replace("1", noise.choice(["1e999", "null", '"x"', "{}"]))).encode()

    robot, driver, _ = tcp_robot(arguments, folder / "json")
    driver.rubbish = line
    before = robot.resident_kb()
    time.sleep(15)
    grown = robot.resident_kb() - before
    _, report, text = end(robot, driver)
    row("every second line is malformed JSON", f"{report['run']['bad_record_count']} bad lines counted, memory {grown / 1024:+.1f} MB; {text}")

    _, lines = recorded_sentences(arguments)
    master, slave = pty.openpty()
    tty.setraw(slave)
    robot, driver = receiver_robot(arguments, folder / "nmea", f"plugin: nmea, device: {os.ttyname(slave)}")
    broken = 0
    for text in lines:
        if noise.random() < 0.5:
            text = bytearray(text)
            text[noise.randrange(len(text))] = noise.randrange(256)
            broken += 1
        os.write(master, bytes(text))
        time.sleep(0.005)
    time.sleep(1)
    driver.stop()
    code, report = robot.stop()
    row("every second sentence of NMEA is damaged", f"{broken} of {len(lines)} damaged, {report['run']['bad_record_count']} bad records "
        f"counted, {stream(report, 'gps')['received']} fixes delivered; exit code {code}")
    os.close(master)
    os.close(slave)


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


SIMULATED = QUICKSTART.with_name("ros2_simulated_robot.yaml")
ON_TOPICS = QUICKSTART.with_name("ros2.yaml")


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
    lost = [event["text"] for event in report["run"]["events"] if "lost so far" in event["text"] or "bad message" in event["text"]]
    replayed = subprocess.run([arguments.waymark, "run", str(run.out / "flight.mcap"), "--out", str(folder / "replay"), "--quiet"],
                              capture_output=True, text=True)
    differ, names = same_files(run.out, folder / "replay")
    row(f"topics of ROS 2 over {live['duration_s']:.0f} s (load of the machine {load:.1f})",
        f"exit code {code}; pose now {text(live['front_latency_s'])} ms; CPU: waymark {100 * live['cpu_share']:.0f} %, the robot "
        f"{100 * sent['live']['cpu_share']:.0f} % of a core; events of lost or bad messages: {lost or 'none'}; replay: "
        f"{'the same byte for byte (' + ', '.join(names) + ')' if replayed.returncode == 0 and not differ else 'differs: ' + str(differ) + replayed.stderr}")


@case
def soak(arguments, folder):
    """Stamps end at the present, so that none lies ahead."""
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
        for first in range(0, count, 1000):
            lines = []
            for k in range(first, min(first + 1000, count)):
                t = 0.02 * k
                stamp = int((start + t) * 1e9)
                if k % 11 == 10:
                    lines.append(fix_line(stamp, *(circle(t) if speed else (0.0, 0.0))))
                else:
                    lines.append(twist_line(stamp) if speed else twist_line(stamp).replace("1.0", "0.0").replace("0.1", "0.0"))
            feed("".join(lines))
            if first % (count // 30) < 1000:
                memory.append(robot.resident_kb() / 1024)
        eventually(lambda: sum(one["received"] for one in robot.status()["sensors"].values()) >= count, 600)
        seconds = time.monotonic() - begin
        memory.append(robot.resident_kb() / 1024)
        third = len(memory) // 3
        code, report = robot.stop()
        row(f"{count} measurements in a loop, {name}", f"{count / seconds:.0f} a second; memory {memory[third]:.1f} MB after a third, {memory[-1]:.1f} MB at the end: "
            f"{memory[-1] - memory[third]:+.1f} MB; exit code {code}, {sum(one['dropped'] for one in report['live']['streams'])} dropped")


@case
def interface(arguments, folder):
    inner = [sys.executable, __file__, "--waymark", str(arguments.waymark), "--inner-interface", str(folder)]
    subprocess.run(["unshare", "-n", *inner], check=True)


def interface_in_its_network(arguments, folder):
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    port = free_port(socket.SOCK_DGRAM)
    robot = Waymark(arguments.waymark, folder, f"plugin: json, from: udp, port: {port}").start()
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send(line):
        try:
            return sender.sendto(line.encode(), ("127.0.0.1", port)) > 0
        except OSError:
            return False

    driver = Driver(send)
    robot.wait_until_under_way()
    time.sleep(3)
    subprocess.run(["ip", "link", "set", "lo", "down"], check=True)
    time.sleep(5)
    away = robot.status()
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    back = eventually(lambda: robot.status().get("health") == "ok", 30)
    time.sleep(3)
    _, _, text = end(robot, driver)
    row("network interface down for 5 s, and up", f"meanwhile {away['health']} ({away['reason']}); then {'ok' if back else 'not ok'}; {text}")


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
    arguments = parser.parse_args()
    if arguments.inner_interface:
        return interface_in_its_network(arguments, pathlib.Path(arguments.inner_interface))
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
