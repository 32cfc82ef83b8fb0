"""Bodies that start in the air above another dynamic body and may land on it."""

from __future__ import annotations

import numpy as np

from wmspec.sim.scene.model import Array, Body, Scene
from wmspec.sim.scene.model.bounds import bounds, world_box
from wmspec.sim.scene.model.transform import compose
from wmspec.sim.scene.physics.contact import colliders, combine_friction, non_colliding_pairs
from wmspec.sim.scene.regime_thresholds import ELASTIC_RESTITUTION

REST_DISTANCE = 1e-3  # m: a smaller gap counts as resting


def initial_drops(scene: Scene) -> frozenset[tuple[int, int]]:
    """Return pairs of unjointed bodies: the first starts in the air above the second, with an inelastic impact."""
    if not scene.gravity.any():
        return frozenset()
    axis = int(np.abs(scene.gravity).argmax())
    up, sides = -np.sign(scene.gravity[axis]), [i for i in range(3) if i != axis]
    jointed = {name for joint in scene.joints for name in (joint.first, joint.second)}
    free = [i for i, b in enumerate(scene.bodies) if b.motion == "dynamic" and colliders(b) and b.name not in jointed]
    if len(free) < 2:
        return frozenset()
    boxes = {i: world_box(colliders(scene.bodies[i]), scene.bodies[i].pose) for i in free}
    owner, around = _around(scene)
    air = [i for i in free if not (_meet(boxes[i], around) & (owner != i)).any()]
    passing = non_colliding_pairs(scene)
    return frozenset(
        (i, j)
        for i in air
        for j in free
        if (up * boxes[i][:, axis]).min() > (up * boxes[j][:, axis]).max()
        and _meet(boxes[i][:, sides], boxes[j][:, sides])
        and (min(i, j), max(i, j)) not in passing
        and is_inelastic(scene.bodies[i], scene.bodies[j])
    )


def _around(scene: Scene) -> tuple[Array, Array]:
    """Return body numbers (M,) and axis-aligned boxes (M, 2, 3), m, of all colliding geoms."""
    pieces = [(i, body, geom) for i, body in enumerate(scene.bodies) for geom in colliders(body)]
    made = [bounds(geom.shape, compose(body.pose, geom.pose)) for _, body, geom in pieces]
    return np.array([i for i, _, _ in pieces]), np.array(made)


def _meet(a: Array, b: Array) -> Array:
    """Whether a box (2, n) is within `REST_DISTANCE` of others (..., 2, n)."""
    meets = (a[0] < b[..., 1, :] + REST_DISTANCE) & (b[..., 0, :] < a[1] + REST_DISTANCE)
    return np.asarray(meets.all(axis=-1))


def is_inelastic(a: Body, b: Body) -> bool:
    """Whether any pair of geoms of two bodies has low restitution."""
    return any(
        combine_friction(g.friction, h.friction).restitution < ELASTIC_RESTITUTION
        for g in colliders(a)
        for h in colliders(b)
    )
