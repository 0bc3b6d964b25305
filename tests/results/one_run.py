# SPDX-License-Identifier: Apache-2.0
"""What the programs of the plans have in common: their options, and the calls of waymark.

A plan of `waymark sweep` calls such a program once for each seed; it ends by `print_scores`.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def parser_of(doc):
    """The options that all of them have."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--waymark", default=str(ROOT / "build/release/bin/waymark"))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for logs and results")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="passed to waymark run")
    return parser


def run(options, config, out, *settings, more=()):
    """Runs a configuration. Its exit code is 0, or 4 for lost; with any other one the program ends."""
    command = [options.waymark, "run", str(config), "--quiet", "--out", str(out), *more]
    for setting in (*settings, *options.set):
        command += ["--set", setting]
    ended = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    if ended.returncode not in (0, 4):
        sys.exit(f"{config}: exit code {ended.returncode}: {' '.join(ended.stderr.strip().splitlines()[-1:])}")
    return ended.returncode


def evaluate(options, *words):
    """The JSON of `waymark evaluate`."""
    command = [options.waymark, "evaluate", "--json", *map(str, words)]
    ended = subprocess.run(command, capture_output=True, text=True)
    if ended.returncode != 0:
        sys.exit(ended.stderr)
    return json.loads(ended.stdout)


def rows_of(file):
    """The numbers of the lines of a file that begin with one."""
    with open(file) as lines:
        return [[float(word) for word in line.replace(",", " ").split()] for line in lines if line[0] in "-0123456789"]


def heading_of(row):
    """Of a row of trajectory.txt [rad]."""
    qx, qy, qz, qw = row[4:8]
    return math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))


def states_of(changes):
    """Times and states of the health of the whole; it begins with ok."""
    whole = [(change["t_s"], change["state"]) for change in changes if change["of"] == "all"]
    return [-math.inf, *(t for t, _ in whole)], ["ok", *(state for _, state in whole)]


def print_scores(scores):
    """One line of JSON; what is not finite is left out."""
    def finite(value):
        if isinstance(value, dict):
            return {key: finite(part) for key, part in value.items()}
        if isinstance(value, bool):
            return int(value)
        return None if isinstance(value, float) and not math.isfinite(value) else value
    print(json.dumps(finite(scores)))
