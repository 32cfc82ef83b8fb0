"""How jointed bodies begin to move: as their joints let them, with the momentum that the stage gives them.

What the given velocities ask of a joint that it can't follow, its impulse takes away, as Gauss's principle has it: of
all velocities that the joints let be, these are the nearest by kinetic energy.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import jointed, ties
from wmspec.sim.scene.joints.com_frame import com_frame
from wmspec.sim.scene.joints.coordinates import Coordinates, coordinates, gears
from wmspec.sim.scene.model import Array, Body, Scene
from wmspec.sim.scene.model.transform import apply, cross

NEARLY = 1e-3
"""The part of its velocity, and m/s or rad/s, by which a body may be off what its joints let be."""


def started(scene: Scene) -> tuple[Scene, tuple[Diagnostic, ...]]:
    """The scene whose jointed bodies begin as their joints let them, and what that changed, as warnings."""
    found = _allowed(scene)
    told = tuple(replace(d, message=f"{d.message}: it begins so", severity="warning") for d in misfits(scene, found))
    bodies = tuple(
        replace(body, linear_velocity=found[i][:3], angular_velocity=found[i][3:]) if i in found else body
        for i, body in enumerate(scene.bodies)
    )
    return replace(scene, bodies=bodies), told


def misfits(scene: Scene, allowed: dict[int, Array] | None = None) -> Iterator[Diagnostic]:
    """The jointed bodies that begin as their joints do not let them."""
    between = {joint.path for joint in scene.joints}  # the light bodies of chains, which nobody gave a velocity
    for i, velocity in (_allowed(scene) if allowed is None else allowed).items():
        body = scene.bodies[i]
        off = np.abs(velocity - _velocity(body)).max()
        if off > NEARLY * (1 + np.abs(_velocity(body)).max()) and body.path not in between:
            (was, turned), (now, turns) = ((v[:3], v[3:]) for v in (_velocity(body), velocity))
            reason = (
                f"{_text(was)} m/s and {_text(turned)} rad/s at the start are not what its joints let be, which is "
            )
            help_ = "give all that is joined velocities that fit"
            yield Diagnostic(f"{reason}{_text(now)} m/s and {_text(turns)} rad/s", PrimPlace(body.path), help_)


def _text(vector: Array) -> str:
    return f"({', '.join(f'{float(x) + 0.0:.4g}' for x in np.round(vector, 6))})"


def _velocity(body: Body) -> Array:
    return np.concatenate([body.linear_velocity, body.angular_velocity])


def _allowed(scene: Scene) -> dict[int, Array]:
    """The velocities (6,) of jointed bodies that are nearest to their own, by number; none if all are at rest."""
    tied = jointed(scene)
    if not any(_velocity(body).any() for body in scene.bodies if body.name in tied):
        return {}
    every = coordinates(scene)
    moves = every.ways.T @ _null(_constraints(scene, every))
    wanted = np.concatenate([_velocity(scene.bodies[i]) for i in every.bodies])
    pulled = moves.T @ every.masses
    rates = np.linalg.lstsq(pulled @ moves, pulled @ wanted, rcond=None)[0]
    return dict(zip(every.bodies, (moves @ rates).reshape(-1, 6), strict=True))


def _constraints(scene: Scene, every: Coordinates) -> Array:
    """What must vanish of the coordinates' rates, as rows: of points that close loops, and of mimics."""
    rows = [np.zeros(len(every.holders))]
    for tie in ties(scene):
        for one, other in zip(tie.above, tie.below, strict=True):
            apart = _point(scene, tie.first, one, every.bodies) - _point(scene, tie.second, other, every.bodies)
            rows += list(apart @ every.ways.T)
    rows += [every.along(gear.body) - gear.ratio * every.along(gear.leader) for gear in gears(scene)]
    return np.array(rows)


def _point(scene: Scene, body: int, point: tuple[float, ...], order: tuple[int, ...]) -> Array:
    """The velocity (3, 6 N) of a point in a body's centre-of-mass frame; the world's never moves."""
    rows = np.zeros((3, 6 * len(order)))
    if body >= 0:
        frame, at = com_frame(scene.bodies[body]).pose, 6 * order.index(body)
        arm = apply(frame, np.array(point)) - frame.position
        rows[:, at : at + 3] = np.eye(3)
        rows[:, at + 3 : at + 6] = np.array([cross(axis, arm) for axis in np.eye(3)]).T
    return rows


def _null(matrix: Array) -> Array:
    """The vectors (n, k) that the matrix (m, n) makes vanish."""
    _, sizes, vectors = np.linalg.svd(matrix)
    rank = int((sizes > 1e-9 * max(1.0, *sizes)).sum())
    null: Array = vectors[rank:].T
    return null
