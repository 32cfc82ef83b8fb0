"""Measures of motion during observation."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.bearing import Bearing
from wmspec.runtime.questions.observed import MIN_MOTION, STANDSTILL_SPEED, Observed
from wmspec.runtime.questions.trajectory import path_form
from wmspec.sim.scene.model import Array


def speed(
    observed: Observed, name: str, from_: float | None = None, to: float | None = None, at: float | None = None
) -> float:
    """Return path length over time (m/s), of the observed interval or between two times; 0 for a single view.

    With `at`, return the instantaneous speed.
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
    """Return whether it was ever more than 2 mm from its first observed position, or from its position at a time."""
    path = observed.track(name)[observed.span(from_, to, observed.window)]
    return bool((np.linalg.norm(path - path[0], axis=1) > MIN_MOTION).any())


def onset(observed: Observed, name: str) -> float:
    """Return the time (s) of the first motion: the last standstill before it is 2 mm away. Raises WmsError if it never
    moved.
    """
    return float(observed.times[_first_step(observed.path(name), observed.scene.rate, name)])


def moving_time(observed: Observed, name: str) -> float:
    """Return the duration (s) of motion from onset to the last standstill; 0 without motion."""
    if not moved(observed, name):
        return 0.0
    path, rate = observed.path(name), observed.scene.rate
    first = _first_step(path, rate, name)
    last = len(path) - 1 - _first_step(path[::-1], rate, name)
    return float(observed.times[last] - observed.times[first])


def heading(observed: Observed, name: str, at: float | None = None) -> Bearing:
    """Return the direction (rad, counter-clockwise from +x, in (-pi, pi]) from first to last position.

    With `at`, the direction of motion at that time. Raises WmsError if it ends within 2 mm of its start, or is slower
    than 1 cm/s at that time.
    """
    if at is not None:
        x, y, _ = _velocity(observed, name, at)
        if math.hypot(x, y) < STANDSTILL_SPEED:
            raise WmsError(f"`{name}` does not move horizontally at {at:g} s, so it has no heading then")
        return Bearing(math.atan2(y, x))
    path = observed.path(name)
    x, y, _ = path[-1] - path[0]
    if math.hypot(x, y) <= MIN_MOTION:
        raise WmsError(f"`{name}` ends where it began, so it has no heading")
    return Bearing(math.atan2(y, x))


def heads_to(observed: Observed, name: str, others: Sequence[str]) -> str:
    """Return the object whose direction from the first position of `name` is closest to its heading."""
    angle, start = heading(observed, name), observed.path(name)[0]

    def off(other: str) -> float:
        x, y, _ = observed.path(other)[0] - start
        return abs(math.atan2(y, x) - angle)

    return min(others, key=off)


def trajectory(observed: Observed, name: str) -> str:
    """Return the shape of its path, a word of the vocabulary `path`. Raises WmsError if no word fits."""
    if not moved(observed, name):
        raise WmsError(f"`{name}` does not move, so its path has no shape")
    word = path_form(observed.path(name))
    if word is None:
        raise WmsError(f"the path of `{name}` has no named shape")
    return word


def _velocity(observed: Observed, name: str, at: float) -> Array:
    """Return the velocity (3,) m/s of the centre of a body at a time, by second-order differences."""
    i, times = observed.moment(at), observed.trace.time
    if len(times) < 3:
        raise WmsError("the episode is too short for anything to move in it")
    velocity: Array = np.gradient(observed.track(name), times, axis=0, edge_order=2)[i]
    return velocity


def _steps(path: Array) -> Array:
    return np.asarray(np.linalg.norm(np.diff(path, axis=0), axis=1))


def _first_step(path: Array, rate: int, name: str) -> int:
    """Return the sample at which the motion starts that leads more than 2 mm away."""
    away = np.linalg.norm(path - path[0], axis=1) > MIN_MOTION
    if not away.any():
        raise WmsError(f"`{name}` does not move, so it has no onset")
    still = np.flatnonzero(_steps(path[: int(away.argmax()) + 1]) * rate < STANDSTILL_SPEED)
    return int(still[-1]) + 1 if len(still) else 0
