"""Where and how bodies are at the end of an episode, or at a time of it (s)."""

from __future__ import annotations

import math

import numpy as np

from wmspec.compile.layout.view import seen
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.observed import REST, STILL, Observed
from wmspec.sim.scene.model import Array
from wmspec.sim.scene.model.transform import conjugate, rotate

UP = np.array([0.0, 0.0, 1.0])
#: Two directions are told apart if one is so many times as long as the other.
DIAGONAL = 1.2


def position(observed: Observed, name: str, at: float | None = None) -> tuple[float, float, float]:
    """Where the middle of a body is (m)."""
    x, y, z = observed.track(name)[observed.moment(at)].tolist()
    return x, y, z


def displacement(observed: Observed, name: str, at: float | None = None) -> float:
    """How far (m) the middle of a body is from where it began."""
    track = observed.track(name)
    return float(np.linalg.norm(track[observed.moment(at)] - track[0]))


def distance(observed: Observed, a: str, b: str, at: float | None = None) -> float:
    """How far apart (m) the middles of two bodies are."""
    i = observed.moment(at)
    return float(np.linalg.norm(observed.track(a)[i] - observed.track(b)[i]))


def height(observed: Observed, name: str, at: float | None = None) -> float:
    """How high (m) above the origin of the world the middle of a body is."""
    return float(observed.track(name)[observed.moment(at), 2])


def at_rest(observed: Observed, name: str, at: float | None = None) -> bool:
    """Whether no point of a body is faster than 1 cm/s during the 0.1 s before."""
    i, times = observed.index(name), observed.trace.time
    last = times[observed.moment(at)]
    late = (times >= last - REST) & (times <= last)
    along = np.linalg.norm(observed.trace.linear_velocity[late, i], axis=1)
    around = np.linalg.norm(observed.trace.angular_velocity[late, i], axis=1) * observed.radius(name)
    return bool((along + around < STILL).all())


def toppled(observed: Observed, name: str, at: float | None = None) -> bool:
    """Whether what pointed up in a body at the start points more than 45 degrees away from up."""
    first, last = observed.trace.orientation[[0, observed.moment(at)], observed.index(name)]
    return bool(rotate(last, rotate(conjugate(first), UP))[2] < math.cos(math.pi / 4))


def contains(observed: Observed, outer: str, inner: str, at: float | None = None) -> bool:
    """Whether the middle of `inner` is within the upright box around `outer`."""
    i = observed.moment(at)
    low, high = observed.box(outer, float(observed.trace.time[i]))
    middle = observed.track(inner)[i]
    return bool((low <= middle).all() and (middle <= high).all())


def relation(observed: Observed, a: str, b: str, way: float, at: float) -> str:
    """Where `a` is from `b` at a time (s), a word of the vocabulary `relation`, for who looks that `way` (`view.seen`).

    `above` and `below` hold where their upright boxes share ground and one's middle is beyond the other's box. Raises
    WmsError where it lies diagonally, so that two words would fit.
    """
    here, there = observed.box(a, at), observed.box(b, at)
    if _share_ground(here, there):
        middle, other = here.mean(axis=0)[2], there.mean(axis=0)[2]
        if middle > there[1, 2] or other < here[0, 2]:
            return "above"
        if middle < there[0, 2] or other > here[1, 2]:
            return "below"
    x, y = seen(way, *(here.mean(axis=0) - there.mean(axis=0))[:2])
    if abs(x) < DIAGONAL * abs(y) and abs(y) < DIAGONAL * abs(x):
        raise WmsError(f"`{a}` lies diagonally from `{b}`, so two relations would fit; place it more to one side")
    if x == y == 0:
        raise WmsError(f"`{a}` and `{b}` are at the same place, so neither is beside the other")
    if abs(x) > abs(y):
        return "right_of" if x > 0 else "left_of"
    return "behind" if y > 0 else "in_front_of"


def _share_ground(a: Array, b: Array) -> bool:
    return bool((np.maximum(a[0, :2], b[0, :2]) < np.minimum(a[1, :2], b[1, :2])).all())
