"""Contacts of two bodies that forces do not move, of which engines report none: they follow from shapes and poses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Body, Geom, PassThrough, Pose, Scene, Trace, Vanish
from wmspec.sim.scene.model.bounds import bounds, world_box
from wmspec.sim.scene.model.transform import compose, conjugate, identity, rotate
from wmspec.sim.scene.physics.contact import colliders, non_colliding_pairs
from wmspec.sim.scene.physics.overlap import separation
from wmspec.sim.shapes import Shape

#: m: bodies that come closer than this touch.
TOUCH_DISTANCE = 1e-4


def moves_freely(*bodies: Body) -> bool:
    """Whether one of the bodies is dynamic, so that engines report its contacts."""
    return any(body.motion == "dynamic" for body in bodies)


def first_touch(scene: Scene, trace: Trace, a: str, b: str, samples: slice) -> float | None:
    """Return the time (s) of the first of the samples in which two bodies touch, or None.

    Neither body may be dynamic.
    """
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    i, j = index[a], index[b]
    if (min(i, j), max(i, j)) in non_colliding_pairs(scene):
        return None
    open_to_contact = _can_touch(scene, trace.time, {a, b})
    one, other = colliders(scene.bodies[i]), colliders(scene.bodies[j])
    way = _path_length(trace, i, scene.bodies[i]) + _path_length(trace, j, scene.bodies[j])
    first, last = samples.start, samples.stop
    while first < last:
        gap = clearance(one, _pose(trace, first, i), other, _pose(trace, first, j))
        if gap <= TOUCH_DISTANCE and open_to_contact[first]:
            return float(trace.time[first])
        # Until both have moved this far, they cannot touch.
        first = max(first + 1, int(np.searchsorted(way, way[first] + max(gap - TOUCH_DISTANCE, 0.0))))
    return None


def _can_touch(scene: Scene, times: Array, pair: set[str]) -> NDArray[np.bool_]:
    """Return in which samples (T,) two bodies can touch: neither has vanished or passes through the other."""
    able = np.ones(len(times), bool)
    for action in scene.actions:
        if isinstance(action, Vanish) and action.body in pair:
            able &= times < action.start
        if isinstance(action, PassThrough) and {action.body, action.through} == pair:
            able &= (times < action.start) | (times >= action.stop)
    return able


def _path_length(trace: Trace, i: int, body: Body) -> Array:
    """Return an upper bound (T,), m, of the way that any point of a body has moved since the start."""
    low, high = world_box(body.geoms, identity())
    reach = float(np.linalg.norm(np.maximum(np.abs(low), np.abs(high))))
    position, turn = trace.position[:, i], trace.orientation[:, i]
    cosines = np.abs((turn[1:] * turn[:-1]).sum(axis=1)).clip(max=1.0)
    steps = np.linalg.norm(np.diff(position, axis=0), axis=1) + 2 * reach * np.arccos(cosines)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _pose(trace: Trace, sample: int, i: int) -> Pose:
    return Pose(trace.position[sample, i], trace.orientation[sample, i])


def clearance(one: Sequence[Geom], here: Pose, other: Sequence[Geom], there: Pose) -> float:
    """Return a lower bound of the distance (m) of two bodies that is at most `TOUCH_DISTANCE` only if they touch."""
    least = np.inf
    for gap, a, at_a, b, at_b in sorted(_piece_pairs(one, here, other, there), key=lambda pair: pair[0]):
        if gap >= least or least <= TOUCH_DISTANCE:
            break
        bound = gap if gap > TOUCH_DISTANCE else separation(a.shape, at_a, b.shape, at_b, TOUCH_DISTANCE)
        least = min(least, bound)
    return float(least)


def _piece_pairs(
    one: Sequence[Geom], here: Pose, other: Sequence[Geom], there: Pose
) -> Iterator[tuple[float, Geom, Pose, Geom, Pose]]:
    """Yield pairs of geoms with their poses, and a lower bound (m) of their distance that is quick to compute.

    It is the larger one of the distance of their axis-aligned boxes and the gap along the line of their origins.
    """
    placed = [
        [(geom, pose, bounds(geom.shape, pose)) for geom in geoms for pose in (compose(at, geom.pose),)]
        for geoms, at in ((one, here), (other, there))
    ]
    for a, at_a, box_a in placed[0]:
        for b, at_b, box_b in placed[1]:
            apart = np.maximum(np.maximum(box_a[0] - box_b[1], box_b[0] - box_a[1]), 0.0)
            gap = max(float(np.linalg.norm(apart)), _gap_between_origins(a.shape, at_a, b.shape, at_b))
            yield gap, a, at_a, b, at_b


def _gap_between_origins(a: Shape, at_a: Pose, b: Shape, at_b: Pose) -> float:
    """Return the distance (m) of two shapes in projection on the line of their origins, negative if they overlap."""
    line = at_b.position - at_a.position
    length = float(np.linalg.norm(line))
    if length == 0:
        return -np.inf
    reaches = (
        shape.reach(tuple(rotate(conjugate(pose.orientation), side * line / length)))
        for shape, pose, side in ((a, at_a, 1.0), (b, at_b, -1.0))
    )
    return length - sum(reaches)
