"""Initial velocities of jointed bodies, projected onto the velocities that the joints allow.

By Gauss's principle, joint impulses remove the inconsistent part: the result is the nearest allowed velocity in kinetic
energy.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import jointed_bodies, loop_closures
from wmspec.sim.scene.joints.com_frame import com_frame
from wmspec.sim.scene.joints.coordinates import Coordinates, coordinates, mimic_constraints
from wmspec.sim.scene.model import Array, Body, Scene
from wmspec.sim.scene.model.transform import apply, cross

MAX_VELOCITY_ERROR = 1e-3
"""Relative error, and m/s or rad/s, up to which a velocity counts as consistent."""


def project_velocities(scene: Scene) -> tuple[Scene, tuple[Diagnostic, ...]]:
    """Return the scene with consistent initial velocities, and a warning for each body that changed."""
    found = _allowed(scene)
    warnings = tuple(
        replace(d, message=f"{d.message}: it is corrected", severity="warning")
        for d in inconsistent_velocities(scene, found)
    )
    bodies = tuple(
        replace(body, linear_velocity=found[i][:3], angular_velocity=found[i][3:]) if i in found else body
        for i, body in enumerate(scene.bodies)
    )
    return replace(scene, bodies=bodies), warnings


def inconsistent_velocities(scene: Scene, allowed: dict[int, Array] | None = None) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each jointed body whose initial velocity violates a joint."""
    between = {joint.path for joint in scene.joints}  # light bodies of chains without a velocity of their own
    for i, velocity in (_allowed(scene) if allowed is None else allowed).items():
        body = scene.bodies[i]
        off = np.abs(velocity - _velocity(body)).max()
        if off > MAX_VELOCITY_ERROR * (1 + np.abs(_velocity(body)).max()) and body.path not in between:
            (was, turned), (now, turns) = ((v[:3], v[3:]) for v in (_velocity(body), velocity))
            reason = f"{_text(was)} m/s and {_text(turned)} rad/s at the start violate its joints, which allow "
            help_ = "give all joined bodies consistent velocities"
            yield Diagnostic(f"{reason}{_text(now)} m/s and {_text(turns)} rad/s", PrimPlace(body.path), help_)


def _text(vector: Array) -> str:
    return f"({', '.join(f'{float(x) + 0.0:.4g}' for x in np.round(vector, 6))})"


def _velocity(body: Body) -> Array:
    return np.concatenate([body.linear_velocity, body.angular_velocity])


def _allowed(scene: Scene) -> dict[int, Array]:
    """Return the nearest consistent velocities (6,) of jointed bodies by number; empty if all are at rest."""
    tied = jointed_bodies(scene)
    if not any(_velocity(body).any() for body in scene.bodies if body.name in tied):
        return {}
    every = coordinates(scene)
    moves = every.ways.T @ _null(_constraints(scene, every))
    given = np.concatenate([_velocity(scene.bodies[i]) for i in every.bodies])
    pulled = moves.T @ every.masses
    rates = np.linalg.lstsq(pulled @ moves, pulled @ given, rcond=None)[0]
    return dict(zip(every.bodies, (moves @ rates).reshape(-1, 6), strict=True))


def _constraints(scene: Scene, every: Coordinates) -> Array:
    """Return constraints on coordinate rates as rows: loop closures and mimics."""
    rows = [np.zeros(len(every.holders))]
    for tie in loop_closures(scene):
        for one, other in zip(tie.above, tie.below, strict=True):
            apart = _point(scene, tie.first, one, every.bodies) - _point(scene, tie.second, other, every.bodies)
            rows += list(apart @ every.ways.T)
    rows += [every.along(gear.body) - gear.ratio * every.along(gear.leader) for gear in mimic_constraints(scene)]
    return np.array(rows)


def _point(scene: Scene, body: int, point: tuple[float, ...], order: tuple[int, ...]) -> Array:
    """Return the Jacobian (3, 6 N) of a point in a centre-of-mass frame; zero for the world."""
    rows = np.zeros((3, 6 * len(order)))
    if body >= 0:
        frame, at = com_frame(scene.bodies[body]).pose, 6 * order.index(body)
        arm = apply(frame, np.array(point)) - frame.position
        rows[:, at : at + 3] = np.eye(3)
        rows[:, at + 3 : at + 6] = np.array([cross(axis, arm) for axis in np.eye(3)]).T
    return rows


def _null(matrix: Array) -> Array:
    """Return a basis (n, k) of the null space of a matrix (m, n)."""
    _, sizes, vectors = np.linalg.svd(matrix)
    rank = int((sizes > 1e-9 * max(1.0, *sizes)).sum())
    null: Array = vectors[rank:].T
    return null
