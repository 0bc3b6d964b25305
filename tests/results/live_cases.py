# SPDX-License-Identifier: Apache-2.0
"""What the cases of live_faults.py have in common: their list, robots on JSON, the end of a run."""
import pathlib
import socket
import subprocess
import sys
import time

from live_robot import Driver, Tcp, Waymark, eventually, free_port

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


def interrupt(robot, driver, begin, seconds, over, look=True):
    """A fault that `begin` causes and `over` ends. Returns the report, what was seen meanwhile (unless the robot cannot be asked then:
    `look`) and afterwards, and the text of the end."""
    time.sleep(3)
    begin()
    time.sleep(seconds)
    away = robot.status() if look else None
    over()
    back = "ok" if eventually(lambda: robot.status().get("health") == "ok", 30) else "not ok"
    time.sleep(3)
    _, report, text = end(robot, driver)
    return report, f"meanwhile {away['health']} ({away['reason']}); then {back}" if look else f"{back} afterwards", text


def set_loopback(*words):
    subprocess.run(["ip", "link", "set", "lo", *words], check=True)


def in_own_network(arguments, folder, option):
    """Runs live_faults.py with this option and the folder in a network of its own."""
    inner = [sys.executable, pathlib.Path(__file__).with_name("live_faults.py"), "--waymark", str(arguments.waymark), option, str(folder)]
    subprocess.run(["unshare", "-n", *inner], check=True)


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
