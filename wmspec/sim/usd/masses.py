"""Mass properties by the rules of UsdPhysics (`PhysicsMassAPI`).

The mass of a body overrides masses of its colliders, which override densities; the density of a collider overrides that
of the body, then the material, then 1000 kg/m³. Authored values are used, others are computed from the shapes.
Principal axes without moments are ignored; moments without axes are along the prim's axes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pxr import Gf, Usd

from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Array, Inertia, Motion, Pose
from wmspec.sim.scene.model.bounds import bounds
from wmspec.sim.scene.model.transform import multiply, rotation
from wmspec.sim.scene.physics.decompose import mesh_mass_properties
from wmspec.sim.scene.physics.gyration import (
    excess_text,
    farthest_corner,
    gyration_excess,
    is_implausible,
    is_impossible,
)
from wmspec.sim.scene.physics.inertia import inertia, principal
from wmspec.sim.shapes import Mesh, Shape, Sphere
from wmspec.sim.usd.colliders import collides_as_hull, collision_shapes
from wmspec.sim.usd.frames import SplitTransform, StageFrame, quaternion, vector
from wmspec.sim.usd.prims import refuse, value
from wmspec.sim.usd.shapes import PlacedShape
from wmspec.sim.usd.substitutions import STRICT, Substitutions

DEFAULT_MASS, DEFAULT_RADIUS = 1.0, 0.1
"""kg and, as a ball, m: a body without mass and colliders, as in PhysX."""

INERTIA, AUTHORED = "wms:inertia", "authored"
"""Attribute of a body, and its value, that keeps moments of inertia that no body of its mass and size can have."""

DEFAULT_DENSITY = 1000.0
"""kg/m³: the fallback of UsdPhysics, PhysicsMassAPI, physics:density."""


def body_inertia(
    prim: Usd.Prim,
    place: SplitTransform,
    colliders: Sequence[tuple[PlacedShape, float]],
    world: StageFrame,
    seen: Sequence[tuple[Shape, Pose]] = (),
    notes: Substitutions = STRICT,
) -> Inertia:
    """Return the mass properties of the dynamic body `prim` in its frame; `colliders` with material densities.

    `seen`: its visible shapes and poses, which determine the mass distribution of a body without colliders.

    Raises: StageError: if they are not positive or cannot be computed.
    """
    mass = _amount(prim, "mass") * world.kilograms
    if not colliders:
        return _authored_alone(prim, place, mass, world, seen, notes)
    common = _amount(prim, "density")
    parts = [_collider_inertia(c, common or own, world, notes) for c, own in colliders]
    total = parts[0] if len(parts) == 1 else _merge(parts)
    if mass:
        total = replace(total, mass=mass, moments=total.moments * (mass / total.mass))
    return _override(prim, SplitTransform(Gf.Matrix4d(1.0), place.stretch), total, world, notes)


def plausible_inertia(
    prim: Usd.Prim,
    authored: Inertia,
    solid: Sequence[tuple[Shape, Pose]],
    seen: Sequence[tuple[Shape, Pose]],
    notes: Substitutions,
) -> Inertia:
    """Return the authored mass properties of a body, with moments of its shapes if the authored ones are impossible.

    `solid` are the shapes that collide, `seen` those that collide or are drawn. `wms:inertia = "authored"` keeps the
    moments.
    """
    if not seen or value(prim, INERTIA, "") == AUTHORED:
        return authored
    boxes = np.stack([bounds(shape, pose) for shape, pose in seen])
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    times = gyration_excess(authored.mass, authored.moments, farthest_corner(low, high, authored.center))
    if not is_implausible(times) or (notes.strict and not is_impossible(times)):
        return authored
    if not is_impossible(times):
        notes.record(prim, excess_text(times), "it is used", "correct it")
        return authored
    notes.record(
        prim, excess_text(times), "that of its shapes is used", f'correct it, or author {INERTIA} = "{AUTHORED}"'
    )
    volume = sum(shape.volume for shape, _ in solid or seen)
    made = inertia([(shape, pose, authored.mass * shape.volume / volume) for shape, pose in solid or seen])
    return replace(made, center=authored.center)


def _collider_inertia(c: PlacedShape, density: float, world: StageFrame, notes: Substitutions) -> Inertia:
    mass = _amount(c.prim, "mass") * world.kilograms
    per_volume = (_amount(c.prim, "density") or density) * world.kilograms / world.meters**3
    try:
        if isinstance(c.shape, Mesh) and not collides_as_hull(c.prim, c.shape):
            way: Motion = "static" if notes.strict else "dynamic"
            size, unit = mesh_mass_properties(
                c.shape, c.pose, lambda: [s for s, _ in collision_shapes(c, way, notes=notes) if isinstance(s, Mesh)]
            )
            mass = mass or (per_volume or DEFAULT_DENSITY) * size
            own = replace(unit, mass=mass, moments=unit.moments * mass)
        else:
            own = inertia([(c.shape, c.pose, mass or (per_volume or DEFAULT_DENSITY) * c.shape.volume)])
    except WmsError as error:
        refuse(c.prim, str(error), "author a shape with a volume")
    return _override(c.prim, c.place, own, world, notes)


def _override(
    prim: Usd.Prim, place: SplitTransform, computed: Inertia, world: StageFrame, notes: Substitutions
) -> Inertia:
    """Return the mass properties with the authored centre and moments of the prim."""
    center, moments = _center(prim, place), _moments(prim, world, notes)
    if moments is not None:
        axes = multiply(quaternion(place.rigid.ExtractRotationQuat()), _axes(prim))
        return Inertia(computed.mass, computed.center if center is None else center, axes, moments)
    if center is None:
        return computed
    axes, about = principal(_tensor(computed) + _steiner(computed.mass, center - computed.center))
    return Inertia(computed.mass, center, axes, about)


def _authored_alone(
    prim: Usd.Prim,
    place: SplitTransform,
    mass: float,
    world: StageFrame,
    seen: Sequence[tuple[Shape, Pose]],
    notes: Substitutions,
) -> Inertia:
    moments = _moments(prim, world, notes)
    if not mass or moments is None:
        taken = f"it has {mass or DEFAULT_MASS:g} kg" + ("" if moments is not None else _spread(seen))
        remedy = "give it a collider, or mass and diagonalInertia"
        notes.record(prim, "a dynamic body without colliders has no mass", taken, remedy)
        mass = mass or DEFAULT_MASS
    if moments is None:
        parts = [(shape, pose, mass * shape.volume / sum(s.volume for s, _ in seen)) for shape, pose in seen]
        ball = Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
        spread = inertia(parts or [(Sphere(DEFAULT_RADIUS), ball, mass)])
        return _override(prim, SplitTransform(Gf.Matrix4d(1.0), place.stretch), spread, world, notes)
    center = _center(prim, SplitTransform(Gf.Matrix4d(1.0), place.stretch))
    return Inertia(mass, np.zeros(3) if center is None else center, _axes(prim), moments)


def _spread(seen: Sequence[tuple[Shape, Pose]]) -> str:
    return ", distributed over its visible shapes" if seen else f", distributed as in a ball of {DEFAULT_RADIUS:g} m"


def _amount(prim: Usd.Prim, name: str) -> float:
    """Return mass or density in stage units; 0 if it is not authored."""
    amount = float(value(prim, f"physics:{name}", 0.0))
    if not 0 <= amount < math.inf:
        refuse(prim, f"physics:{name} = {amount:g}", f"expected a {name} above 0, or 0 to have it computed")
    return amount


def _center(prim: Usd.Prim, place: SplitTransform) -> Array | None:
    center = value(prim, "physics:centerOfMass")
    if center is None or all(number == -math.inf for number in center):  # schema fallback
        return None
    if not all(map(math.isfinite, center)):
        refuse(prim, f"physics:centerOfMass = {center} is not finite", "author finite numbers or remove it")
    return vector((place.stretch * place.rigid).Transform(Gf.Vec3d(center)))


def _moments(prim: Usd.Prim, world: StageFrame, notes: Substitutions) -> Array | None:
    moments = np.array(value(prim, "physics:diagonalInertia", (0, 0, 0)), np.float64)
    if not moments.any():
        return None
    expected = "expected three moments, none above the others' sum"
    if not (moments > 0).all():
        refuse(prim, f"physics:diagonalInertia = {moments.tolist()}", expected)
    most = moments.sum() - moments.max()
    if moments.max() > most * (1 + 1e-6):
        excess = 100 * (moments.max() / most - 1)
        what = f"physics:diagonalInertia = {moments.tolist()}"
        notes.record(
            prim, what, f"its largest is {excess:.2g} % above the sum of the others; that sum is used", expected
        )
        moments = np.minimum(moments, most)
    return np.asarray(moments * (world.kilograms * world.meters**2))


def _axes(prim: Usd.Prim) -> Array:
    axes = value(prim, "physics:principalAxes")
    return quaternion(axes) if axes and axes.GetLength() > 0 else np.array((1.0, 0.0, 0.0, 0.0))


def _tensor(part: Inertia) -> Array:
    turn = rotation(part.axes)
    return np.asarray(turn @ np.diag(part.moments) @ turn.T)


def _steiner(mass: float, arm: Array) -> Array:
    return np.asarray(mass * (arm @ arm * np.eye(3) - np.outer(arm, arm)))


def _merge(parts: Sequence[Inertia]) -> Inertia:
    """Return the parts as one rigid body."""
    mass = sum(part.mass for part in parts)
    center = np.sum([part.mass * part.center for part in parts], axis=0) / mass
    tensor = np.sum([_tensor(part) + _steiner(part.mass, part.center - center) for part in parts], axis=0)
    axes, moments = principal(tensor)
    return Inertia(mass, center, axes, moments)
