# SPDX-License-Identifier: Apache-2.0
"""Sensors and map modules written in Python: the base classes, the register, and updates with numerical Jacobians."""
import copy

import numpy as np

_REGISTERED = {"sensor": {}, "map_module": {}}


def registered(kind, name):
    return _REGISTERED[kind].get(name)


def names(kind):
    return ", ".join(sorted(_REGISTERED[kind])) or "none"


class Sensor:
    """Base class of a sensor in Python. Its constructor takes the entry of the YAML (`Config`) and reads its keys; the
    mounting, if the YAML gives one, is in `self.T_base_sensor` (4, 4). `process` is called for every measurement, on one
    thread, in order of stamps. The object is copied with copy.deepcopy, for rollbacks."""
    payload = ""  #: the payload that it takes, such as "GnssFix"; of another, DataError is raised before `process`. "": any
    is_motion_source = False  #: measures the motion; a robot needs one such sensor
    is_absolute = False  #: ties the robot to the map or the Earth
    observes_roll_and_pitch = False
    #: the sensor's own states: dict(name="offset_m", initial=0, initial_sigma=1, walk_per_sqrt_s=0.01), or tau_s and
    #: stationary_sigma
    block = ()
    T_base_sensor = None

    def __init__(self, config):
        pass

    def process(self, measurement, prediction, out):
        """Adds updates with `out.add`. `measurement` has stamp_ns, arrival_ns, type and the fields of its payload. Raise
        waymark.DataError if it is unusable; any other exception takes the sensor out of service."""
        raise NotImplementedError

    def start_hint(self, measurement):
        """What this measurement says about the start pose: None, or a dictionary with position, base_point, sigma_m, yaw_rad,
        yaw_sigma_rad."""
        return None

    # outcome(self, update, innovation, S, nis, accepted), if it is defined, receives the result of each update.

    def save(self):
        """The sensor's own state on a checkpoint, as bytes."""
        return b""

    def load(self, state):
        """Reads what `save` wrote; it may be damaged."""


def _register(kind, base, name):
    def register(cls):
        if not issubclass(cls, base):
            raise TypeError(f"{cls.__name__} is no waymark.{base.__name__}")
        _REGISTERED[kind][name] = cls
        return cls
    return register


def sensor(name):
    """Registers a class as `plugin: python_sensor, class: NAME` of a YAML. A second class of the name replaces the first."""
    return _register("sensor", Sensor, name)


def map_module(name):
    """Registers a class as `plugin: python_map, class: NAME` of a YAML. A second class of the name replaces the first."""
    return _register("map_module", MapModule, name)


class Update:
    """Base class of an update: `linearize(state)` returns a dictionary with residual (z - h) and R (a variance, one for each
    row, or the matrix), and the Jacobians of h that are not zero: position, attitude (rows, 3; map frame), velocity,
    angular_rate (rows, 3; base frame), block (rows, own states). It is called for every particle and from many threads, so it
    must not change anything. `state` has position, R (rotation base to map), yaw, velocity, angular_rate, block."""
    observes = "other"  #: or position, attitude, velocity, height

    def linearize(self, state):
        raise NotImplementedError


class NumericalUpdate(Update):
    """An update of z = h(state) + noise whose Jacobians are central differences: for trying a model before its derivatives
    are written. `angles`: rows that are angles [rad]. Costs two calls of h for each error state (12 and the block)."""
    _STEP = 1e-6

    def __init__(self, z, h, R, *, observes="other", angles=()):
        self.z, self.h, self.R, self.observes = np.atleast_1d(np.asarray(z, dtype=float)), h, R, observes
        self.angles = list(angles)

    def _difference(self, a, b):
        d = np.atleast_1d(np.asarray(a, dtype=float) - np.asarray(b, dtype=float))
        d[self.angles] = -((-d[self.angles] + np.pi) % (2 * np.pi) - np.pi)
        return d

    def linearize(self, state):
        size = 12 + len(state.block)
        H = np.empty((len(self.z), size))
        for i, step in enumerate(np.eye(size) * self._STEP):
            H[:, i] = self._difference(self.h(state.moved(step)), self.h(state.moved(-step))) / (2 * self._STEP)
        model = dict(residual=self._difference(self.z, self.h(state)), R=self.R, position=H[:, 0:3], attitude=H[:, 3:6],
                     velocity=H[:, 6:9], angular_rate=H[:, 9:12])
        if size > 12:
            model["block"] = H[:, 12:]
        return model


class MapModule:
    """Base class of a map module in Python: one object for all particles. Its constructor takes the entry of the YAML; the
    mounting of the first input is in `self.T_base_sensor` (4, 4)."""
    payload = ""  #: the payload of its first input, such as "LaserScan"; another raises DataError before `extract`. "": any
    T_base_sensor = None

    def __init__(self, config):
        pass

    def create_map(self):
        """The initial map of a particle, a ParticleMap."""
        raise NotImplementedError

    def extract(self, measurement, companions, motion):
        """Turns a measurement into an observation, any object, which all particles read; None: it is not used. `companions`:
        measurements of the other inputs by name, None where there is no recent one; `motion`: a State with the mean pose
        and twist."""
        raise NotImplementedError

    def load_map(self, state):
        """A map from what `ParticleMap.save` wrote."""
        raise NotImplementedError("load_map: this map has no checkpoints")


class ParticleMap:
    """Base class of one particle's map."""

    def refine(self, pose, P, start, observation):
        """Matches an observation at the prior: `pose` (State) with the covariance P of (x, y, yaw); `start`: a draw from it,
        for a search. Returns None (no information) or a dictionary: information (3, 3), gradient (3), log_evidence, and if
        needed writes, failed, searched, slip (3, 3), association. Called for every particle and from many threads: it changes
        nothing."""
        raise NotImplementedError

    def insert(self, pose, P, observation, association):
        """Writes the observation into this map, at the sampled pose with the covariance that sampling kept."""
        raise NotImplementedError

    def clone(self):
        """A copy that shares nothing that `insert` changes."""
        return copy.deepcopy(self)

    def landmarks(self):
        """Landmarks as dictionaries: id, position (2), covariance (2, 2), radius_m, existence, sightings, confirmed."""
        return ()

    def figures(self):
        return {}

    def grid(self):
        """The map from above as a waymark.Grid, or None."""
        return None

    def save(self):
        """The map on a checkpoint, as bytes."""
        raise NotImplementedError("save: this map has no checkpoints")
