# SPDX-License-Identifier: Apache-2.0
"""The contract kit on sensors and map modules that are written in Python."""
import json

import numpy as np

from waymark import _waymark


def check_sensor(name, entry, stamps_ns, *, motion="spatial", payload="", **columns):
    """Runs the contract kit on a class that `waymark.sensor(name)` registered. Returns what it does against the contract, one
    sentence each; an empty list is good.

    entry       its keys in the YAML, as a dictionary
    stamps_ns   int64 nanoseconds of some 10 to 1000 measurements in order, as a robot in motion gives them
    motion      "spatial" or "planar"
    payload, columns   as for `Robot.feed`

    Checked are the keys, the Jacobians against central differences, R, that `linearize` changes nothing and is the same from
    several threads, copies, `save` and `load`, values that are not finite, and foreign payloads.
    """
    return _waymark._check_sensor(json.dumps({"name": "sensor", "class": name, **entry}), motion, stamps_ns, payload, columns)


def check_map_module(name, entry, stamps_ns, poses, *, payload="", T_base_sensor=None, **columns):
    """Runs the contract kit on a class that `waymark.map_module(name)` registered. Returns what it does against the contract,
    one sentence each; an empty list is good.

    entry       its keys in the YAML, as a dictionary, with `inputs`
    stamps_ns   int64 nanoseconds of some 10 to 100 measurements of the first input, in order
    poses       where the robot was: (n, 3) of x [m], y [m] and yaw [rad]
    T_base_sensor   mounting of the first input (4, 4), if the module needs it
    payload, columns   as for `Robot.feed`

    Checked are the keys, that `extract` and `refine` are deterministic and change nothing, information and evidence, clones,
    `save` and `load`, empty maps, and foreign payloads.
    """
    return _waymark._check_map_module(json.dumps({"class": name, **entry}), T_base_sensor, np.asarray(poses, dtype=float),
                                      stamps_ns, payload, columns)
