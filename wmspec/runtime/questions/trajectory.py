"""The form of a path: its few corners (Douglas and Peucker), how they turn, and whether it closes."""

from __future__ import annotations

import math

import numpy as np

from wmspec.sim.scene.model import Array

#: What strays less than this (m), or than this share of the path's extent, is no corner.
STRAY, STRAY_SHARE = 0.005, 0.02
#: A path whose ends are nearer to one another than this share of its extent is closed.
CLOSED = 0.2
#: A turn (rad) beyond which a path reverses, and one beyond which a corner is too sharp for an arc.
REVERSAL, SHARP = math.radians(150), math.radians(75)
#: An arc turns by more than this in all (rad), and a circle by more than this.
LEAST_TURN, ROUND = math.radians(12), math.radians(240)
#: A closed path by its sharp corners. One that begins in a corner is not told: it has one less.
CLOSED_FORMS = {0: "circle", 3: "triangle", 4: "square"}
#: A leg shorter than this share of a path's extent only blunts the corner between its neighbours.
BLUNT = 0.1
#: A path that turns one way turns less than this share of all its turning the other way.
ONE_WAY = 0.1


def form(path: Array) -> str | None:
    """The word of the vocabulary `path` for a path (t, 3) m; None if it has none of these forms.

    Holds for the paths of the verb `follow` and for what is thrown or rolls, also with a millimetre of noise.
    """
    flat = _flattened(_smoothed(path))
    extent = float(np.linalg.norm(np.ptp(flat, axis=0)))
    stray = max(STRAY, STRAY_SHARE * extent)
    corners = flat[_corners(flat, stray)]
    legs = np.diff(corners, axis=0)
    turns = _turns(legs)
    if np.ptp(flat[:, 1]) <= stray:
        return "back_and_forth" if (np.abs(turns) > REVERSAL).any() else "straight"
    left, right = float(turns[turns > 0].sum()), -float(turns[turns < 0].sum())
    if min(left, right) > ONE_WAY * (left + right):
        return "zigzag" if len(turns) > 1 else None
    if np.linalg.norm(flat[-1] - flat[0]) < CLOSED * extent and left + right > ROUND:
        return CLOSED_FORMS.get(_sharp(legs, turns, BLUNT * extent))
    smooth = len(turns) > 0 and float(np.abs(turns).max()) < SHARP
    return "arc" if smooth and left + right > LEAST_TURN else None


def _sharp(legs: Array, turns: Array, short: float) -> int:
    """How many sharp corners there are, the turns at both ends of a leg shorter than `short` (m) taken for one."""
    apart = np.linalg.norm(legs[1:-1], axis=1) >= short
    corners = np.split(turns, np.flatnonzero(apart) + 1)
    return sum(abs(float(corner.sum())) > SHARP for corner in corners)


def _smoothed(path: Array) -> Array:
    """The path with every sample averaged over a fiftieth of it; the ends stay ends."""
    wide = len(path) // 100
    if wide == 0:
        return path
    padded = np.concatenate([np.repeat(path[:1], wide, axis=0), path, np.repeat(path[-1:], wide, axis=0)])
    window = np.ones(2 * wide + 1) / (2 * wide + 1)
    return np.stack([np.convolve(padded[:, i], window, mode="valid") for i in range(path.shape[1])], axis=1)


def _flattened(path: Array) -> Array:
    """The path (t, 2) in the plane in which it is widest, its longer side first."""
    centred = path - path.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    return np.asarray(centred @ axes[:2].T)


def _corners(path: Array, stray: float) -> list[int]:
    """The samples to which a path can be reduced without straying further than `stray` from it."""
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
    """How far every point of a path is from the line between its ends."""
    way, to = path[-1] - path[0], path - path[0]
    length = float(way @ way)
    share = np.clip(to @ way / length, 0, 1) if length > 0 else np.zeros(len(path))
    return np.asarray(np.linalg.norm(to - share[:, None] * way, axis=1))


def _turns(legs: Array) -> Array:
    """By how much (rad, anticlockwise) a path turns between its legs."""
    headings = np.arctan2(legs[:, 1], legs[:, 0])
    return np.asarray((np.diff(headings) + np.pi) % (2 * np.pi) - np.pi)
