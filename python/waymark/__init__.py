# SPDX-License-Identifier: Apache-2.0
"""waymark in Python: run a robot from its YAML, step through it, feed it, read its results as NumPy arrays.

    import waymark
    result = waymark.run("config/quickstart.yaml", set={"filter.particles": 50}, seed=2, out="out/python")
    print(result.trajectory.position[-1], result.landmarks("pillars").position)

All arrays are copies, but for `Grid.cells`, which is handed over without one. The GIL is released while the filter works.
"""
from waymark._waymark import (FATES, PROGRAM, ConfigError, DataError, Error, PluginError, Snapshot, payloads)
from waymark._evaluation import Score, evaluate, score
from waymark._robot import Grid, Result, Robot, RunError, run

__all__ = ["FATES", "PROGRAM", "ConfigError", "DataError", "Error", "Grid", "PluginError", "Result", "Robot", "RunError", "Score",
           "Snapshot", "evaluate", "payloads", "run", "score"]
