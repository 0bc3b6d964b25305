# SPDX-License-Identifier: Apache-2.0
"""Robot, Result and run: the native robot with arguments and results as Python has them."""
import dataclasses
import json
import os
import pathlib

import numpy as np

from waymark import _waymark


class RunError(_waymark.Error):
    """A run ended, but not well: an error in the log, a plugin out of service, a filter that did not start. What there is
    of its results is in `result`."""

    def __init__(self, failures, result):
        super().__init__("; ".join(failures))
        self.result = result


@dataclasses.dataclass(frozen=True)
class Grid:
    """A dense map from above. `cells[i, j]` is row i from below, column j from the left: probability of being occupied
    in percent, 255 where unknown. `position` and `yaw` are the pose of its lower left corner in the map [m, rad]."""
    cells: np.ndarray
    resolution_m: float
    position: np.ndarray
    yaw: float

    UNKNOWN = 255

    @property
    def probability(self):
        """Probability of being occupied, 0 to 1, NaN where unknown (a copy)."""
        return np.where(self.cells == self.UNKNOWN, np.nan, self.cells / 100.0)

    @property
    def extent(self):
        """(left, right, bottom, top) [m] of a grid that is not turned, as `imshow` takes it."""
        height, width = self.cells.shape
        x, y = self.position[:2]
        return x, x + width * self.resolution_m, y, y + height * self.resolution_m


def _records(array):
    return array.view(np.recarray)


def _overrides(settings, seed, threads):
    def plain(value):
        if isinstance(value, os.PathLike):
            return os.fspath(value)
        return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value

    lines = [f"{key}={json.dumps(value, default=plain)}" for key, value in (settings or {}).items()]
    if seed is not None:
        lines.append(f"filter.seed={int(seed)}")
    if threads is not None:
        lines.append(f"filter.threads={int(threads)}")
    return lines


def _plugin_folders():
    here = pathlib.Path(_waymark.__file__).resolve().parent
    beside = here.parents[2] / "waymark" / "plugins"  # PREFIX/lib/python3/dist-packages/waymark
    installed = beside if beside.is_dir() else pathlib.Path(_waymark.PLUGIN_FOLDER)
    return [here / "plugins", installed]


class _Maps:
    """What `Robot` and `Result` show of the maps of the particle with the highest weight, by the map's name."""

    def _one_map(self, name):
        names = self.map_names
        if name is None and len(names) != 1:
            raise _waymark.Error(f"name one of the maps: {', '.join(names)}" if names else "the robot has no map")
        return names[0] if name is None else name


def _options(path, yaml, set, out, seed, threads, until_s, record, name, allow_outside):
    """The arguments of a robot, as the native one takes them."""
    if (path is None) == (yaml is None):
        raise TypeError("give either the path of a YAML, or its text as yaml=")
    return dict(config="" if path is None else os.fspath(path), yaml=yaml or "", overrides=_overrides(set, seed, threads),
                out=None if out is None else os.fspath(out), name=name, until_s=until_s, record=record,
                allow_outside=allow_outside, plugin_folders=_plugin_folders())


class Robot(_Maps):
    """A robot with one run of it.

    path      the YAML, or a flight record ("flight.mcap"), which is replayed; or give the text of a YAML as `yaml`
    set       keys of the YAML by their dotted path, {"filter.particles": 100}, as `waymark run --set`
    out       folder for the files of the sinks; None: no sink writes
    seed, threads   the same as set={"filter.seed": …, "filter.threads": …}
    until_s   the log is read this long after its first arrival [s]
    feed      True: the program feeds the measurements, `source:` is ignored; None: if the YAML has no source
    record    False: `trajectory` is not kept

    One thread uses a robot at a time. Errors of the YAML are ConfigError, of the log DataError, all waymark.Error.
    """

    def __init__(self, path=None, *, yaml=None, set=None, out=None, seed=None, threads=None, until_s=None, feed=None,
                 record=True, name="", allow_outside=False):
        self._native = _waymark.Robot(
            feed=feed, **_options(path, yaml, set, out, seed, threads, until_s, record, name, allow_outside))
        self.out = None if out is None else pathlib.Path(out)

    @classmethod
    def _of(cls, native, out):
        robot = cls.__new__(cls)
        robot._native, robot.out = native, out
        return robot

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        self._native._finish()

    # --- running -----------------------------------------------------------------------------------------------------
    def step(self):
        """Reads on to the next snapshot, and returns it. None at the end of the log, or of what was fed."""
        return self._native._step()

    def __iter__(self):
        """All snapshots to the end of the log; then the run is finished. A robot that is fed is not finished: it may be
        fed on."""
        while (snapshot := self._native._step()) is not None:
            yield snapshot
        if self.is_fed:
            return
        self._native._finish()
        while (snapshot := self._native._step()) is not None:
            yield snapshot

    def play(self):
        """Reads the log, or what was fed, to its end."""
        self._native._play()
        return self

    def finish(self, check=True):
        """Commits what is buffered, ends the sinks, and returns the Result. Raises RunError if the run did not end well,
        unless `check` is False."""
        self._native._finish()
        return Result._of(self, check)

    def suspend(self, checkpoint, check=True):
        """Ends the run here with a checkpoint, as `waymark run --save`; buffered measurements are not committed. Returns the
        Result up to here."""
        self._native._suspend(os.fspath(checkpoint))
        return Result._of(self, check)

    def resume(self, checkpoint):
        """Goes on from a checkpoint of the same configuration and log, before anything else was read. A robot that is fed
        must have been fed the measurements of the first part again. `trajectory` has the rows from here on."""
        self._native._resume(os.fspath(checkpoint))
        return self

    def feed(self, sensor, stamps_ns, *, payload="", arrivals_ns=None, **columns):
        """Adds measurements of one sensor: a block (arrays), or a single one (numbers). Returns how many.

        stamps_ns     int64 nanoseconds, when each was valid
        arrivals_ns   when each became available; without it, the stamps. Must not decrease
        payload       "WheelSpeeds", or one that a plugin registers, "example/Range@1"; without it, the one payload that has these
                      fields (waymark.payloads())
        columns       the payload's fields: one value each, or one for all. Lists, such as ranges_m, are two-dimensional
                      arrays or lists of arrays. Fields of lists of elements (LandmarkObservations, Ranges) are given so,
                      too: range_m=[[3.1, 4.0], [3.2]]

        The values are copied. They are processed by `step`, `play` or a loop over the robot, in order of arrival over
        all sensors; so feed every sensor up to a time before you process that time. DataError names the row that is
        invalid; nothing of that block is added then. The newest measurement is committed with the next one, or at the end
        (`front` contains it).
        """
        if np.ndim(stamps_ns) == 0:
            columns = {name: value if isinstance(value, str) or (np.ndim(value) == 0 and not isinstance(value, bytes))
                       else [value] for name, value in columns.items()}
        return self._native._feed(sensor, stamps_ns, arrivals_ns, payload, columns)

    def front(self, at_ns):
        """The belief at a time from the committed one on: the buffered measurements are applied, and it is predicted."""
        return self._native._front(int(at_ns))

    # --- reading -----------------------------------------------------------------------------------------------------
    is_fed = property(lambda self: self._native.is_fed, doc="True if the program feeds the measurements.")
    is_finished = property(lambda self: self._native.is_finished)
    waiting = property(lambda self: self._native.waiting, doc="Measurements that were fed and not read yet.")
    started = property(lambda self: self._native.started, doc="True once the start pose is known.")
    config = property(lambda self: self._native.config, doc="The effective configuration, as YAML.")
    sensor_names = property(lambda self: self._native.sensor_names, doc="In the order of the YAML.")
    map_names = property(lambda self: self._native.map_names)
    state_names = property(lambda self: self._native.state_names,
                           doc="Of the error states, in the order of `Snapshot.covariance`.")

    @property
    def trajectory(self):
        """One row for each processed measurement so far, as a record array: stamp_ns, position (3), orientation (x, y,
        z, w), yaw, covariance of (x, y, yaw) (3, 3), velocity and angular_rate in the base frame (3), effective_sample_size,
        sensor (index), fate (index of FATES). The rows are those of `trajectory.txt`."""
        return _records(self._native._trajectory())

    @property
    def particles(self):
        """Position (3), orientation (4), yaw and weight of every particle, after the last snapshot."""
        return _records(self._native._particles())

    @property
    def path(self):
        """The whole path of the particle with the highest weight: stamp_ns, position, orientation, yaw."""
        return _records(self._native._path())

    @property
    def reference(self):
        """Ground truth of the source, as `path`; yaw is NaN where it is not known. Empty if there is none."""
        return _records(self._native._reference())

    @property
    def smoothed(self):
        """Poses from the whole log (`filter.smooth`), with covariance; empty before the end."""
        return _records(self._native._smoothed())

    def landmarks(self, map=None):
        """Landmarks: id, birth, position (2), radius_m, covariance of (east, north, radius), conditional_covariance,
        existence, sightings, confirmed."""
        return _records(self._native._landmarks(self._one_map(map)))

    def sightings(self, map=None):
        """Detections that were fused into landmarks: stamp_ns, position_base (2), landmark (id), is_first."""
        return _records(self._native._sightings(self._one_map(map)))

    def grid(self, map=None, mixture=False):
        """The dense map as a Grid; None if there is none. mixture: over the maps of all particles."""
        found = self._native._grid(self._one_map(map), mixture)
        if found is None:
            return None
        return Grid(found["cells"], found["resolution_m"], np.array(found["position"]), found["yaw"])

    def figures(self, map=None):
        """Figures of a map, {"merged": 3.0, …}."""
        return self._native._figures(self._one_map(map))

    def files(self, map=None):
        """The map in its module's file formats: {".bt": bytes}."""
        return self._native._files(self._one_map(map))

    @property
    def report(self):
        """Counters of the sensors, events, health and findings so far, as dictionaries; after `finish` those of the
        whole run."""
        return self._native._report()

    @property
    def events(self):
        """Events so far: a list of {"stamp_ns", "text", "is_failure"}."""
        return self.report["events"]


@dataclasses.dataclass(frozen=True)
class Result(_Maps):
    """What a run left. Arrays as in `Robot`."""
    robot: Robot
    trajectory: np.ndarray
    path: np.ndarray
    report: dict
    out: pathlib.Path | None

    @classmethod
    def _of(cls, robot, check):
        report = robot.report
        result = cls(robot, robot.trajectory, robot.path, report, robot.out)
        if check and report["failures"]:
            raise RunError(report["failures"], result)
        return result

    events = property(lambda self: self.report["events"])
    failures = property(lambda self: self.report["failures"], doc="One line each; empty if all went well.")
    sensors = property(lambda self: self.report["sensors"], doc="Counters of each sensor, by name.")
    findings = property(lambda self: self.report["findings"], doc="Contradictions between the sensors.")
    map_names = property(lambda self: self.robot.map_names)
    reference = property(lambda self: self.robot.reference)
    smoothed = property(lambda self: self.robot.smoothed)
    particles = property(lambda self: self.robot.particles)

    def landmarks(self, map=None):
        return self.robot.landmarks(map)

    def sightings(self, map=None):
        return self.robot.sightings(map)

    def grid(self, map=None, mixture=False):
        return self.robot.grid(map, mixture)

    def figures(self, map=None):
        return self.robot.figures(map)

    def files(self, map=None):
        return self.robot.files(map)


def run(path=None, *, set=None, out=None, seed=None, check=True, **options):
    """Runs a robot on its log, or a flight record of it, as `waymark run` does, and returns the Result. Arguments as of
    `Robot`; `check`: RunError if the run did not end well."""
    robot = Robot(path, set=set, out=out, seed=seed, **options)
    return robot.play().finish(check)
