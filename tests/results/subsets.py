#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether the filter without maps is as good as it says with some of the sensors, on the simulator (config/faults.yaml without a
fault): NEES of (x, y, yaw), averaged over many runs at each time step, against its two-sided 95 % χ² band. The average is over
the runs, so one call makes all of them; the first has the source's seed --seed.

Example:
  tests/results/subsets.py --sensors wheels,gps --runs 50 --out out/subsets
"""
import bisect
import math
import statistics

from one_run import ROOT, heading_of, parser_of, print_scores, rows_of, run

SENSORS = ("wheels", "imu", "gps", "compass")
STEP = 1.0  # s
OVAL = [(round(20 + 16 * math.sin(math.tau * k / 36), 2), round(12.5 - 8.5 * math.cos(math.tau * k / 36), 2)) for k in range(36)]


def on_oval():
    """The settings of a course without corners: at these the rate jumps, which the process noise would have to allow at any time."""
    (x0, y0), (x1, y1) = OVAL[:2]
    return {"source.course.waypoints_m": "[" + ", ".join(f"{x}, {y}" for x, y in OVAL) + "]", "initial.x_m": x0, "initial.y_m": y0,
            "initial.yaw_deg": math.degrees(math.atan2(y1 - y0, x1 - x0)), "motion.rate_noise_radps_per_sqrt_s": "[0.1, 0.1, 0.1]"}


def turned(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


def nees(e, P):
    """eᵀ P⁻¹ e by Cholesky's factor of P (xx, xy, xyaw, yy, yyaw, yawyaw)."""
    xx, xy, xw, yy, yw, ww = P
    a = math.sqrt(xx)
    b, c = xy / a, xw / a
    d = math.sqrt(yy - b * b)
    f = (yw - b * c) / d
    g = math.sqrt(ww - c * c - f * f)
    z1 = e[0] / a
    z2 = (e[1] - b * z1) / d
    z3 = (e[2] - c * z1 - f * z2) / g
    return z1 * z1 + z2 * z2 + z3 * z3


def without(subset):
    """The settings that leave only these sensors."""
    settings = {f"sensors.{s}.enabled": "false" for s in SENSORS if s not in subset}
    if "wheels" not in subset:
        settings["sensors.imu.reports_standstill"] = "false"
        settings["sensors.gps.sideslip_sigma_mps"] = 0.02  # the simulator's lateral slip from fix to fix
    return settings


def one(options, subset, seed):
    """NEES at each step, and the RMS of the position."""
    settings = {"initial.position_sigma_m": 0.001, "initial.yaw_sigma_deg": 0.01, **without(subset), **on_oval(), "source.seed": seed}
    out = options.out / str(seed)
    run(options, ROOT / "config/faults.yaml", out, *(f"{key}={value}" for key, value in settings.items()), more=["--seed", str(seed)])
    truth = rows_of(out / "reference.txt")
    times = [row[0] for row in truth]
    estimate = {row[0]: row for row in rows_of(out / "trajectory.txt")}
    steps, errors, due = [], [], STEP
    for t, *P in rows_of(out / "covariance.csv"):
        if t < due:
            continue
        due += STEP
        k = bisect.bisect_right(times, t)
        if not 0 < k < len(times):
            break
        share = (t - times[k - 1]) / (times[k] - times[k - 1])
        a, b = truth[k - 1], truth[k]
        x, y = (estimate[t][i] - a[i] - share * (b[i] - a[i]) for i in (1, 2))
        yaw = turned(heading_of(estimate[t]) - heading_of(a) - share * turned(heading_of(b) - heading_of(a)))
        steps.append(nees((x, y, yaw), P))
        errors.append(x * x + y * y)
    return steps, math.sqrt(statistics.fmean(errors))


def band(dof, runs):
    """Two-sided 95 % of χ²(dof · runs) / runs, after Wilson and Hilferty (1931)."""
    n = dof * runs
    return [n * (1 - 2 / (9 * n) + z * math.sqrt(2 / (9 * n))) ** 3 / runs for z in (-1.959964, 1.959964)]


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--sensors", required=True, help="comma-separated")
    parser.add_argument("--runs", type=int, default=50)
    options = parser.parse_args()
    runs = [one(options, options.sensors.split(","), options.seed + k) for k in range(options.runs)]
    low, high = band(3, options.runs)
    means = [statistics.fmean(step) for step in zip(*(steps for steps, _ in runs))]
    errors = [rms for _, rms in runs]
    below, above = (100 * sum(is_out) / len(means) for is_out in ([m < low for m in means], [m > high for m in means]))
    print_scores({"rms_min_m": min(errors), "rms_median_m": statistics.median(errors), "rms_max_m": max(errors), "nees": statistics.fmean(means),
                  "below_percent": below, "in_percent": 100 - below - above, "above_percent": above, "band_low": low, "band_high": high})


if __name__ == "__main__":
    main()
