#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Our messages of ROS against the definitions and the serialization of npm packages: compare_ros_definitions.py PRINT_ROS_MESSAGES
FOLDER. FOLDER is for the packages."""
import pathlib
import subprocess
import sys

import peers

node = peers.node_packages(pathlib.Path(sys.argv[2]))
messages = subprocess.run([sys.argv[1]], capture_output=True, check=True)
sys.exit(subprocess.run(["node", node / "compare_ros_definitions.mjs"], input=messages.stdout).returncode)
