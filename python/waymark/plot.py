# SPDX-License-Identifier: Apache-2.0
"""Pictures of runs with matplotlib. `run`: a Result, or a Robot that is being stepped. Each function draws into `ax`, or
into a new figure, and returns the axes."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection

from waymark._evaluation import score, wrap

_BLUE, _RED = "#1f5fbf", "#c0392b"


def _axes(ax, square=True):
    if ax is None:
        _, ax = plt.subplots(figsize=(8, 6), layout="constrained")
        if square:
            ax.set(xlabel="east [m]", ylabel="north [m]")
    if square:
        ax.set_aspect("equal", adjustable="datalim")
    return ax


def _ellipses(ax, centres, P, sigmas, **style):
    """Ellipses of `sigmas` standard deviations of two-dimensional covariances P (n, 2, 2)."""
    values, vectors = np.linalg.eigh(P)
    axes = 2 * sigmas * np.sqrt(np.maximum(values, 0.0))
    angles = np.degrees(np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1]))
    ax.add_collection(EllipseCollection(axes[:, 1], axes[:, 0], angles, units="xy", offsets=centres,
                                        offset_transform=ax.transData, facecolors="none", **style))
    ax.autoscale_view()


def trajectory(run, ax=None, *, path=False, reference=True, label="estimate", color=_BLUE):
    """The estimate as it was known at each time; path=True: that of the best particle as it is known now."""
    ax = _axes(ax)
    truth = run.reference
    if reference and len(truth):
        ax.plot(*truth["position"][:, :2].T, color=_RED, lw=1, label="reference")
    ax.plot(*(run.path if path else run.trajectory)["position"][:, :2].T, color=color, lw=1.2, label=label)
    ax.legend(loc="best")
    return ax


def landmarks(run, map=None, ax=None, *, sigmas=3.0, color=_BLUE):
    """Landmarks with their ellipses of `sigmas` standard deviations."""
    ax = _axes(ax)
    found = run.landmarks(map)
    if len(found):
        ax.plot(*found["position"].T, ".", ms=4, color=color, label="landmarks")
        _ellipses(ax, found["position"], found["covariance"][:, :2, :2], sigmas, edgecolors=color, linewidths=0.8)
    return ax


def grid(run, map=None, ax=None, *, mixture=False):
    """A dense map: black occupied, white free, grey unknown."""
    ax = _axes(ax)
    found = run.grid(map, mixture)
    if found is None:
        return ax
    grey = np.where(found.cells == found.UNKNOWN, 0.8, 1.0 - found.cells / 100.0)
    x, y = found.position[:2]
    height, width = found.cells.shape
    image = ax.imshow(grey, origin="lower", cmap="gray", vmin=0, vmax=1, zorder=-1, interpolation="nearest",
                      extent=(0, width * found.resolution_m, 0, height * found.resolution_m))
    from matplotlib.transforms import Affine2D
    image.set_transform(Affine2D().rotate(found.yaw).translate(x, y) + ax.transData)
    corners = np.array([[0, 0], [width, 0], [0, height], [width, height]]) * found.resolution_m
    c, s = np.cos(found.yaw), np.sin(found.yaw)
    ax.update_datalim(corners @ np.array([[c, s], [-s, c]]) + [x, y])
    ax.autoscale_view()
    return ax


def particles(run, ax=None, *, color=_BLUE):
    """Position and heading of each particle; the area of a dot is its weight."""
    ax = _axes(ax)
    all_of_them = run.particles
    x, y = all_of_them["position"][:, :2].T
    weight = all_of_them["weight"]
    ax.scatter(x, y, s=400 * weight, color=color, alpha=0.5)
    ax.quiver(x, y, np.cos(all_of_them["yaw"]), np.sin(all_of_them["yaw"]), color=color, width=0.002)
    return ax


def errors(run, axes=None, *, reference=None, align="none"):
    """Errors of east, north and yaw between their bounds of 3σ, over time. Returns the three axes."""
    truth = run.reference if reference is None else reference
    scored = score(run.trajectory, truth, align=align)
    if axes is None:
        _, axes = plt.subplots(3, 1, figsize=(8, 6), sharex=True, layout="constrained")
    seconds = 1e-9 * (scored.stamp_ns - scored.stamp_ns[0])
    values = [scored.error[:, 0], scored.error[:, 1], np.degrees(wrap(scored.yaw_error))]
    scales = [1.0, 1.0, np.degrees(1.0)]
    for i, (ax, name) in enumerate(zip(axes, ("east [m]", "north [m]", "yaw [deg]"))):
        bound = 3 * scales[i] * scored.sigma[:, i]
        ax.fill_between(seconds, -bound, bound, color=_BLUE, alpha=0.15, lw=0)
        ax.plot(seconds, values[i], color=_BLUE, lw=0.8)
        ax.axhline(0, color="black", lw=0.5)
        ax.set_ylabel(name)
    axes[-1].set_xlabel("time [s]")
    return axes


def overview(run, ax=None):
    """Path, reference and all maps of a run."""
    ax = _axes(ax)
    for name in run.map_names:
        grid(run, name, ax)
        landmarks(run, name, ax)
    return trajectory(run, ax, path=True)
