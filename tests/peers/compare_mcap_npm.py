#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A flight record of ours, read by @mcap/core: compare_mcap_npm.py WAYMARK FOLDER. FOLDER is for the packages."""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import peers

waymark, packages = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
root = pathlib.Path(__file__).resolve().parents[2]
node = peers.node_packages(packages)

with tempfile.TemporaryDirectory() as folder:
    for compression in ("zstd", "lz4", "none"):
        out = pathlib.Path(folder) / compression
        command = [waymark, "run", root / "config/quickstart.yaml", "--out", out, "--quiet",
                   "--set", "source.duration_s=5", "--set", f"record={{compression: {compression}}}",
                   "--set", "sinks=[{plugin: log}]"]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode != 0:
            sys.exit(run.stderr)
        read = subprocess.run(["node", node / "read_mcap.mjs", out / "flight.mcap"], capture_output=True, text=True)
        if read.returncode != 0:
            sys.exit(f"{compression}: {read.stderr}")
        found = json.loads(read.stdout)
        if found["topics"] != found["streamed"]:
            sys.exit(f"{compression}: by the index {found['topics']}, as a stream {found['streamed']}")
        if "config.yaml" not in found["attachments"]:
            sys.exit(f"{compression}: no config.yaml among the attachments {found['attachments']}")
        # The log sink wrote the same measurements as text.
        rows = (out / "log/wheels.csv").read_text().splitlines()
        names, values = rows[0].split(","), rows[-1].split(",")
        if found["topics"]["/waymark/wheels"] != len(rows) - 1:
            sys.exit(f"{compression}: {found['topics']['/waymark/wheels']} messages of the wheels, {len(rows) - 1} rows")
        last = found["last"]["/waymark/wheels"]
        for name, text in zip(names[2:], values[2:]):
            value = float(text) if text else math.nan
            theirs = last[name] if last[name] is not None else math.nan
            if theirs != value and not (math.isnan(theirs) and math.isnan(value)):
                sys.exit(f"{compression}: {name} of the wheels' last message is {theirs}, not {value}")
        print(f"{compression}: {sum(found['topics'].values())} messages of {len(found['topics'])} topics")
