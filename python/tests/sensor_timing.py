#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""CPU time of an update by a sensor in Python: the ranges of test_sensors.py, one particle, with Jacobians that are written and
with numerical ones; the time of the same robot without the sensor is subtracted."""
import argparse
import time

import numpy as np

import test_sensors
import waymark


def times(cls, enabled, rounds):
    """µs per stamp with three ranges."""
    out = []
    for _ in range(rounds):
        stamps, _, ranges = test_sensors.circle()
        robot = waymark.Robot(yaml=test_sensors.yaml(cls), set={"sensors.radio.enabled": enabled})
        robot.feed("wheels", stamps, v_x_mps=1.1, w_z_radps=0.2)
        if enabled:
            robot.feed("radio", stamps, beacon=np.tile(np.arange(3), (len(stamps), 1)), range_m=ranges)
        begin = time.process_time()
        robot.play()
        out.append(1e6 * (time.process_time() - begin) / len(stamps))
    return np.array(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=10)
    rounds = parser.parse_args().rounds
    without = np.median(times("test_ranges", False, rounds))
    print(f"CPU time, µs per update, min / median / max of {rounds} rounds")
    for what, cls in (("written Jacobians", "test_ranges"), ("numerical Jacobians", "test_numerical_ranges")):
        each = (times(cls, True, rounds) - without) / 3
        print(f"{what:20} {each.min():.0f} / {np.median(each):.0f} / {each.max():.0f}")


if __name__ == "__main__":
    main()
