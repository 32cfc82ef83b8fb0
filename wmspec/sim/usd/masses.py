"""Mass properties by the rules of UsdPhysics (`PhysicsMassAPI`).

A body's mass beats its colliders' masses, which beat densities; a collider's density beats its body's, which beats its
material's, which beats 1000 kg/m³. Of the rest, what is authored is taken and what is not is computed from the shapes;
only principal axes without moments mean nothing, and moments without axes are along the prim's own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pxr import Gf, Usd

from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Array, Inertia, Motion, Pose
from wmspec.sim.scene.model.transform import multiply, rotation
from wmspec.sim.scene.physics.decompose import whole
from wmspec.sim.scene.physics.inertia import inertia, principal
from wmspec.sim.shapes import Mesh, Shape, Sphere
from wmspec.sim.usd.colliders import as_hull, collider
from wmspec.sim.usd.frames import Place, World, quaternion, vector
from wmspec.sim.usd.prims import refuse, value
from wmspec.sim.usd.shapes import Placed
from wmspec.sim.usd.substitutions import STRICT, Notes

LONE, LONE_RADIUS = 1.0, 0.1
"""The mass (kg) and, as of a ball, the radius (m) of a body that says neither and has no colliders: as PhysX has it."""

WATER = 1000.0
"""The density (kg/m³) of what has none authored: UsdPhysics, PhysicsMassAPI, physics:density."""


def body_inertia(
    prim: Usd.Prim,
    place: Place,
    colliders: Sequence[tuple[Placed, float]],
    world: World,
    seen: Sequence[tuple[Shape, Pose]] = (),
    notes: Notes = STRICT,
) -> Inertia:
    """The mass properties of the dynamic body `prim`, in its own frame; `colliders` with their materials' densities.

    `seen`: what is drawn of it and where, which tells how the mass of a body without colliders is spread.

    Raises:
        StageError: if they are not positive or can't be computed.
    """
    mass = _amount(prim, "mass") * world.kilograms
    if not colliders:
        return _authored_alone(prim, place, mass, world, seen, notes)
    common = _amount(prim, "density")
    parts = [_collider_inertia(c, common or own, world, notes) for c, own in colliders]
    total = parts[0] if len(parts) == 1 else _merge(parts)
    if mass:
        total = replace(total, mass=mass, moments=total.moments * (mass / total.mass))
    return _override(prim, Place(Gf.Matrix4d(1.0), place.stretch), total, world, notes)


def _collider_inertia(c: Placed, density: float, world: World, notes: Notes) -> Inertia:
    mass = _amount(c.prim, "mass") * world.kilograms
    per_volume = (_amount(c.prim, "density") or density) * world.kilograms / world.meters**3
    try:
        if isinstance(c.shape, Mesh) and not as_hull(c.prim, c.shape):
            way: Motion = "static" if notes.strict else "dynamic"
            size, unit = whole(
                c.shape, c.pose, lambda: [s for s, _ in collider(c, way, notes=notes) if isinstance(s, Mesh)]
            )
            mass = mass or (per_volume or WATER) * size
            own = replace(unit, mass=mass, moments=unit.moments * mass)
        else:
            own = inertia([(c.shape, c.pose, mass or (per_volume or WATER) * c.shape.volume)])
    except WmsError as error:
        refuse(c.prim, str(error), "author a shape with a volume")
    return _override(c.prim, c.place, own, world, notes)


def _override(prim: Usd.Prim, place: Place, computed: Inertia, world: World, notes: Notes) -> Inertia:
    """The computed mass properties with the centre and the moments that are authored on the prim."""
    center, moments = _center(prim, place), _moments(prim, world, notes)
    if moments is not None:
        axes = multiply(quaternion(place.rigid.ExtractRotationQuat()), _axes(prim))
        return Inertia(computed.mass, computed.center if center is None else center, axes, moments)
    if center is None:
        return computed
    axes, about = principal(_tensor(computed) + _steiner(computed.mass, center - computed.center))
    return Inertia(computed.mass, center, axes, about)


def _authored_alone(
    prim: Usd.Prim, place: Place, mass: float, world: World, seen: Sequence[tuple[Shape, Pose]], notes: Notes
) -> Inertia:
    moments = _moments(prim, world, notes)
    if not mass or moments is None:
        taken = f"it has {mass or LONE:g} kg" + ("" if moments is not None else _spread(seen))
        remedy = "give it a collider, or mass and diagonalInertia"
        notes.instead(prim, "a dynamic body without colliders has no mass", taken, remedy)
        mass = mass or LONE
    if moments is None:
        parts = [(shape, pose, mass * shape.volume / sum(s.volume for s, _ in seen)) for shape, pose in seen]
        ball = Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
        spread = inertia(parts or [(Sphere(LONE_RADIUS), ball, mass)])
        return _override(prim, Place(Gf.Matrix4d(1.0), place.stretch), spread, world, notes)
    center = _center(prim, Place(Gf.Matrix4d(1.0), place.stretch))
    return Inertia(mass, np.zeros(3) if center is None else center, _axes(prim), moments)


def _spread(seen: Sequence[tuple[Shape, Pose]]) -> str:
    return ", spread as what is drawn of it" if seen else f", spread as in a ball of {LONE_RADIUS:g} m"


def _amount(prim: Usd.Prim, name: str) -> float:
    """The mass or density in the stage's units; 0 if it is left to others."""
    amount = float(value(prim, f"physics:{name}", 0.0))
    if not 0 <= amount < math.inf:
        refuse(prim, f"physics:{name} = {amount:g}", f"expected a {name} above 0, or 0 to have it computed")
    return amount


def _center(prim: Usd.Prim, place: Place) -> Array | None:
    center = value(prim, "physics:centerOfMass")
    if center is None or all(number == -math.inf for number in center):  # the fallback of the schema
        return None
    if not all(map(math.isfinite, center)):
        refuse(prim, f"physics:centerOfMass = {center} is not finite", "author finite numbers, or remove it")
    return vector((place.stretch * place.rigid).Transform(Gf.Vec3d(center)))


def _moments(prim: Usd.Prim, world: World, notes: Notes) -> Array | None:
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
        notes.instead(
            prim, what, f"its largest is {excess:.2g} % above the sum of the others, which is taken", expected
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
    """The parts as one rigid body."""
    mass = sum(part.mass for part in parts)
    center = np.sum([part.mass * part.center for part in parts], axis=0) / mass
    tensor = np.sum([_tensor(part) + _steiner(part.mass, part.center - center) for part in parts], axis=0)
    axes, moments = principal(tensor)
    return Inertia(mass, center, axes, moments)
