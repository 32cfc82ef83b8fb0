"""Transforms of the stage in metres and Z up, as a rigid pose and a remaining stretch."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Tf, Usd, UsdGeom, UsdPhysics

from wmspec.core.diagnostics import Report
from wmspec.sim.scene.model import Array, Pose
from wmspec.sim.usd.prims import NOW, refuse, static_value, value

_ORTHOGONAL = 1e-6
_RESET = "!resetXformStack!"
_UPRIGHT = {"Y": Gf.Rotation(Gf.Vec3d(1, 0, 0), 90), "X": Gf.Rotation(Gf.Vec3d(0, 1, 0), -90)}
"""Up axis -> rotation to Z."""


@dataclass(frozen=True)
class SplitTransform:
    """A transform as a `rigid` part, applied last, and the `stretch` before it (row vectors, as in Gf)."""

    rigid: Gf.Matrix4d
    stretch: Gf.Matrix4d

    @property
    def pose(self) -> Pose:
        """Return the rigid part."""
        return Pose(vector(self.rigid.ExtractTranslation()), quaternion(self.rigid.ExtractRotationQuat()))


def vector(v: Gf.Vec3d) -> Array:
    """Return a Gf vector as an array (3,)."""
    x, y, z = v
    return np.array((x, y, z), np.float64)


def operations(prim: Usd.Prim) -> list[Usd.Attribute]:
    """Return the xform operations of a prim.

    Raises: StageError: if xformOpOrder names a missing one, which USD would ignore.
    """
    names = [name.removeprefix("!invert!") for name in value(prim, "xformOpOrder", ()) if name != _RESET]
    for name in names:
        if not name.startswith("xformOp:") or not prim.HasAttribute(name):
            refuse(prim, f"its xformOpOrder names {name}, which it does not have", "author it or remove the name")
    return [prim.GetAttribute(name) for name in names]


def quaternion(q: Gf.Quatd) -> Array:
    """Return a Gf quaternion as a unit (w, x, y, z) with w >= 0."""
    x, y, z = q.imaginary
    w = q.real
    length = math.copysign(math.sqrt(w * w + x * x + y * y + z * z), w)
    return np.array((w / length, x / length, y / length, z / length))


def split_transform(matrix: Gf.Matrix4d, prim: Usd.Prim) -> SplitTransform:
    """Split a transform into rotation and translation, and the scale, reflection and shear before them.

    Raises: StageError: if the transform is singular.
    """
    rows = [matrix.GetRow3(i) for i in range(3)]
    lengths = [row.Normalize() for row in rows]
    if not min(lengths) > 0 or not abs(matrix.GetDeterminant3()) > 0:
        refuse(prim, "its transform has scale zero", "author a scale that is not zero")
    if max(abs(rows[0] * rows[1]), abs(rows[1] * rows[2]), abs(rows[2] * rows[0])) > _ORTHOGONAL:
        rigid = matrix.RemoveScaleShear()
    else:
        if matrix.GetDeterminant3() < 0:
            rows[0] = -rows[0]
        rigid = Gf.Matrix4d().SetIdentity()
        for i, row in enumerate(rows):
            rigid.SetRow3(i, row)
        rigid.SetTranslateOnly(matrix.ExtractTranslation())
    return SplitTransform(rigid, matrix * rigid.GetInverse())


class StageFrame:
    """Converts stage coordinates to metres, kilograms, Z up; invalid units go to `problems`."""

    def __init__(self, stage: Usd.Stage, problems: Report) -> None:
        self.meters = self.kilograms = 1.0
        with problems.collect_errors():
            self.meters = _unit(stage, "metersPerUnit", UsdGeom.GetStageMetersPerUnit(stage))
        with problems.collect_errors():
            self.kilograms = _unit(stage, "kilogramsPerUnit", UsdPhysics.GetStageKilogramsPerUnit(stage))
        self.upright = Gf.Matrix4d(
            _UPRIGHT.get(UsdGeom.GetStageUpAxis(stage), Gf.Rotation(Gf.Vec3d(0, 0, 1), 0)), (0, 0, 0)
        )
        self.units = Gf.Matrix4d().SetScale(self.meters) * self.upright
        self._cache = UsdGeom.XformCache(NOW)

    def matrix(self, prim: Usd.Prim) -> Gf.Matrix4d:
        """Return the transform from prim coordinates to the world."""
        return _placed(self._cache.GetLocalToWorldTransform, prim) * self.units

    def parent(self, prim: Usd.Prim) -> Gf.Matrix4d:
        """Return the transform from the parent's coordinates to the world."""
        if self._cache.GetLocalTransformation(prim)[1]:
            return self.units
        return _placed(self._cache.GetParentToWorldTransform, prim) * self.units

    def direction(self, v: Gf.Vec3d) -> Array:
        """Return a vector (3,) of stage axes rotated to world axes, not scaled."""
        return vector(self.upright.TransformDir(Gf.Vec3d(v)))


def _unit(stage: Usd.Stage, name: str, number: float) -> float:
    if not 0 < number < math.inf:
        refuse(stage.GetPseudoRoot(), f"{name} = {number:g}", "author a finite number above 0")
    return number


def _placed(compute: Callable[[Usd.Prim], Gf.Matrix4d], prim: Usd.Prim) -> Gf.Matrix4d:
    """Return the transform of a prim. Raises StageError if an xform operation is missing or not finite."""
    try:
        matrix = compute(prim)
        if np.isfinite(np.asarray(matrix)).all():
            return matrix
    except Tf.ErrorException:  # USD does not name the prim
        pass
    above = prim
    while above:
        for operation in operations(above):
            static_value(operation)
        above = above.GetParent()
    refuse(prim, "its transform is not finite", "author smaller numbers")
