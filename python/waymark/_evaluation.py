# SPDX-License-Identifier: Apache-2.0
"""Scores: `score` of arrays, `evaluate` of a run's folder by the command."""
import dataclasses
import json
import os
import subprocess

import numpy as np

from waymark import _waymark


def wrap(angle):
    """An angle within (-π, π]."""
    return -((-np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi)


@dataclasses.dataclass(frozen=True)
class Score:
    """Errors of an estimate at the times of a reference. `error` is (n, 2) in the map [m], `yaw_error` (n) [rad], NaN where
    the reference has no yaw; `sigma` (n, 3) of x, y [m] and yaw [rad] as the estimate claims them, or None if it has no
    covariance. `transform` = (x, y, yaw): what was applied to the estimate (`align`). NEES: see `evaluate`."""
    stamp_ns: np.ndarray
    error: np.ndarray
    yaw_error: np.ndarray
    sigma: np.ndarray | None
    transform: tuple[float, float, float]

    @property
    def distance(self):
        """Length of the position's error [m]."""
        return np.hypot(*self.error.T)

    @property
    def rms_m(self):
        return float(np.sqrt(np.mean(self.distance**2)))

    @property
    def max_m(self):
        return float(self.distance.max())

    @property
    def yaw_rms_rad(self):
        known = self.yaw_error[np.isfinite(self.yaw_error)]
        return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")

    def __str__(self):
        return (f"position rms {self.rms_m:.4f} m, max {self.max_m:.4f} m; yaw rms {np.degrees(self.yaw_rms_rad):.4f} deg; "
                f"{len(self.stamp_ns)} points")


def _fit_se2(source, target):
    """Rotation and translation that take the points of `source` nearest to those of `target` (S. Umeyama, 1991, without
    scale, in the plane)."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    yaw = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    R = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    return yaw, R, target.mean(axis=0) - R @ source.mean(axis=0)


def score(estimate, reference, *, align="none", max_time_gap_s=1.0):
    """Scores `estimate` at the stamps of `reference`, both record arrays with stamp_ns, position and yaw (`trajectory`,
    `path`, `reference`). Between the estimate's rows it interpolates, over at most `max_time_gap_s`. align: "none" or
    "se2". The position is scored in the plane. Raises waymark.Error if they have no time in common."""
    if align not in ("none", "se2"):
        raise ValueError(f"align={align!r}; expected \"none\" or \"se2\"")
    times, first = np.unique(estimate["stamp_ns"], return_index=True)
    rows = estimate[first]
    wanted = reference["stamp_ns"]
    if len(times) == 0 or len(wanted) == 0:
        raise _waymark.Error("nothing to score: the estimate or the reference is empty")
    after = np.clip(np.searchsorted(times, wanted), 0, len(times) - 1)
    before = np.where(times[after] == wanted, after, np.maximum(after - 1, 0))
    span = times[after] - times[before]
    scored = (times[0] <= wanted) & (wanted <= times[-1]) & (span <= max_time_gap_s * 1e9)
    if not scored.any():
        raise _waymark.Error(f"no common time within {max_time_gap_s} s")
    before, after, span, truth = before[scored], after[scored], span[scored], reference[scored]
    share = np.where(span > 0, (truth["stamp_ns"] - times[before]) / np.maximum(span, 1), 0.0)
    position = rows["position"][before, :2]
    position = position + share[:, None] * (rows["position"][after, :2] - position)
    yaw = rows["yaw"][before] + share * wrap(rows["yaw"][after] - rows["yaw"][before])
    turn, R, shift = 0.0, np.eye(2), np.zeros(2)
    if align == "se2":
        turn, R, shift = _fit_se2(position, truth["position"][:, :2])
    error = position @ R.T + shift - truth["position"][:, :2]
    yaw_error = wrap(yaw + turn - truth["yaw"])
    sigma = None
    if "covariance" in (estimate.dtype.names or ()):
        T = np.eye(3)
        T[:2, :2] = R
        sigma = np.sqrt(np.diagonal(T @ rows["covariance"][before] @ T.T, axis1=1, axis2=2))
    return Score(truth["stamp_ns"], error, yaw_error, sigma, (float(shift[0]), float(shift[1]), float(turn)))


def evaluate(out, *options):
    """The scores of a run's folder, as `waymark evaluate OUT --json` prints them: a dictionary. More options of the command
    may follow: evaluate("out/run", "--align", "se2")."""
    done = subprocess.run([_waymark.PROGRAM, "evaluate", os.fspath(out), "--json", *map(str, options)], text=True,
                          capture_output=True)
    if done.returncode != 0:
        raise _waymark.Error(done.stderr.strip())
    return json.loads(done.stdout)
