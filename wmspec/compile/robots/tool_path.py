"""Tool paths of minimum-jerk segments, and the joint trajectories that follow them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from wmspec.compile.robots.arm import Arm, Array, rotation_vector, solve

KNOT_RATE = 20  # Hz: the cubic spline errs by at most 0.05 mm
KNOT_DECIMALS = 6  # of knots (rad or m), for equal results on every processor
MAX_SPEED_SHARE = 0.95  # of the joints' speed limits
OUT_OF_REACH_REMEDY = "place what it handles nearer to the arm, or let the hand go less far or less high"


@dataclass(frozen=True)
class ToolSegment:
    """A segment that ends at `until` (s): the tool follows `tool` (0..1), the fingers reach `width` (m)."""

    until: float
    tool: Callable[[float], Array]
    width: float


class OutOfReachError(ValueError):
    """The tool pose is unreachable, `after` (s) of its path, or too fast; with a remedy."""

    def __init__(self, message: str, help: str = "", after: float | None = None) -> None:
        super().__init__(message)
        self.help, self.after = help, after


def straight(a: Array, b: Array) -> Callable[[float], Array]:
    """Return the straight path between two tool poses, with even rotation."""
    axis = rotation_vector(b[:3, :3] @ a[:3, :3].T)

    def way(s: float) -> Array:
        place = np.eye(4)
        place[:3, 3] = (1 - s) * a[:3, 3] + s * b[:3, 3]
        place[:3, :3] = rotation_matrix(s * axis) @ a[:3, :3]
        return place

    return way


def stay(a: Array) -> Callable[[float], Array]:
    """Return a path that stays at a pose."""
    return lambda _s: a


def smooth(s: float) -> float:
    """Return the minimum-jerk profile, from 0..1 to 0..1 (T. Flash and N. Hogan, 1985)."""
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s * s)


def knot_times(duration: float) -> tuple[float, ...]:
    """Return the knot times (s) of a path."""
    n = max(2, round(duration * KNOT_RATE))
    return (
        *(round(k / KNOT_RATE, KNOT_DECIMALS) for k in range(n) if k / KNOT_RATE < duration - 0.5 / KNOT_RATE),
        duration,
    )


def joint_knots(arm: Arm, base: Array, q: Array, width: float, legs: Sequence[ToolSegment]) -> Array:
    """Return the joints at the knots (n, 7 + 2): angles, starting at `q` (7,), and both finger displacements (m).

    Raises OutOfReachError.
    """
    places, widths = [], []
    for time in knot_times(legs[-1].until):
        i = next(i for i, leg in enumerate(legs) if time <= leg.until + 1e-9)
        before, opened = (legs[i - 1].until, legs[i - 1].width) if i else (0.0, width)
        s = smooth((time - before) / (legs[i].until - before))
        places.append(legs[i].tool(s))
        widths.append((1 - s) * opened + s * legs[i].width)
    angles = _angles(arm, base.tobytes(), q.tobytes(), np.array(places).tobytes())
    if len(angles) < len(places):
        x, y, z = 100 * places[len(angles)][:3, 3]
        what = f"({x:.0f}, {y:.0f}, {z:.0f}) cm is out of its reach with the hand turned like that"
        raise OutOfReachError(what, OUT_OF_REACH_REMEDY, knot_times(legs[-1].until)[len(angles)])
    speed = np.abs(np.diff(angles, axis=0)) / np.diff(knot_times(legs[-1].until))[:, None]
    if (over := float((speed / arm.speed).max()) / MAX_SPEED_SHARE) > 1:
        enough = np.ceil(10 * over * legs[-1].until) / 10
        raise OutOfReachError(
            f"it would have to move {max(over, 1.01):.3g} times as fast as it can", f"give it some {enough:g} s"
        )
    fingers = np.array(widths)[:, None] / 2
    return np.round(np.concatenate([angles, fingers, fingers], axis=1), KNOT_DECIMALS)


@lru_cache(maxsize=256)
def _angles(arm: Arm, base: bytes, q: bytes, places: bytes) -> Array:
    """Return joint angles (n, 7) for tool poses, each solved from the previous one, up to the first out of reach."""
    near, solved = np.frombuffer(q), []
    for place in np.frombuffer(places).reshape(-1, 4, 4):
        angles = solve(arm, place, np.frombuffer(base).reshape(4, 4), near)
        if angles is None:
            break
        near = angles
        solved.append(angles)
    return np.array(solved).reshape(len(solved), len(near))


def rotation_matrix(vector: Array) -> Array:
    """Return the rotation matrix (3, 3) of a rotation vector (O. Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)
