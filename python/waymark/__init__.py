# SPDX-License-Identifier: Apache-2.0
"""waymark in Python: run a robot from its YAML, step through it, feed it, read its results as NumPy arrays.

    import waymark
    result = waymark.run("config/quickstart.yaml", set={"filter.particles": 50}, seed=2, out="out/python")
    print(result.trajectory.position[-1], result.landmarks("pillars").position)

A running robot is a `waymark.Live`. All arrays are copies, but for `Grid.cells`, which is handed over without one. The GIL is released while the filter works.
"""
from waymark._waymark import (FATES, PROGRAM, Config, ConfigError, DataError, Error, PluginError, Prediction, Snapshot, State,
                              Updates, payloads)
from waymark._evaluation import Score, evaluate, score
from waymark._robot import Grid, Result, Robot, RunError, run
from waymark._live import Live
from waymark._contract import check_map_module, check_sensor
from waymark._sensors import MapModule, NumericalUpdate, ParticleMap, Sensor, Update, map_module, sensor

__all__ = ["FATES", "PROGRAM", "Config", "ConfigError", "DataError", "Error", "Grid", "Live", "MapModule", "NumericalUpdate",
           "ParticleMap", "PluginError", "Prediction", "Result", "Robot", "RunError", "Score", "Sensor", "Snapshot", "State",
           "Update", "Updates", "check_map_module", "check_sensor", "evaluate", "map_module", "payloads", "run", "score", "sensor"]

for _public in __all__:
    if isinstance(globals()[_public], type):
        globals()[_public].__module__ = "waymark"
