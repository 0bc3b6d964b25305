# SPDX-License-Identifier: Apache-2.0
"""Cases of live_faults.py: faults of connections, devices, clocks and lines."""
import os
import pathlib
import pty
import random
import signal
import socket
import subprocess
import time
import tty

from live_cases import case, row, tcp_robot, end, in_own_network, interrupt, receiver_robot, set_loopback
from live_robot import Driver, Tcp, Waymark, counted, eventually, free_port, stream, twist_line


@case
def disconnect(arguments, folder):
    robot, driver, feed = tcp_robot(arguments, folder)
    _, seen, text = interrupt(robot, driver, feed.disconnect, 5, feed.reconnect)
    row("source disconnects for 5 s and returns", f"{seen}; {text}")


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
def interface(arguments, folder):
    in_own_network(arguments, folder, "--inner-interface")


def interface_in_its_network(arguments, folder):
    set_loopback("up")
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
    _, seen, text = interrupt(robot, driver, lambda: set_loopback("down"), 5, lambda: set_loopback("up"))
    row("network interface down for 5 s, and up", f"{seen}; {text}")
