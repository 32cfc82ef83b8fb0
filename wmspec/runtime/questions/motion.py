"""How bodies moved while they were observed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.bearing import Bearing
from wmspec.runtime.questions.observed import MOVED, STILL, Observed
from wmspec.runtime.questions.trajectory import form
from wmspec.sim.scene.model import Array


def speed(
    observed: Observed, name: str, from_: float | None = None, to: float | None = None, at: float | None = None
) -> float:
    """The length of the path over its time (m/s): of what is observed, or between two times; 0 of a single look.

    At a time, how fast it is then.
    """
    if at is not None:
        return float(np.linalg.norm(_velocity(observed, name, at)))
    start, stop = observed.window
    if from_ is None and to is None:
        return float(_steps(observed.path(name)).sum() / (stop - start)) if stop > start else 0.0
    during = observed.span(from_, to, observed.window)
    times = observed.trace.time[during]
    return float(_steps(observed.track(name)[during]).sum() / (times[-1] - times[0]))


def moved(observed: Observed, name: str, from_: float | None = None, to: float | None = None) -> bool:
    """Whether it was ever more than 2 mm from where it was first seen, or from where it was at a time."""
    path = observed.track(name)[observed.span(from_, to, observed.window)]
    return bool((np.linalg.norm(path - path[0], axis=1) > MOVED).any())


def onset(observed: Observed, name: str) -> float:
    """When (s) it first moved: the last standstill before it had come 2 mm away. Raises WmsError if it never moved."""
    return float(observed.times[_first_step(observed.path(name), observed.scene.rate, name)])


def moving_time(observed: Observed, name: str) -> float:
    """How long (s) it moved, from its onset to its last standstill; 0 if it never did."""
    if not moved(observed, name):
        return 0.0
    path, rate = observed.path(name), observed.scene.rate
    first = _first_step(path, rate, name)
    last = len(path) - 1 - _first_step(path[::-1], rate, name)
    return float(observed.times[last] - observed.times[first])


def heading(observed: Observed, name: str, at: float | None = None) -> Bearing:
    """The direction (rad, anticlockwise from +x, in (-pi, pi]) from where it was first to where it was last.

    At a time, that in which it moves then. Raises WmsError if it ends within 2 mm of where it began, or is then slower
    than 1 cm/s over the ground.
    """
    if at is not None:
        x, y, _ = _velocity(observed, name, at)
        if math.hypot(x, y) < STILL:
            raise WmsError(f"`{name}` does not move over the ground at {at:g} s, so it has no heading then")
        return Bearing(math.atan2(y, x))
    path = observed.path(name)
    x, y, _ = path[-1] - path[0]
    if math.hypot(x, y) <= MOVED:
        raise WmsError(f"`{name}` ends where it began, so it has no heading")
    return Bearing(math.atan2(y, x))


def heads_to(observed: Observed, name: str, others: Sequence[str]) -> str:
    """The one whose direction, seen from where `name` was first, is nearest to the heading of `name`."""
    angle, start = heading(observed, name), observed.path(name)[0]

    def off(other: str) -> float:
        x, y, _ = observed.path(other)[0] - start
        return abs(math.atan2(y, x) - angle)

    return min(others, key=off)


def trajectory(observed: Observed, name: str) -> str:
    """The form of its path, a word of the vocabulary `path`. Raises WmsError if it has none of these forms."""
    if not moved(observed, name):
        raise WmsError(f"`{name}` does not move, so its path has no form")
    word = form(observed.path(name))
    if word is None:
        raise WmsError(f"the path of `{name}` has no form that has a name")
    return word


def _velocity(observed: Observed, name: str, at: float) -> Array:
    """How the middle of a body moves (3,) m/s at a time: from the samples beside it, second order at the ends too."""
    i, times = observed.moment(at), observed.trace.time
    if len(times) < 3:
        raise WmsError("the episode is too short for anything to move in it")
    velocity: Array = np.gradient(observed.track(name), times, axis=0, edge_order=2)[i]
    return velocity


def _steps(path: Array) -> Array:
    return np.asarray(np.linalg.norm(np.diff(path, axis=0), axis=1))


def _first_step(path: Array, rate: int, name: str) -> int:
    """The sample at which the motion begins that leads more than 2 mm away from the first."""
    away = np.linalg.norm(path - path[0], axis=1) > MOVED
    if not away.any():
        raise WmsError(f"`{name}` does not move, so there is no time when it begins to")
    still = np.flatnonzero(_steps(path[: int(away.argmax()) + 1]) * rate < STILL)
    return int(still[-1]) + 1 if len(still) else 0
