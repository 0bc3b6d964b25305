# SPDX-License-Identifier: Apache-2.0
"""What the tests share: a short run of the quickstart, by the command and from Python."""
import pathlib
import subprocess

import waymark

ROOT = pathlib.Path(__file__).resolve().parents[2]
QUICKSTART = ROOT / "config" / "quickstart.yaml"
SHORT = {"source.duration_s": 40}


def run_command(config, out, settings, *more):
    """`waymark run`; returns what it printed."""
    command = [waymark.PROGRAM, "run", str(config), "--out", str(out), "--quiet", *more]
    for key, value in settings.items():
        command += ["--set", f"{key}={value}"]
    return subprocess.run(command, check=True, text=True, capture_output=True).stderr


def tum_lines(trajectory):
    """The rows as the sink `tum` writes them."""
    lines = []
    for row in trajectory:
        seconds, rest = divmod(int(row.stamp_ns), 10**9)
        lines.append(f"{seconds}.{rest:09d} " + " ".join(f"{v:.6f}" for v in row.position) + " " +
                     " ".join(f"{v:.9f}" for v in row.orientation))
    return lines


def rows_of(file):
    return [line for line in file.read_text().splitlines() if not line.startswith("#")]
