"""How deep two convex shapes lie in one another: the diameter of the largest ball that fits into both."""

from __future__ import annotations

from math import hypot

import numpy as np

from wmspec.scene.bounds import bounds
from wmspec.scene.hull import solid
from wmspec.scene.model import Array, Box, Capsule, Cone, Cylinder, Mesh, Pose, Shape, Sphere
from wmspec.scene.transform import conjugate, rotate

#: The answer is exact to this (m).
PRECISION = 1e-5


def overlap(a: Shape, at_a: Pose, b: Shape, at_b: Pose, least: float) -> float:
    """The diameter (m) of the largest ball within both shapes; 0 if it is less than `least`. Meshes count as hulls.

    The depth of a point below the surface of a convex shape is a concave function of the point. So is the smaller of
    two such depths, and its maximum is found by cutting planes (Kelley, J. SIAM 8, 1960).
    """
    from scipy.optimize import linprog

    boxes = np.stack([bounds(a, at_a), bounds(b, at_b)])
    low, high = boxes[:, 0].max(axis=0), boxes[:, 1].min(axis=0)
    if (high - low).min() < least:
        return 0.0
    limits = [*zip(low, high, strict=True), (None, None)]
    here, slopes, offsets = (low + high) / 2, [], []
    found = -np.inf
    for _ in range(200):
        for shape, pose in ((a, at_a), (b, at_b)):
            depth, slope = _depth(shape, pose, here)
            slopes.append([*-slope, 1.0])
            offsets.append(depth - slope @ here)
        found = max(found, min(offsets[i] - np.dot(slopes[i][:3], here) for i in (-2, -1)))
        best = linprog([0, 0, 0, -1], slopes, offsets, bounds=limits)
        here, most = best.x[:3], best.x[3]
        if 2 * most < least:
            return 0.0
        if most - found < PRECISION / 2:
            break
    return 2 * float(found) if 2 * found >= least else 0.0


def _depth(shape: Shape, pose: Pose, point: Array) -> tuple[float, Array]:
    """How far (m) a point is below the surface (negative: outside) and how that grows with the point (3,)."""
    depth, slope = _local(shape, rotate(conjugate(pose.orientation), point - pose.position))
    return depth, rotate(pose.orientation, slope)


def _local(shape: Shape, p: Array) -> tuple[float, Array]:
    if isinstance(shape, Sphere):
        return _round(shape.radius, p)
    if isinstance(shape, Capsule):
        return _round(shape.radius, p - [0.0, 0.0, np.clip(p[2], -shape.height / 2, shape.height / 2)])
    return min(_sides(shape, p), key=lambda side: side[0])


def _sides(shape: Shape, p: Array) -> list[tuple[float, Array]]:
    across = p * [1.0, 1.0, 0.0]
    match shape:
        case Box():
            half = np.asarray(shape.half, float)
            return [_plane(s * axis, h, p) for axis, h in zip(np.eye(3), half, strict=True) for s in (-1.0, 1.0)]
        case Cylinder():
            z = np.array([0.0, 0.0, 1.0])
            caps = [_plane(s * z, shape.height / 2, p) for s in (-1.0, 1.0)]
            return [*caps, _round(shape.radius, across)]
        case Cone():
            slant = hypot(shape.radius, shape.height)
            depth, inwards = _round(0.0, across)
            side = (depth * shape.height + (shape.height / 2 - p[2]) * shape.radius) / slant
            slope = (inwards * shape.height - np.array([0.0, 0.0, shape.radius])) / slant
            return [_plane(np.array([0.0, 0.0, -1.0]), shape.height / 2, p), (float(side), slope)]
        case Mesh():
            hull = solid(shape)
            offsets = np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0])
            depths = offsets - hull.face_normals @ p
            i = int(depths.argmin())
            return [(float(depths[i]), -np.asarray(hull.face_normals[i]))]
    raise AssertionError(shape)


def _plane(normal: Array, offset: float, p: Array) -> tuple[float, Array]:
    return float(offset - normal @ p), -normal


def _round(radius: float, away: Array) -> tuple[float, Array]:
    distance = float(np.linalg.norm(away))
    return radius - distance, -away / distance if distance > 0 else np.zeros(3)
