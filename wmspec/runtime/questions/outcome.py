"""Positions and states of bodies at the end of an episode, or at a time (s)."""

from __future__ import annotations

import math

import numpy as np

from wmspec.compile.layout.view import view_coordinates
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.observed import REST_TIME, STANDSTILL_SPEED, Observed
from wmspec.sim.scene.model import Array
from wmspec.sim.scene.model.transform import conjugate, rotate

UP = np.array([0.0, 0.0, 1.0])
#: Ratio of two components above which the larger one gives the direction.
DIAGONAL_RATIO = 1.2


def position(observed: Observed, name: str, at: float | None = None) -> tuple[float, float, float]:
    """Return the centre of a body (m)."""
    x, y, z = observed.track(name)[observed.moment(at)].tolist()
    return x, y, z


def displacement(observed: Observed, name: str, at: float | None = None) -> float:
    """Return the distance (m) of the centre of a body from its start."""
    track = observed.track(name)
    return float(np.linalg.norm(track[observed.moment(at)] - track[0]))


def distance(observed: Observed, a: str, b: str, at: float | None = None) -> float:
    """Return the distance (m) of the centres of two bodies."""
    i = observed.moment(at)
    return float(np.linalg.norm(observed.track(a)[i] - observed.track(b)[i]))


def height(observed: Observed, name: str, at: float | None = None) -> float:
    """Return the height (m) of the centre of a body."""
    return float(observed.track(name)[observed.moment(at), 2])


def at_rest(observed: Observed, name: str, at: float | None = None) -> bool:
    """Return whether no point of a body exceeded 1 cm/s during the last 0.1 s."""
    i, times = observed.index(name), observed.trace.time
    last = times[observed.moment(at)]
    late = (times >= last - REST_TIME) & (times <= last)
    along = np.linalg.norm(observed.trace.linear_velocity[late, i], axis=1)
    around = np.linalg.norm(observed.trace.angular_velocity[late, i], axis=1) * observed.radius(name)
    return bool((along + around < STANDSTILL_SPEED).all())


def toppled(observed: Observed, name: str, at: float | None = None) -> bool:
    """Return whether the initial up axis of a body is more than 45 degrees from vertical."""
    first, last = observed.trace.orientation[[0, observed.moment(at)], observed.index(name)]
    return bool(rotate(last, rotate(conjugate(first), UP))[2] < math.cos(math.pi / 4))


def contains(observed: Observed, outer: str, inner: str, at: float | None = None) -> bool:
    """Return whether the centre of `inner` is within the axis-aligned box of `outer`."""
    i = observed.moment(at)
    low, high = observed.box(outer, float(observed.trace.time[i]))
    middle = observed.track(inner)[i]
    return bool((low <= middle).all() and (middle <= high).all())


def relation(observed: Observed, a: str, b: str, way: float, at: float) -> str:
    """Return the relation of `a` to `b` at a time (s), a word of the vocabulary `relation`, for view direction `way`.

    `above` and `below` require overlapping footprints and a centre beyond the other box. Raises WmsError for diagonal
    positions, where two words would fit.
    """
    here, there = observed.box(a, at), observed.box(b, at)
    if _share_ground(here, there):
        middle, other = here.mean(axis=0)[2], there.mean(axis=0)[2]
        if middle > there[1, 2] or other < here[0, 2]:
            return "above"
        if middle < there[0, 2] or other > here[1, 2]:
            return "below"
    x, y = view_coordinates(way, *(here.mean(axis=0) - there.mean(axis=0))[:2])
    if abs(x) < DIAGONAL_RATIO * abs(y) and abs(y) < DIAGONAL_RATIO * abs(x):
        raise WmsError(f"`{a}` is diagonal to `{b}`, so two relations would fit; place it more to one side")
    if x == y == 0:
        raise WmsError(f"`{a}` and `{b}` are at the same place, so they have no relation")
    if abs(x) > abs(y):
        return "right_of" if x > 0 else "left_of"
    return "behind" if y > 0 else "in_front_of"


def _share_ground(a: Array, b: Array) -> bool:
    return bool((np.maximum(a[0, :2], b[0, :2]) < np.minimum(a[1, :2], b[1, :2])).all())
