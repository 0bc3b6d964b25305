# SPDX-License-Identifier: Apache-2.0
"""What the comparisons have in common: our side's lines, and their comparison with the peer's."""
import fcntl
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77


def skip(reason):
    print("skipped:", reason)
    sys.exit(SKIPPED)


def data_folder():
    folder = os.environ.get("WAYMARK_DATA")
    if not folder:
        skip("WAYMARK_DATA is not set")
    return pathlib.Path(folder)


def ours(program, yaml):
    """The measurements of a source as lists [sensor, type, arrival, stamp, value…], and the bad records."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "run.yaml"
        file.write_text(yaml)
        run = subprocess.run([program, str(file)], capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"{run.stderr}\nfor\n{yaml}")
    lines = run.stdout.splitlines()
    bad = [line[4:] for line in lines if line.startswith("bad ")]
    rows = []
    for line in lines:
        if line.startswith("bad "):
            continue
        sensor, kind, arrival, stamp, *values = line.split()
        rows.append([sensor, kind, int(arrival), int(stamp)] + values)
    return rows, bad


def close(a, b, tolerance):
    if isinstance(a, str) and isinstance(b, str):
        return a == b
    a, b = float(a), float(b)
    if math.isnan(a) or math.isnan(b):
        return math.isnan(a) and math.isnan(b)
    return a == b or abs(a - b) <= tolerance * max(abs(a), abs(b), 1e-300)


def compare(name, our_rows, peer_rows, tolerance=0.0):
    """Ends the program at the first difference. `tolerance` is relative."""
    for number, (a, b) in enumerate(zip(our_rows, peer_rows)):
        same = len(a) == len(b) and a[:4] == b[:4] and all(close(x, y, tolerance) for x, y in zip(a[4:], b[4:]))
        if not same:
            sys.exit(f"{name}: measurement {number} differs\n  ours {a}\n  peer {b}")
    if len(our_rows) != len(peer_rows):
        sys.exit(f"{name}: {len(our_rows)} measurements, but the peer has {len(peer_rows)}")
    print(f"{name}: {len(our_rows)} measurements are the same")


def node_packages(folder):
    """The folder with our scripts in JavaScript and what they need, made in `folder` when it is missing or old."""
    if not shutil.which("npm") or not shutil.which("node"):
        skip("npm is not installed")
    ours = pathlib.Path(__file__).resolve().parent / "node"
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "lock", "w") as lock:  # tests run side by side
        fcntl.flock(lock, fcntl.LOCK_EX)
        locked = folder / "package-lock.json"
        complete = folder / "complete"
        same = complete.exists() and locked.read_bytes() == (ours / "package-lock.json").read_bytes()
        for file in ours.iterdir():
            shutil.copy(file, folder)
        if not same:
            complete.unlink(missing_ok=True)
            run = subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=folder, capture_output=True, text=True)
            if run.returncode != 0:
                sys.exit(f"npm ci failed: {run.stderr}")
            complete.touch()
    return folder
