# SPDX-License-Identifier: Apache-2.0
"""Live: a running robot."""
import atexit
import pathlib
import weakref

from waymark import _waymark
from waymark._robot import Result, Robot, _options

_RUNNING = weakref.WeakSet()


@atexit.register
def _stop_all():
    """A robot that the program leaves running ends with it, while its sensors in Python still can."""
    for live in list(_RUNNING):
        live._native.stop()


class Live:
    """A running robot: its sources are read and its filter works in threads of their own, from now on until `stop`, a
    command (`live.control` in the YAML), `until_s` after the first arrival, or the end of all sources.

        with waymark.Live("robot.yaml", out="out/robot") as live:
            while not live.wait(0.1):
                pose, health = live.front(), live.health
        result = live.stop()                # of a run that has ended: its Result

    Arguments as of `Robot`. record: False, since a robot may run for months: `Result.trajectory` is empty then. One of the
    sources must be live, or `live.real_time` true. Any thread may use the object.
    """

    def __init__(self, path=None, *, yaml=None, set=None, out=None, seed=None, threads=None, until_s=None, record=False,
                 name="", allow_outside=False):
        self._native = _waymark._LiveRobot(
            **_options(path, yaml, set, out, seed, threads, until_s, record, name, allow_outside))
        self.out = None if out is None else pathlib.Path(out)
        _RUNNING.add(self)

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        self.stop(check=kind is None)

    def front(self):
        """The pose now, as sinks get it at `live.front_hz`: the filter's belief, updated with what has arrived since and
        predicted to its `stamp_ns`, the time at which it was made. None before the filter has started."""
        return self._native.front()

    def last(self):
        """The belief after the last processed measurement; None before the first one."""
        return self._native.last()

    health = property(lambda self: self._native.health()[0],
                      doc='"ok", "degraded" or "lost"; lost, too, while nothing arrives.')
    health_reason = property(lambda self: self._native.health()[1], doc="Of the health; empty while it is ok.")
    events = property(lambda self: self._native.events(),
                      doc="Events of sources, queue and sinks so far, as in `Robot.events`: of many, the last 1000.")
    is_running = property(lambda self: self._native.is_running, doc="False once the run has ended, however it did.")

    def wait(self, timeout_s=None):
        """Waits until the run ends; False if it has not within the time [s]."""
        return self._native.wait(timeout_s)

    def stop(self, check=True):
        """Ends the run: commits what is buffered, lets the sinks write, and returns the Result. Raises RunError if the run
        did not end well, unless `check` is False. Called again, it returns the Result again."""
        self._native.stop()
        return Result._of(Robot._of(self._native.robot, self.out), check)
