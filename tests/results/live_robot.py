# SPDX-License-Identifier: Apache-2.0
"""What live_faults.py needs: a robot that drives and sends its measurements as JSON, and a waymark that runs on them."""
import json
import math
import pathlib
import re
import signal
import socket
import subprocess
import threading
import time

ROBOT = """
source: {{ {source}, channels: {channels} }}
initial: {{ x_m: 0, y_m: 0, yaw_deg: 0, yaw_sigma_deg: 2 }}
datum: {{ latitude_deg: 49, longitude_deg: 8, height_m: 0 }}
motion: {{ kind: planar }}
sensors:
  - {{ name: wheels, plugin: odometry, model: twist }}
  - {{ name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.3 }}
filter: {{ max_latency_s: 0.1 }}
live: {{ control: {control} }}
sinks: [{{ plugin: tum }}, {{ plugin: diagnostics }}]
{more}
"""
OF_JSON = "[{ sensor: wheels, payload: BodyTwist }, { sensor: gps, payload: GnssFix }]"
METRES_PER_DEGREE = (111_229.0, 73_172.0)  # of latitude and longitude at 49° north
DATA_OF_REPORT = '<script id="data" type="application/json">'
SPEED, RATE = 1.0, 0.1                     # m/s and rad/s: a circle of 10 m radius


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def eventually(is_true, limit=60.0):
    end = time.monotonic() + limit
    while time.monotonic() < end:
        if is_true():
            return True
        time.sleep(0.02)
    return False


def circle(t):
    return 10.0 * math.sin(RATE * t), 10.0 * (1.0 - math.cos(RATE * t))


def twist_line(stamp_ns):
    return f'{{"sensor":"wheels","stamp_ns":{stamp_ns},"v_x_mps":{SPEED},"v_y_mps":0,"w_z_radps":{RATE}}}\n'


def fix_line(stamp_ns, east, north):
    return (f'{{"sensor":"gps","stamp_ns":{stamp_ns},"latitude_deg":{49 + north / METRES_PER_DEGREE[0]:.9f},'
            f'"longitude_deg":{8 + east / METRES_PER_DEGREE[1]:.9f},"type":"single"}}\n')


class Driver:
    """A robot on a circle: 50 messages of its wheels and 5 fixes a second, through `send`, which returns False if a line was not
    taken. What its fields say may be changed at any time."""

    def __init__(self, send, clock_error_s=None):
        self.send = send
        self.clock_error_s = {"wheels": 0.0, "gps": 0.0} | (clock_error_s or {})
        self.rubbish = None          # a function that gives a line of it, between all others
        self.silent = False
        self.sent = 0
        self.start = time.time()
        self.ends = False
        self.thread = threading.Thread(target=self.drive, daemon=True)
        self.thread.start()

    def drive(self):
        begin = time.monotonic()
        k = 0
        while not self.ends:
            t = time.time() - self.start
            if not self.silent:
                self.say("wheels", twist_line, t)
                if k % 10 == 0:
                    self.say("gps", lambda stamp: fix_line(stamp, *circle(t)), t)
                if self.rubbish:
                    self.send(self.rubbish())
            k += 1
            time.sleep(max(0.0, begin + 0.02 * k - time.monotonic()))

    def say(self, sensor, line, t):
        stamp = int((self.start + t + self.clock_error_s[sensor]) * 1e9)
        if self.send(line(stamp)):
            self.sent += 1

    def stop(self):
        self.ends = True
        self.thread.join()


class Tcp:
    """Lines to a TCP port; tries again while nobody listens."""

    def __init__(self, port):
        self.port, self.connection, self.closed = port, None, False

    def __call__(self, line):
        if self.closed:
            return False
        try:
            if self.connection is None:
                self.connection = socket.create_connection(("127.0.0.1", self.port), timeout=30)
            self.connection.sendall(line.encode() if isinstance(line, str) else line)
            return True
        except OSError:
            self.connection = None
            return False

    def disconnect(self):
        self.closed = True
        if self.connection:
            self.connection.close()
        self.connection = None

    def reconnect(self):
        self.closed = False


class Waymark:
    """A live run in a folder of its own."""

    def __init__(self, program, folder, source, more="", options=(), yaml=None, channels=OF_JSON):
        self.program, self.folder = program, pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.out = self.folder / "out"
        self.socket = self.folder / "ctl"
        self.yaml = yaml
        if yaml is None:
            self.yaml = self.folder / "robot.yaml"
            self.yaml.write_text(ROBOT.format(source=source, channels=channels, control=self.socket, more=more))
        self.options = list(options)
        self.process = None

    def start(self, *more, wrap=()):
        self.log = open(self.folder / "messages", "a")
        self.process = subprocess.Popen([*wrap, str(self.program), "run", str(self.yaml), "--out", str(self.out), "--quiet",
                                         *self.options, *more], stderr=self.log, stdout=self.log, stdin=subprocess.DEVNULL)
        return self

    def ctl(self, *words):
        answer = subprocess.run([str(self.program), "ctl", str(self.socket), *words], capture_output=True, text=True)
        return answer.stdout.strip() if answer.returncode == 0 else None

    def status(self):
        text = self.ctl("status")
        return json.loads(text) if text else {}

    def is_under_way(self):
        return self.status().get("started", False)

    def wait_until_under_way(self):
        if not eventually(self.is_under_way):
            raise SystemExit(f"{self.folder}: the filter does not start:\n{self.messages()}")
        return self

    def send(self, number):
        self.process.send_signal(number)

    def stop(self):
        """Ends it as systemd would. Returns the exit code and the report."""
        self.send(signal.SIGTERM)
        try:
            code = self.process.wait(timeout=120)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = "hangs"
        return code, self.report()

    def report(self):
        try:
            return json.loads((self.out / "diagnostics.json").read_text())
        except OSError:
            return None

    def messages(self):
        return (self.folder / "messages").read_text()

    def resident_kb(self):
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS"):
                return int(line.split()[1])
        return None

    def error_m(self, driver):
        """Distance of the last line of the trajectory from the circle's point of that time."""
        rows = [line for line in (self.out / "trajectory.txt").read_text().splitlines() if not line.startswith("#")]
        stamp, x, y = (float(field) for field in rows[-1].split()[:3])
        east, north = circle(stamp - driver.start)
        return math.hypot(x - east, y - north)


def stream(report, sensor):
    return next(one for one in report["live"]["streams"] if one["sensor"] == sensor)


def counted(report, sensor):
    return next(one for one in report["sensors"] if one["name"] == sensor)


# Files with the configuration, which names the source; with latencies; and the list of files with their sizes.
OF_THE_RUN_ITSELF = ("diagnostics.json", "config.yaml", "replay.yaml", "flight.mcap", "live.ckpt", ".waymark_files")
OF_A_CONNECTION = re.compile(r": (connected|lost|restored|not reached)\b|^nothing has arrived for |^measurements arrive again ")


def content(file):
    """The bytes of a file; of a report its data without the configuration, the latencies, and the events of connections, which a log
    has none of."""
    if file.name != "report.html":
        return file.read_bytes()
    page = file.read_text()
    begin = page.index(DATA_OF_REPORT) + len(DATA_OF_REPORT)
    data = json.loads(page[begin:page.index("</script>", begin)])
    for key in ("name", "config", "live"):
        data.pop(key, None)
    data["events"] = [event for event in data["events"]["first"] if not OF_A_CONNECTION.search(event["text"])]
    return data


def same_files(one, other, left_out=OF_THE_RUN_ITSELF):
    """Names of files that two runs wrote and that differ; a list of names of both."""
    one, other = pathlib.Path(one), pathlib.Path(other)
    names = {path.relative_to(folder) for folder in (one, other) for path in folder.rglob("*") if path.is_file() and path.name not in left_out}
    differ = [str(name) for name in sorted(names)
              if not (one / name).exists() or not (other / name).exists() or content(one / name) != content(other / name)]
    return differ, sorted(str(name) for name in names)
