"""Overlap of convex shapes, the diameter of the largest ball inside both, and their distance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wmspec.sim.scene.model import Array, Pose
from wmspec.sim.scene.model.bounds import bounds
from wmspec.sim.scene.model.transform import compose, conjugate, inverse, rotate
from wmspec.sim.shapes import Shape

#: Precision of the result (m).
PRECISION = 1e-5


def overlap(a: Shape, at_a: Pose, b: Shape, at_b: Pose, least: float) -> float:
    """Return the diameter (m) of the largest ball inside both shapes, 0 below `least`. Meshes count as hulls.

    The depth of a point below the surface of a convex shape is a concave function of the point. So is the smaller of
    two such depths, and its maximum is deepest by cutting planes (Kelley, J. SIAM 8, 1960).
    """
    from scipy.optimize import linprog

    low, high = _common(a, at_a, b, at_b)
    if (high - low).min() < least or any(_flat(a, at_a, b, at_b, axes, least) for axes in (at_a, at_b)):
        return 0.0
    limits = [*zip(low, high, strict=True), (None, None)]
    here, slopes, offsets = (low + high) / 2, [], []
    deepest = -np.inf
    for _ in range(200):
        for shape, pose in ((a, at_a), (b, at_b)):
            depth, slope = _depth(shape, pose, here)
            slopes.append([*-slope, 1.0])
            offsets.append(depth - slope @ here)
        deepest = max(deepest, min(offsets[i] - np.dot(slopes[i][:3], here) for i in (-2, -1)))
        if 2 * _mean_bound(slopes[-2:], offsets[-2:], low, high) < least:
            return 0.0
        best = linprog([0, 0, 0, -1], slopes, offsets, bounds=limits)
        here, most = best.x[:3], best.x[3]
        if 2 * most < least:
            return 0.0
        if most - deepest < PRECISION / 2:
            break
    return 2 * float(deepest) if 2 * deepest >= least else 0.0


def separation(a: Shape, at_a: Pose, b: Shape, at_b: Pose, within: float) -> float:
    """Return a lower bound of the distance (m) of two shapes, at most `within` if they come that close.

    It is exact for spheres, capsules and parallel faces. Of an edge it is the distance from the planes of its faces,
    which is a few times smaller at a sharp edge. Meshes count as hulls. The method is that of `overlap`, with negative
    depths.
    """
    from scipy.optimize import linprog

    boxes = np.stack([bounds(a, at_a), bounds(b, at_b)])
    limits = [*zip(boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0), strict=True), (None, None)]
    here, slopes, offsets = boxes.mean(axis=(0, 1)), [], []
    most = np.inf
    for _ in range(200):
        depths = []
        for shape, pose in ((a, at_a), (b, at_b)):
            depth, slope = _depth(shape, pose, here)
            depths.append(depth)
            slopes.append([*-slope, 1.0])
            offsets.append(depth - slope @ here)
        if -2 * min(depths) <= within or most - min(depths) < PRECISION / 2:
            return -2 * min(depths)
        best = linprog([0, 0, 0, -1], slopes, offsets, bounds=limits)
        here, most = best.x[:3], best.x[3]
    return -2 * float(most)


def _mean_bound(slopes: Sequence[Any], offsets: Sequence[Any], low: Array, high: Array) -> float:
    """Return the maximum in a box of the mean of two planes: an upper bound of the smaller one, without a linear
    program. It is tight where two faces meet.
    """
    slope = -np.sum([row[:3] for row in slopes], axis=0) / 2
    return float(sum(offsets) / 2 + np.maximum(slope * low, slope * high).sum())


def _common(a: Shape, at_a: Pose, b: Shape, at_b: Pose) -> tuple[Array, Array]:
    """Return the lowest and highest corner (3,) of the intersection of two bounding boxes; inverted if empty."""
    boxes = np.stack([bounds(a, at_a), bounds(b, at_b)])
    return boxes[:, 0].max(axis=0), boxes[:, 1].min(axis=0)


def _flat(a: Shape, at_a: Pose, b: Shape, at_b: Pose, axes: Pose, least: float) -> bool:
    """Whether the bounding boxes along `axes` intersect by less than `least`, as where a box rests on another."""
    low, high = _common(a, compose(inverse(axes), at_a), b, compose(inverse(axes), at_b))
    return bool((high - low).min() < least)


def _depth(shape: Shape, pose: Pose, point: Array) -> tuple[float, Array]:
    """Return the depth (m) of a point below the surface (negative outside) and its gradient (3,)."""
    depth, slope = shape.depth_at(rotate(conjugate(pose.orientation), point - pose.position))
    return depth, rotate(pose.orientation, slope)
