#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Our MCAP writer and reader against the public conformance cases, byte for byte."""
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

import peers

cases_folder = peers.data_folder().parent / "conformance" / "mcap"
if not (cases_folder / "cases.json").is_file():
    peers.skip(f"there are no conformance cases in {cases_folder}")
cases = json.loads((cases_folder / "cases.json").read_text())
expected = {}
for line in (cases_folder / "sha256.tsv").read_text().splitlines()[1:]:
    name, digest, size = line.split("\t")
    expected[name] = (digest, int(size))

with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    run = subprocess.run([sys.argv[1], cases_folder / "cases.json", folder], capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(run.stderr or f"the program ended with {run.returncode}")
    counts = {"records": 0, "writer": 0, "read": 0}
    for name, case in cases.items():
        for way in ("records", "writer"):
            file = folder / way / f"{name}.mcap"
            if not file.exists() and way == "writer" and "pad" in case["meta"]["variant"]["features"]:
                continue
            content = file.read_bytes()
            if (hashlib.sha256(content).hexdigest(), len(content)) != expected[name]:
                sys.exit(f"{name}: {way} gives other bytes ({len(content)}, {expected[name][1]} are expected)")
            counts[way] += 1
        read = json.loads((folder / "read" / f"{name}.json").read_text())
        if read["records"] != case["records"]:
            sys.exit(f"{name}: the reader finds\n{read['records']}\nbut these were written:\n{case['records']}")
        messages = [dict(record["fields"]) for record in case["records"] if record["type"] == "Message"]
        messages = [[int(m["log_time"]), int(m["sequence"]), [int(b) for b in m["data"]]] for m in messages]
        if read["messages"] != sorted(messages, key=lambda m: m[0]):
            sys.exit(f"{name}: the indexed reader finds {read['messages']}")
        counts["read"] += 1
print(f"{counts['records']} cases are the same record by record, {counts['writer']} from the writer; {counts['read']} are read back")
