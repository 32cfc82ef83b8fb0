"""The way of a tool as legs, each with the minimum jerk, and the joints along it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from wmspec.compile.robots.arm import Arm, Array
from wmspec.compile.robots.ik import rotation_vector, solve

KNOTS = 20  # Hz: a cubic spline through so many knots is off by .05 mm at most
DIGITS = 6  # of a knot, rad or m: the same whatever processor computes them
FAST = 0.95  # of the joints' greatest speeds
NEARER = "place what it handles nearer to the arm, or let the hand go less far or less high"


@dataclass(frozen=True)
class Leg:
    """Until `until` (s) the tool goes the way `tool`, of 0..1, and the fingers open or close to `width` (m)."""

    until: float
    tool: Callable[[float], Array]
    width: float


class OutOfReachError(ValueError):
    """No joint angles bring the tool there, `after` (s) of its way, or not so fast; and what helps."""

    def __init__(self, message: str, help: str = "", after: float | None = None) -> None:
        super().__init__(message)
        self.help, self.after = help, after


def straight(a: Array, b: Array) -> Callable[[float], Array]:
    """The straight way from one place of the tool to another, turning evenly."""
    axis = rotation_vector(b[:3, :3] @ a[:3, :3].T)

    def way(s: float) -> Array:
        place = np.eye(4)
        place[:3, 3] = (1 - s) * a[:3, 3] + s * b[:3, 3]
        place[:3, :3] = spun(s * axis) @ a[:3, :3]
        return place

    return way


def stay(a: Array) -> Callable[[float], Array]:
    """No way at all."""
    return lambda _s: a


def smooth(s: float) -> float:
    """Minimum jerk, from 0..1 to 0..1 (T. Flash and N. Hogan, 1985)."""
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s * s)


def times(duration: float) -> tuple[float, ...]:
    """The knots of a way, s."""
    n = max(2, round(duration * KNOTS))
    return (*(round(k / KNOTS, DIGITS) for k in range(n) if k / KNOTS < duration - 0.5 / KNOTS), duration)


def joints(arm: Arm, base: Array, q: Array, width: float, legs: Sequence[Leg]) -> Array:
    """The joints at the knots (n, 7 + 2): angles from `q` (7,) on, and how far each finger is from the middle.

    Raises OutOfReachError.
    """
    places, widths = [], []
    for time in times(legs[-1].until):
        i = next(i for i, leg in enumerate(legs) if time <= leg.until + 1e-9)
        before, opened = (legs[i - 1].until, legs[i - 1].width) if i else (0.0, width)
        s = smooth((time - before) / (legs[i].until - before))
        places.append(legs[i].tool(s))
        widths.append((1 - s) * opened + s * legs[i].width)
    angles = _angles(arm, base.tobytes(), q.tobytes(), np.array(places).tobytes())
    if len(angles) < len(places):
        x, y, z = 100 * places[len(angles)][:3, 3]
        what = f"({x:.0f}, {y:.0f}, {z:.0f}) cm is out of its reach with the hand turned like that"
        raise OutOfReachError(what, NEARER, times(legs[-1].until)[len(angles)])
    speed = np.abs(np.diff(angles, axis=0)) / np.diff(times(legs[-1].until))[:, None]
    if (over := float((speed / arm.speed).max()) / FAST) > 1:
        enough = np.ceil(10 * over * legs[-1].until) / 10
        raise OutOfReachError(
            f"it would have to move {max(over, 1.01):.3g} times as fast as it can", f"give it some {enough:g} s"
        )
    fingers = np.array(widths)[:, None] / 2
    return np.round(np.concatenate([angles, fingers, fingers], axis=1), DIGITS)


@lru_cache(maxsize=256)
def _angles(arm: Arm, base: bytes, q: bytes, places: bytes) -> Array:
    """The joint angles (n, 7) for places of the tool, each found from the one before, up to one out of reach."""
    near, solved = np.frombuffer(q), []
    for place in np.frombuffer(places).reshape(-1, 4, 4):
        angles = solve(arm, place, np.frombuffer(base).reshape(4, 4), near)
        if angles is None:
            break
        near = angles
        solved.append(angles)
    return np.array(solved).reshape(len(solved), len(near))


def spun(vector: Array) -> Array:
    """The rotation matrix (3, 3) of an axis times an angle (O. Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)
