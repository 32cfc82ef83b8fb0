"""The geometries of USD as shapes: one function per type of prim."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd

from wmspec.scene.model import Array, Box, Capsule, Cone, Cylinder, Mesh, Pose, Shape, Sphere
from wmspec.usd.frames import Place, quaternion, vector
from wmspec.usd.meshes import mesh
from wmspec.usd.prims import refuse, value

PLANE = (100.0, 1.0)
"""Width and thickness (m) of the box that stands for an infinite plane."""

_SAME = 1e-6
_HALF = math.sqrt(0.5)
_AXES = {"X": 0, "Y": 1, "Z": 2}
_TURNS = {
    ("X", 1): Gf.Quatd(_HALF, 0, _HALF, 0),
    ("X", -1): Gf.Quatd(_HALF, 0, -_HALF, 0),
    ("Y", 1): Gf.Quatd(_HALF, -_HALF, 0, 0),
    ("Y", -1): Gf.Quatd(_HALF, _HALF, 0, 0),
    ("Z", 1): Gf.Quatd(1, 0, 0, 0),
    ("Z", -1): Gf.Quatd(0, 1, 0, 0),
}
"""Axis and its sign -> the turn that brings our z there."""

_Scale = tuple[float, float, float]


@dataclass(frozen=True)
class Placed:
    """The geometry of a prim: `place` of the prim and `pose` of the shape are both in the body's frame."""

    prim: Usd.Prim
    place: Place
    shape: Shape
    pose: Pose


def placed(prim: Usd.Prim, place: Place) -> Placed:
    """The shape of a prim, in metres.

    Raises:
        StageError: if its numbers make no such shape, or its transform deforms it into something else.
    """
    if prim.GetTypeName() == "Mesh":
        return Placed(prim, place, mesh(prim, place.stretch), place.pose)
    scale = _scale(prim, place)
    shape, offset = SHAPES[prim.GetTypeName()](prim, scale)
    axis = value(prim, "axis", "Z")
    turn = place.rigid.ExtractRotationQuat() * _TURNS[axis, 1 if scale[_AXES[axis]] > 0 else -1]
    shift = place.rigid.ExtractTranslation() + turn.Transform(Gf.Vec3d(0, 0, offset))
    return Placed(prim, place, shape, Pose(vector(shift), quaternion(turn)))


def _scale(prim: Usd.Prim, place: Place) -> _Scale:
    """The scales along the prim's own axes, free of rounding noise so that equal shapes are equal."""
    rows = [place.stretch.GetRow3(i) for i in range(3)]
    sheared = any(abs(rows[i][j]) > _SAME * abs(rows[i][i]) for i in range(3) for j in range(3) if i != j)
    if sheared:
        refuse(prim, "its transform shears it", "scale along the prim's own axes only, or use a Mesh")
    x, y, z = (float(f"{rows[i][i]:.12g}") for i in range(3))
    return x, y, z


def _positive(prim: Usd.Prim, name: str, fallback: float) -> float:
    """The attribute, which is a size; as float, since USD's doubles may be numpy's."""
    size = float(value(prim, name, fallback))
    if not 0 < size < math.inf:
        refuse(prim, f"{name} = {size:g}", f"expected a {name} above 0")
    return size


def _cube(prim: Usd.Prim, scale: _Scale) -> tuple[Shape, float]:
    return Box(np.abs(scale) * (_positive(prim, "size", 2.0) / 2)), 0.0


def _sphere(prim: Usd.Prim, scale: _Scale) -> tuple[Shape, float]:
    return Sphere(_positive(prim, "radius", 1.0) * _uniform(prim, scale)), 0.0


def _capsule(prim: Usd.Prim, scale: _Scale) -> tuple[Shape, float]:
    factor = _uniform(prim, scale)
    height = float(value(prim, "height", 1.0))
    if not 0 <= height < math.inf:
        refuse(prim, f"height = {height:g}", "expected a height of at least 0")
    return Capsule(_radius(prim, 0.5) * factor, height * factor), 0.0


def _cylinder(prim: Usd.Prim, scale: _Scale) -> tuple[Shape, float]:
    across, along = _round(prim, scale)
    return Cylinder(_radius(prim, 1.0) * across, _positive(prim, "height", 2.0) * along), 0.0


def _cone(prim: Usd.Prim, scale: _Scale) -> tuple[Shape, float]:
    across, along = _round(prim, scale)
    return Cone(_positive(prim, "radius", 1.0) * across, _positive(prim, "height", 2.0) * along), 0.0


def _plane(_prim: Usd.Prim, _scale: _Scale) -> tuple[Shape, float]:
    """An infinite plane, as the top of a big box (`PLANE`)."""
    width, thickness = PLANE
    return Box(np.array((width, width, thickness)) / 2), -thickness / 2


SHAPES: dict[str, Callable[[Usd.Prim, _Scale], tuple[Shape, float]]] = {
    "Cube": _cube,
    "Sphere": _sphere,
    "Cylinder": _cylinder,
    "Cylinder_1": _cylinder,
    "Cone": _cone,
    "Capsule": _capsule,
    "Capsule_1": _capsule,
    "Plane": _plane,
}
"""Type of prim -> its shape along z, and how far along z the shape is from the prim's origin."""

GEOMETRIES = frozenset(SHAPES) | {"Mesh"}
"""The types of prims that `placed` reads."""


def _radius(prim: Usd.Prim, fallback: float) -> float:
    """The one radius of a prim that may have two."""
    if not prim.GetTypeName().endswith("_1"):
        return _positive(prim, "radius", fallback)
    top, bottom = _positive(prim, "radiusTop", fallback), _positive(prim, "radiusBottom", fallback)
    if not math.isclose(top, bottom, rel_tol=_SAME):
        refuse(prim, "its two radii differ", "use equal radii, a Cone or a Mesh")
    return top


def _round(prim: Usd.Prim, scale: _Scale) -> tuple[float, float]:
    """The scales across and along the axis."""
    along = _AXES[value(prim, "axis", "Z")]
    across = [abs(scale[i]) for i in range(3) if i != along]
    if not math.isclose(*across, rel_tol=_SAME):
        refuse(prim, "its scale makes its round section elliptic", "scale it equally across its axis, or use a Mesh")
    return across[0], abs(scale[along])


def _uniform(prim: Usd.Prim, scale: _Scale) -> float:
    across, along = _round(prim, scale)
    if not math.isclose(across, along, rel_tol=_SAME):
        refuse(prim, "its scale makes its round surface elliptic", "scale it equally along all axes, or use a Mesh")
    return across


def reach(found: Shape) -> Array:
    """Half-extents (3,) of a box around the shape's origin that holds it, in its own frame."""
    match found:
        case Box():
            return found.half
        case Sphere():
            return np.full(3, found.radius)
        case Capsule():
            return np.array((found.radius, found.radius, found.radius + found.height / 2))
        case Cylinder() | Cone():
            return np.array((found.radius, found.radius, found.height / 2))
        case Mesh():
            return np.asarray(np.abs(found.points).max(axis=0))
