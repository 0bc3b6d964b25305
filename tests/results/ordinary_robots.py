#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""README's "log of your own, in ten lines" on random ordinary robots: wheels and GPS, and nothing given but geometry.

Each robot has wheels with scale errors of up to 3 % each, a track that is up to 5 % wrong, an antenna off the axle, a
receiver of some class with white and slowly varying errors, and wheels that slip now and then. It drives legs, curves and
turns in place, some of them in reverse, and stands in between. The robot is that of the seed, or so many after it (--after).

Example:
  tests/results/ordinary_robots.py --seed 3 --after 100 --out out/robot_103
  tests/results/ordinary_robots.py --seed 2819 --oracle --no-slips --out out/robot_2819
"""
import csv
import math
import random
import statistics

from one_run import parser_of, print_scores, run

STEP = 0.02  # s, of the truth
RATES = (10, 25, 50)  # Hz, of the wheels: whole numbers of steps
# White part, slow part [m] and time constant of that [s], each drawn between two bounds.
CLASSES = {
    "single": ((0.3, 0.6), (0.6, 1.2), (30.0, 120.0)),
    "differential": ((0.15, 0.3), (0.3, 0.6), (30.0, 120.0)),
    "rtk_float": ((0.05, 0.15), (0.1, 0.25), (30.0, 120.0)),
    "rtk_fixed": ((0.01, 0.02), (0.01, 0.03), (30.0, 120.0)),
}
DATUM = (50.1, 8.3)  # °, somewhere
A, E2 = 6378137.0, 6.69437999014e-3  # WGS-84


def geodetic(east, north):
    """Of a place within some hundred metres of the datum; exact to a millimetre there."""
    latitude = math.radians(DATUM[0])
    w = 1.0 - E2 * math.sin(latitude) ** 2
    meridian, parallel = A * (1.0 - E2) / w**1.5, A / math.sqrt(w) * math.cos(latitude)
    # Second order: the meridian's convergence and the curvature of the parallel.
    mean = latitude + 0.5 * north / meridian
    parallel = A / math.sqrt(1.0 - E2 * math.sin(mean) ** 2) * math.cos(latitude + north / meridian)
    bend = 0.5 * east * east * math.tan(latitude) / (A / math.sqrt(w)) / meridian
    return DATUM[0] + math.degrees(north / meridian - bend), DATUM[1] + math.degrees(east / parallel)


class Robot:
    """A robot and its drive, out of one seed."""

    def __init__(self, seed):
        draw = self.draw = random.Random(f"ordinary {seed}")
        self.track = draw.uniform(0.3, 1.0)
        self.true_track = self.track * (1.0 + draw.uniform(-0.05, 0.05))
        self.scale = [1.0 + draw.uniform(-0.03, 0.03) for _ in range(2)]
        self.arm = (round(draw.uniform(-0.5, 0.5), 2), round(draw.uniform(-0.3, 0.3), 2))
        self.receiver = draw.choice(list(CLASSES))
        self.white, self.slow, self.tau = (draw.uniform(*bounds) for bounds in CLASSES[self.receiver])
        self.wheel_rate, self.gps_rate = draw.choice(RATES), draw.choice((1, 5))
        self.wheel_noise = draw.uniform(0.005, 0.02)  # m/√s, of each wheel
        self.states_type = draw.random() < 0.5  # each fix states its type; otherwise the YAML gives the receiver
        self.speed = draw.uniform(0.4, 2.0)
        self.duration = draw.uniform(240.0, 480.0)
        self.straight_only = draw.random() < 0.3
        self.slips = [(draw.uniform(20.0, self.duration - 5.0), draw.uniform(0.5, 2.0), draw.choice((0, 1, 2)), draw.uniform(0.2, 0.5))
                      for _ in range(draw.randrange(4))]

    def be_plain(self):
        """Straight legs with one wheel 2 % off and a usual receiver: the robot of which a user complained."""
        self.track = self.true_track = 0.5
        self.scale, self.arm = [1.0, 1.02], (0.0, 0.0)
        self.receiver, self.white, self.slow, self.tau = "single", 0.4, 0.8, 60.0
        self.straight_only, self.slips, self.states_type = True, [], False

    def commands(self):
        """(duration, v, ω) of one manoeuvre after the other."""
        draw = self.draw
        yield draw.uniform(0.0, 5.0), 0.0, 0.0
        while True:
            sign = -1.0 if draw.random() < 0.15 else 1.0
            v = sign * self.speed * draw.uniform(0.6, 1.0)
            yield draw.uniform(8.0, 30.0) / abs(v), v, 0.0
            kind = draw.random()
            angle = math.radians(draw.uniform(30.0, 180.0)) * draw.choice((-1.0, 1.0))
            if self.straight_only or kind < 0.4:  # turn in place
                angle = math.copysign(math.radians(90.0), angle) if self.straight_only else angle
                yield abs(angle) / 0.8, 0.0, math.copysign(0.8, angle)
            elif kind < 0.9:  # curve
                radius = draw.uniform(1.0, 6.0)
                yield abs(angle) * radius / abs(v), v, math.copysign(abs(v) / radius, angle)
            else:
                yield draw.uniform(2.0, 10.0), 0.0, 0.0

    def drive(self):
        """Truth: (t, x, y, yaw, v, ω) at every step. Speeds change at 1 m/s² and 2 rad/s²."""
        x, y, yaw, v, w, t = 0.0, 0.0, self.draw.uniform(-math.pi, math.pi), 0.0, 0.0, 0.0
        truth = []
        for length, to_v, to_w in self.commands():
            until = t + length
            while t < until - 1e-9:
                truth.append((t, x, y, yaw, v, w))
                v += max(-STEP, min(STEP, to_v - v))
                w += max(-2.0 * STEP, min(2.0 * STEP, to_w - w))
                yaw += 0.5 * w * STEP
                x, y = x + v * STEP * math.cos(yaw), y + v * STEP * math.sin(yaw)
                yaw += 0.5 * w * STEP
                t = len(truth) * STEP
                if t > self.duration:
                    return truth

    def wheels(self, truth):
        rows = []
        for k in range(0, len(truth), round(1.0 / STEP / self.wheel_rate)):
            t, _, _, _, v, w = truth[k]
            speeds = [v - 0.5 * w * self.true_track, v + 0.5 * w * self.true_track]
            for side in range(2):
                for begin, length, which, ratio in self.slips:
                    if begin <= t < begin + length and which in (side, 2):
                        speeds[side] *= 1.0 + ratio
                if v != 0.0 or w != 0.0:
                    speeds[side] = speeds[side] * self.scale[side] + self.draw.gauss(0.0, self.wheel_noise * math.sqrt(self.wheel_rate))
            rows.append((t, *speeds))
        return rows

    def fixes(self, truth):
        """(t, east, north), and the error of each."""
        rows, errors = [], []
        slow = [self.draw.gauss(0.0, self.slow) for _ in range(2)]
        decay = math.exp(-1.0 / self.gps_rate / self.tau)
        for k in range(0, len(truth), round(1.0 / STEP / self.gps_rate)):
            t, x, y, yaw, _, _ = truth[k]
            error = [part + self.draw.gauss(0.0, self.white) for part in slow]
            slow = [decay * part + self.draw.gauss(0.0, self.slow * math.sqrt(1.0 - decay * decay)) for part in slow]
            east = x + self.arm[0] * math.cos(yaw) - self.arm[1] * math.sin(yaw)
            north = y + self.arm[0] * math.sin(yaw) + self.arm[1] * math.cos(yaw)
            rows.append((t, east + error[0], north + error[1]))
            errors.append(math.hypot(*error))
        return rows, errors


def write(robot, folder, sigma, oracle=False):
    truth = robot.drive()
    fixes, errors = robot.fixes(truth)
    scale = robot.scale if oracle else (1.0, 1.0)
    with open(folder / "wheels.csv", "w") as out:
        out.write("t,left,right\n" + "".join(f"{t:.3f},{left / scale[0]:.5f},{right / scale[1]:.5f}\n" for t, left, right in robot.wheels(truth)))
    typed = robot.states_type and not oracle
    with open(folder / "gps.csv", "w") as out:
        out.write("t,lat,lon" + (",type" if typed else "") + "\n")
        for t, east, north in fixes:
            latitude, longitude = geodetic(east, north)
            out.write(f"{t:.3f},{latitude:.10f},{longitude:.10f}" + (f",{list(CLASSES).index(robot.receiver)}" if typed else "") + "\n")
    words = ", ".join(f"{k}: {word}" for k, word in enumerate(CLASSES))
    type_column = f", type: {{ column: type, map: {{ {words} }} }}" if typed else ""
    receiver = "" if typed or robot.receiver == "single" else f", receiver: {robot.receiver}"
    if sigma:
        receiver, type_column = f", sigma_m: {math.hypot(robot.white, robot.slow):.3f}", ""
    track = robot.track
    known = ""
    if oracle:
        receiver = f", sigma_m: {robot.white}, offset_sigma_m: {robot.slow}, offset_tau_s: {robot.tau}"
        track, noise = robot.true_track, robot.wheel_noise
        known = (f", speed_scale_sigma: 0, curvature_sigma_per_m: 0, yaw_scale_sigma: 0, lateral_noise_m_per_sqrt_s: [0, 0.002]"
                 f", speed_noise_m_per_sqrt_s: [{noise / math.sqrt(2.0):.5f}, 0], yaw_noise_rad_per_sqrt_s: [{noise * math.sqrt(2.0) / track:.5f}, 0, 0]")
    (folder / "robot.yaml").write_text(f"""source:
  plugin: csv
  files:
    - {{ path: wheels.csv, sensor: wheels, payload: WheelSpeeds, time: t, columns: {{ left_mps: left, right_mps: right }} }}
    - {{ path: gps.csv, sensor: gps, payload: GnssFix, time: t, columns: {{ latitude_deg: lat, longitude_deg: lon{type_column} }} }}
sensors:
  - {{ name: wheels, plugin: odometry, model: differential, track_m: {track}{known} }}
  - {{ name: gps, plugin: dgps, base_p_antenna_m: [{robot.arm[0]}, {robot.arm[1]}, 0.5]{receiver} }}
sinks: [{{ plugin: tum }}, {{ plugin: diagnostics }}]
""")
    return truth, fixes, errors


def score(folder, truth, origin):
    """RMS and mean NEES (x, y) of a run, and the error of the first heading in degrees."""
    poses = [tuple(map(float, line.split())) for line in open(folder / "out/trajectory.txt") if not line.startswith("#")]
    with open(folder / "out/covariance.csv") as lines:
        rows = [line for line in lines if not line.startswith("#")]
    covariances = {float(row[0]): tuple(map(float, row[1:])) for row in csv.reader(rows) if row and row[0][0].isdigit()}
    squares, nees, heading = [], [], None
    for t, x, y, _, _, _, qz, qw in poses:
        true = truth[min(round(t / STEP), len(truth) - 1)]
        ex, ey = x + origin[0] - true[1], y + origin[1] - true[2]
        squares.append(ex * ex + ey * ey)
        if heading is None:
            heading = math.degrees(math.remainder(2.0 * math.atan2(qz, qw) - true[3], 2.0 * math.pi))
        if t in covariances:
            xx, xy, _, yy = covariances[t][:4]
            determinant = xx * yy - xy * xy
            nees.append((yy * ex * ex - 2.0 * xy * ex * ey + xx * ey * ey) / determinant if determinant > 0 else math.inf)
    return math.sqrt(statistics.fmean(squares)), statistics.fmean(nees), heading


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--after", type=int, default=0, metavar="N", help="the robot of seed + N")
    parser.add_argument("--plain", action="store_true", help="straight legs, one wheel 2 %% off, a receiver of 0.4 m white and 0.8 m slow")
    parser.add_argument("--sigma", action="store_true", help="the YAML gives the receiver's whole error as sigma_m, and no class")
    parser.add_argument("--oracle", action="store_true", help="all values and noises are given, as they are; what is left are the slips")
    parser.add_argument("--no-slips", action="store_true", help="the same robots and drives, and wheels that do not slip")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    robot = Robot(options.after + options.seed)
    if options.plain:
        robot.be_plain()
    if options.no_slips:
        robot.slips = []
    truth, fixes, errors = write(robot, options.out, options.sigma, options.oracle)
    code = run(options, options.out / "robot.yaml", options.out / "out")
    rms, nees, heading = score(options.out, truth, fixes[0][1:])
    alone = math.sqrt(statistics.fmean(error * error for error in errors))
    print_scores({"gps_alone_m": alone, "rms_m": rms, "ratio": rms / alone, "is_above_mark": rms > 1.5 * alone, "nees": nees,
                  "first_heading_deg": heading, "lost": code == 4})


if __name__ == "__main__":
    main()
