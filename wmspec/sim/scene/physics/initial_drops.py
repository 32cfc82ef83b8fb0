"""What begins above something else that moves, and may land on it: a blow to what is caught between two others."""

from __future__ import annotations

import numpy as np

from wmspec.sim.scene.model import Array, Body, Scene
from wmspec.sim.scene.model.bounds import bounds, upright
from wmspec.sim.scene.model.transform import compose
from wmspec.sim.scene.physics.contact import apart, colliders, mix
from wmspec.sim.scene.regime_thresholds import BOUNCY

CLEAR = 1e-3  # m: what is nearer rests on it


def landings(scene: Scene) -> frozenset[tuple[int, int]]:
    """Pairs of bodies without joints, by their numbers: the first begins in the air above the second, and hardly
    bounces off it.
    """
    if not scene.gravity.any():
        return frozenset()
    axis = int(np.abs(scene.gravity).argmax())
    up, sides = -np.sign(scene.gravity[axis]), [i for i in range(3) if i != axis]
    jointed = {name for joint in scene.joints for name in (joint.first, joint.second)}
    free = [i for i, b in enumerate(scene.bodies) if b.motion == "dynamic" and colliders(b) and b.name not in jointed]
    if len(free) < 2:
        return frozenset()
    boxes = {i: upright(colliders(scene.bodies[i]), scene.bodies[i].pose) for i in free}
    owner, around = _around(scene)
    air = [i for i in free if not (_meet(boxes[i], around) & (owner != i)).any()]
    passing = apart(scene)
    return frozenset(
        (i, j)
        for i in air
        for j in free
        if (up * boxes[i][:, axis]).min() > (up * boxes[j][:, axis]).max()
        and _meet(boxes[i][:, sides], boxes[j][:, sides])
        and (min(i, j), max(i, j)) not in passing
        and dull(scene.bodies[i], scene.bodies[j])
    )


def _around(scene: Scene) -> tuple[Array, Array]:
    """Of all M pieces the numbers of their bodies (M,), and the upright boxes around them (M, 2, 3) m."""
    pieces = [(i, body, geom) for i, body in enumerate(scene.bodies) for geom in colliders(body)]
    made = [bounds(geom.shape, compose(body.pose, geom.pose)) for _, body, geom in pieces]
    return np.array([i for i, _, _ in pieces]), np.array(made)


def _meet(a: Array, b: Array) -> Array:
    """Whether a box (2, n) touches others (..., 2, n), or nearly."""
    meets = (a[0] < b[..., 1, :] + CLEAR) & (b[..., 0, :] < a[1] + CLEAR)
    return np.asarray(meets.all(axis=-1))


def dull(a: Body, b: Body) -> bool:
    """Whether two bodies hardly bounce off each other, or pieces of them don't."""
    return any(mix(g.friction, h.friction).restitution < BOUNCY for g in colliders(a) for h in colliders(b))
