"""What had become of bodies at the end of an episode, and where they were when last seen."""

from __future__ import annotations

import math

import numpy as np

from wmspec.ask.observed import REST, STILL, Observed
from wmspec.diagnostics import WmsError
from wmspec.layout.view import seen
from wmspec.scene.model import Array
from wmspec.scene.transform import conjugate, rotate

UP = np.array([0.0, 0.0, 1.0])
#: Two directions are told apart if one is so many times as long as the other.
DIAGONAL = 1.2


def displacement(observed: Observed, name: str) -> float:
    """How far (m) the middle of a body is at the end from where it began."""
    track = observed.track(name)
    return float(np.linalg.norm(track[-1] - track[0]))


def distance(observed: Observed, a: str, b: str) -> float:
    """How far apart (m) the middles of two bodies are at the end."""
    return float(np.linalg.norm(observed.track(a)[-1] - observed.track(b)[-1]))


def height(observed: Observed, name: str) -> float:
    """How high (m) above the origin of the world the middle of a body is at the end."""
    return float(observed.track(name)[-1, 2])


def contact(observed: Observed, a: str, b: str) -> bool:
    """Whether two bodies touched at any time."""
    pair = {observed.body(a).name, observed.body(b).name}
    return any({c.first, c.second} == pair for c in observed.trace.contacts)


def at_rest(observed: Observed, name: str) -> bool:
    """Whether no point of a body was faster than 1 cm/s during the last 0.1 s."""
    i, late = observed.index(name), observed.trace.time >= observed.trace.time[-1] - REST
    along = np.linalg.norm(observed.trace.linear_velocity[late, i], axis=1)
    around = np.linalg.norm(observed.trace.angular_velocity[late, i], axis=1) * observed.radius(name)
    return bool((along + around < STILL).all())


def toppled(observed: Observed, name: str) -> bool:
    """Whether what pointed up in a body at the start points more than 45 degrees away from up at the end."""
    first, last = observed.trace.orientation[[0, -1], observed.index(name)]
    return bool(rotate(last, rotate(conjugate(first), UP))[2] < math.cos(math.pi / 4))


def contains(observed: Observed, outer: str, inner: str) -> bool:
    """Whether the middle of `inner` ended within the upright box around `outer`."""
    low, high = observed.box(outer, float(observed.trace.time[-1]))
    middle = observed.track(inner)[-1]
    return bool((low <= middle).all() and (middle <= high).all())


def relation(observed: Observed, a: str, b: str, way: int) -> str:
    """Where `a` was from `b` at the last look, a word of the vocabulary `relation`, for who looks that `way` (`front`).

    `above` and `below` hold where their upright boxes share ground and one's middle is beyond the other's box. Raises
    WmsError where it lies diagonally, so that two words would fit.
    """
    last = observed.window[1]
    here, there = observed.box(a, last), observed.box(b, last)
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
