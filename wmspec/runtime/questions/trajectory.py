"""The shape of a path: its corners (Douglas-Peucker), their turns, and whether it closes."""

from __future__ import annotations

import math

import numpy as np

from wmspec.sim.scene.model import Array

#: m, and share of the extent: smaller deviations are not corners.
MIN_DEVIATION, MIN_DEVIATION_SHARE = 0.005, 0.02
#: A path whose ends are closer than this share of its extent is closed.
CLOSED_GAP = 0.2
#: rad: a larger turn reverses; a larger corner is too sharp for an arc.
REVERSAL, SHARP_CORNER = math.radians(150), math.radians(75)
#: rad: smallest total turn of an arc and of a circle.
MIN_ARC, MIN_CIRCLE = math.radians(12), math.radians(240)
#: Closed paths by sharp corners. A path that starts in a corner has one less and is not named.
CLOSED_FORMS = {0: "circle", 3: "triangle", 4: "square"}
#: A leg shorter than this share of the extent only blunts the corner between its neighbours.
SHORT_LEG = 0.12
#: Largest share of turns in the opposite direction of a one-way path.
MAX_COUNTERTURN = 0.1


def path_form(path: Array) -> str | None:
    """Return the word of the vocabulary `path` for a path (t, 3) m, or None.

    Valid for the verb `follow` and for thrown or rolling bodies, with up to a millimetre of noise.
    """
    flat = _flattened(_smoothed(path))
    extent = float(np.linalg.norm(np.ptp(flat, axis=0)))
    stray = max(MIN_DEVIATION, MIN_DEVIATION_SHARE * extent)
    corners = flat[_corners(flat, stray)]
    legs = np.diff(corners, axis=0)
    turns = _turns(legs)
    if np.ptp(flat[:, 1]) <= stray:
        return "back_and_forth" if (np.abs(turns) > REVERSAL).any() else "straight"
    left, right = float(turns[turns > 0].sum()), -float(turns[turns < 0].sum())
    if min(left, right) > MAX_COUNTERTURN * (left + right):
        return "zigzag" if len(turns) > 1 else None
    if np.linalg.norm(flat[-1] - flat[0]) < CLOSED_GAP * extent and left + right > MIN_CIRCLE:
        return CLOSED_FORMS.get(_sharp(legs, turns, SHORT_LEG * extent))
    smooth = len(turns) > 0 and float(np.abs(turns).max()) < SHARP_CORNER
    return "arc" if smooth and left + right > MIN_ARC else None


def _sharp(legs: Array, turns: Array, short: float) -> int:
    """Return the number of sharp corners; turns at both ends of a leg shorter than `short` (m) count as one."""
    apart = np.linalg.norm(legs[1:-1], axis=1) >= short
    corners = np.split(turns, np.flatnonzero(apart) + 1)
    return sum(abs(float(corner.sum())) > SHARP_CORNER for corner in corners)


def _smoothed(path: Array) -> Array:
    """Return the path smoothed over a fiftieth of its samples, with fixed ends."""
    wide = len(path) // 100
    if wide == 0:
        return path
    padded = np.concatenate([np.repeat(path[:1], wide, axis=0), path, np.repeat(path[-1:], wide, axis=0)])
    window = np.ones(2 * wide + 1) / (2 * wide + 1)
    return np.stack([np.convolve(padded[:, i], window, mode="valid") for i in range(path.shape[1])], axis=1)


def _flattened(path: Array) -> Array:
    """Return the path (t, 2) in its plane of largest extent, longer side first."""
    centred = path - path.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    return np.asarray(centred @ axes[:2].T)


def _corners(path: Array, stray: float) -> list[int]:
    """Return the samples that approximate the path within `stray` (m)."""
    kept = {0, len(path) - 1}
    open_ = [(0, len(path) - 1)]
    while open_:
        first, last = open_.pop()
        away = _away(path[first : last + 1])
        worst = int(away.argmax())
        if away[worst] > stray:
            kept.add(first + worst)
            open_ += [(first, first + worst), (first + worst, last)]
    return sorted(kept)


def _away(path: Array) -> Array:
    """Return the distance of every point from the line between the ends."""
    way, to = path[-1] - path[0], path - path[0]
    length = float(way @ way)
    share = np.clip(to @ way / length, 0, 1) if length > 0 else np.zeros(len(path))
    return np.asarray(np.linalg.norm(to - share[:, None] * way, axis=1))


def _turns(legs: Array) -> Array:
    """Return the turns (rad, counter-clockwise) between legs."""
    headings = np.arctan2(legs[:, 1], legs[:, 0])
    return np.asarray((np.diff(headings) + np.pi) % (2 * np.pi) - np.pi)
