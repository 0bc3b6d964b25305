#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Our messages of ROS against the definitions and the serialization of npm packages, by Node.

usage: compare_ros_definitions.py PRINT_ROS_MESSAGES FOLDER
FOLDER keeps the packages. Without Node, or if the packages cannot be fetched, the comparison is skipped, but not in CI (environment
variable CI).
"""
import os
import pathlib
import shutil
import subprocess
import sys

from peers import skip

HERE = pathlib.Path(__file__).resolve().parent / "ros_definitions"


def skip_unless_ci(reason):
    if os.environ.get("CI"):
        sys.exit(reason)
    skip(reason)


program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
if not shutil.which("node") or not shutil.which("npm"):
    skip_unless_ci("there is no Node.js with npm")
folder.mkdir(parents=True, exist_ok=True)
for name in ("package.json", "package-lock.json", "compare.cjs"):
    shutil.copy(HERE / name, folder / name)
if not (folder / "node_modules/@foxglove/rosmsg2-serialization").exists():
    fetched = subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=folder, capture_output=True, text=True)
    if fetched.returncode != 0:
        skip_unless_ci("the packages cannot be fetched: " + fetched.stderr.strip().splitlines()[-1])
messages = subprocess.run([program], capture_output=True, check=True)
sys.exit(subprocess.run(["node", "compare.cjs"], cwd=folder, input=messages.stdout).returncode)
