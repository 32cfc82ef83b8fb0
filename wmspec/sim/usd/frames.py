"""Where things are: every transform of the stage in metres and Z up, as a rigid pose and what is left of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Tf, Usd, UsdGeom, UsdPhysics

from wmspec.core.diagnostics import Report
from wmspec.sim.scene.model import Array, Pose
from wmspec.sim.usd.prims import NOW, refuse, still, value

_ORTHOGONAL = 1e-6
_RESET = "!resetXformStack!"
_UPRIGHT = {"Y": Gf.Rotation(Gf.Vec3d(1, 0, 0), 90), "X": Gf.Rotation(Gf.Vec3d(0, 1, 0), -90)}
"""Up axis -> the rotation that brings it to Z."""


@dataclass(frozen=True)
class Place:
    """A transform as a rigid part, applied last, and the `stretch` before it (row vectors, as in Gf)."""

    rigid: Gf.Matrix4d
    stretch: Gf.Matrix4d

    @property
    def pose(self) -> Pose:
        """The rigid part."""
        return Pose(vector(self.rigid.ExtractTranslation()), quaternion(self.rigid.ExtractRotationQuat()))


def vector(v: Gf.Vec3d) -> Array:
    """A Gf vector as an array (3,)."""
    x, y, z = v
    return np.array((x, y, z), np.float64)


def operations(prim: Usd.Prim) -> list[Usd.Attribute]:
    """The operations of the prim's own transform.

    Raises:
        StageError: if it names one that it has not, which USD would leave out.
    """
    names = [name.removeprefix("!invert!") for name in value(prim, "xformOpOrder", ()) if name != _RESET]
    for name in names:
        if not name.startswith("xformOp:") or not prim.HasAttribute(name):
            refuse(prim, f"its xformOpOrder names {name}, which it has not", "author it, or remove its name")
    return [prim.GetAttribute(name) for name in names]


def quaternion(q: Gf.Quatd) -> Array:
    """A Gf quaternion as a unit (w, x, y, z) with w >= 0."""
    x, y, z = q.imaginary
    w = q.real
    length = math.copysign(math.sqrt(w * w + x * x + y * y + z * z), w)
    return np.array((w / length, x / length, y / length, z / length))


def split(matrix: Gf.Matrix4d, prim: Usd.Prim) -> Place:
    """Take a transform apart into rotation and translation, and the scale, mirroring and shear before them.

    Raises:
        StageError: if the prim is squashed flat.
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
    return Place(rigid, matrix * rigid.GetInverse())


class World:
    """The stage's coordinates turned into ours: metres, kilograms, Z up; units that are none go to `problems`."""

    def __init__(self, stage: Usd.Stage, problems: Report) -> None:
        self.meters = self.kilograms = 1.0
        with problems.gathered():
            self.meters = _unit(stage, "metersPerUnit", UsdGeom.GetStageMetersPerUnit(stage))
        with problems.gathered():
            self.kilograms = _unit(stage, "kilogramsPerUnit", UsdPhysics.GetStageKilogramsPerUnit(stage))
        self.upright = Gf.Matrix4d(
            _UPRIGHT.get(UsdGeom.GetStageUpAxis(stage), Gf.Rotation(Gf.Vec3d(0, 0, 1), 0)), (0, 0, 0)
        )
        self.units = Gf.Matrix4d().SetScale(self.meters) * self.upright
        self._cache = UsdGeom.XformCache(NOW)

    def matrix(self, prim: Usd.Prim) -> Gf.Matrix4d:
        """The prim's local coordinates -> our world."""
        return _placed(self._cache.GetLocalToWorldTransform, prim) * self.units

    def parent(self, prim: Usd.Prim) -> Gf.Matrix4d:
        """The coordinates in which the prim's transform is given -> our world."""
        if self._cache.GetLocalTransformation(prim)[1]:
            return self.units
        return _placed(self._cache.GetParentToWorldTransform, prim) * self.units

    def direction(self, v: Gf.Vec3d) -> Array:
        """A vector (3,) in the stage's world axes, turned to ours and not scaled."""
        return vector(self.upright.TransformDir(Gf.Vec3d(v)))


def _unit(stage: Usd.Stage, name: str, number: float) -> float:
    if not 0 < number < math.inf:
        refuse(stage.GetPseudoRoot(), f"{name} = {number:g}", "author a finite number above 0")
    return number


def _placed(compute: Callable[[Usd.Prim], Gf.Matrix4d], prim: Usd.Prim) -> Gf.Matrix4d:
    """The transform of a prim, unless an operation of it, or of a prim above, is missing or not finite."""
    try:
        matrix = compute(prim)
        if np.isfinite(np.asarray(matrix)).all():
            return matrix
    except Tf.ErrorException:  # which does not say of which prim
        pass
    above = prim
    while above:
        for operation in operations(above):
            still(operation)
        above = above.GetParent()
    refuse(prim, "its transform is not finite", "author smaller numbers")
