"""USD geometry as shapes; each shape class reads its own prims."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Usd

from wmspec.core.canonical import dumps, loads
from wmspec.core.diagnostics import StageError
from wmspec.core.places import PrimPlace
from wmspec.core.space import Vector
from wmspec.sim.scene.model import Pose
from wmspec.sim.shapes import SHAPES, Mesh, Shape
from wmspec.sim.shapes.facets import tessellate
from wmspec.sim.shapes.polygons import SHAPE_ATTRIBUTE
from wmspec.sim.usd.frames import SplitTransform, quaternion, vector
from wmspec.sim.usd.meshes import mesh
from wmspec.sim.usd.prims import refuse, value
from wmspec.sim.usd.substitutions import STRICT, Substitutions

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
"""Axis and sign -> rotation from z to it."""


@dataclass(frozen=True)
class PlacedShape:
    """The shape of a prim: `place` of the prim and `pose` of the shape are in the body frame."""

    prim: Usd.Prim
    place: SplitTransform
    shape: Shape
    pose: Pose


def _axis(prim: Usd.Prim) -> str:
    """Return the axis of a round shape."""
    axis = str(value(prim, "axis", "Z"))
    if axis not in _AXES:
        refuse(prim, f"axis = {axis[:40]!r}", "expected X, Y or Z")
    return axis


def placed_shape(prim: Usd.Prim, place: SplitTransform, notes: Substitutions = STRICT) -> PlacedShape:
    """Return the shape of a prim, in metres.

    Raises: StageError: if its numbers are invalid, or its transform deforms it.
    """
    if prim.GetTypeName() == "Mesh":
        return PlacedShape(prim, place, _mesh(prim, place), place.pose)
    try:
        scale = _scale(prim, place)
        shape, offset = PRIMS[prim.GetTypeName()].read(_Prim(prim, scale))
    except Deformed as error:
        return PlacedShape(prim, place, _deformed(prim, place, error, notes), place.pose)
    axis = _axis(prim)
    turn = place.rigid.ExtractRotationQuat() * _TURNS[axis, 1 if scale[_AXES[axis]] > 0 else -1]
    shift = place.rigid.ExtractTranslation() + turn.Transform(Gf.Vec3d(0, 0, offset))
    return PlacedShape(prim, place, shape, Pose(vector(shift), quaternion(turn)))


class Deformed(StageError):
    """The transform turns a shape into one that has no name."""


def _deformed(prim: Usd.Prim, place: SplitTransform, error: Deformed, notes: Substitutions) -> Mesh:
    """Return the mesh of a deformed shape."""
    axis = _axis(prim)
    plain, offset = PRIMS[prim.GetTypeName()].read(_Prim(prim, (1.0, 1.0, 1.0)))
    smooth = tessellate(plain)
    turn = Gf.Matrix4d().SetRotate(_TURNS[axis, 1]) * place.stretch
    linear = np.array(turn, np.float64)[:3, :3]
    points = (smooth.points + np.array([0.0, 0.0, offset])) @ linear
    faces = smooth.faces if np.linalg.det(linear) > 0 else smooth.faces[:, ::-1]
    made = Mesh(points, faces)
    less = 1 - made.volume / (plain.volume * abs(np.linalg.det(linear)))
    notes.record_error(error, f"it is a mesh of {len(faces)} faces, which has {100 * less:.1f} % less volume")
    return made


@dataclass(frozen=True)
class _Prim:
    """The interface through which shapes read a prim."""

    prim: Usd.Prim
    scale: Vector

    def positive(self, name: str, fallback: float) -> float:
        """Return a positive size; converted to float, because USD's doubles may be numpy's."""
        size = float(value(self.prim, name, fallback))
        if not 0 < size < math.inf:
            refuse(self.prim, f"{name} = {size:g}", f"expected a {name} above 0")
        return size

    def least(self, name: str, fallback: float) -> float:
        """Return a number of at least 0."""
        size = float(value(self.prim, name, fallback))
        if not 0 <= size < math.inf:
            refuse(self.prim, f"{name} = {size:g}", f"expected a {name} of at least 0")
        return size

    def radius(self, fallback: float) -> float:
        """Return the single radius of a prim that may have two."""
        if not self.prim.GetTypeName().endswith("_1"):
            return self.positive("radius", fallback)
        top, bottom = self.positive("radiusTop", fallback), self.positive("radiusBottom", fallback)
        if not math.isclose(top, bottom, rel_tol=_SAME):
            refuse(self.prim, "its two radii differ", "use equal radii, a Cone or a Mesh")
        return top

    def around(self) -> tuple[float, float]:
        """Return the scales across and along the axis."""
        along = _AXES[_axis(self.prim)]
        across = [abs(self.scale[i]) for i in range(3) if i != along]
        if not math.isclose(*across, rel_tol=_SAME):
            remedy = "scale it equally across its axis, or use a Mesh"
            raise Deformed("its scale makes its round section elliptic", PrimPlace(str(self.prim.GetPath())), remedy)
        return across[0], abs(self.scale[along])

    def uniform(self) -> float:
        """Return the uniform scale."""
        across, along = self.around()
        if not math.isclose(across, along, rel_tol=_SAME):
            remedy = "scale it equally along all axes, or use a Mesh"
            raise Deformed("its scale makes its round surface elliptic", PrimPlace(str(self.prim.GetPath())), remedy)
        return across


def _scale(prim: Usd.Prim, place: SplitTransform) -> Vector:
    """Return the scales along the prim's axes without round-off, so that equal shapes compare equal."""
    rows = [place.stretch.GetRow3(i) for i in range(3)]
    sheared = any(abs(rows[i][j]) > _SAME * abs(rows[i][i]) for i in range(3) for j in range(3) if i != j)
    if sheared:
        remedy = "scale along the prim's own axes only, or use a Mesh"
        raise Deformed("its transform shears it", PrimPlace(str(prim.GetPath())), remedy)
    x, y, z = (float(f"{rows[i][i]:.12g}") for i in range(3))
    return x, y, z


def _mesh(prim: Usd.Prim, place: SplitTransform) -> Shape:
    """Return a mesh, or the shape that it records, unless it is stretched."""
    word = str(value(prim, SHAPE_ATTRIBUTE, ""))
    kind = SHAPES.get(word)
    if kind is None or not Gf.IsClose(place.stretch, Gf.Matrix4d(1.0), _SAME):
        return mesh(prim, place.stretch)
    numbers = {field.name: _number(value(prim, f"{SHAPE_ATTRIBUTE}:{field.name}")) for field in fields(kind)}
    made = None if None in numbers.values() else _restored(word, dumps(numbers))
    if made is not None and _is_written_as(prim, made):
        return made
    mesh(prim, place.stretch)  # reports all errors of the mesh
    if made is None:
        missing = ", ".join(f"{SHAPE_ATTRIBUTE}:{name}" for name, number in numbers.items() if number is None)
        refuse(prim, f"it claims to be a {word}, without {missing}", f"author them or remove {SHAPE_ATTRIBUTE}")
    points, own = tessellate(made).points, np.asarray(value(prim, "points", []), np.float64)
    if points.shape != own.shape or not np.allclose(points, own, atol=_SAME):
        refuse(prim, f"its points differ from those of the {word} that it claims to be", f"remove {SHAPE_ATTRIBUTE}")
    return made


@lru_cache(maxsize=1024)
def _restored(word: str, numbers: bytes) -> Shape:
    """Return the shape of serialized numbers; cached, because many prims share one."""
    return SHAPES[word].from_record(loads(numbers))


def _is_written_as(prim: Usd.Prim, shape: Shape) -> bool:
    """Whether the mesh data of a prim equals what wmspec writes for the shape."""
    written = tessellate(shape)
    expected: dict[str, NDArray[Any]] = {
        "points": written.points,
        "faceVertexIndices": written.faces.reshape(-1),
        "primvars:st": written.st,
    }
    said = {name: np.asarray(value(prim, name, ())) for name in (*expected, "faceVertexCounts")}
    alike = all(said[name].shape == numbers.shape for name, numbers in expected.items())
    faces = said["faceVertexCounts"]
    if not alike or faces.shape != (len(written.faces),) or (faces != 3).any():
        return False
    return all(bool((said[name] == numbers.astype(said[name].dtype)).all()) for name, numbers in expected.items())


def _number(authored: Any) -> Any:
    """Return a number, or numbers and points as tuples."""
    if authored is None or isinstance(authored, bool | int | str):
        return authored
    if isinstance(authored, float):
        return float(authored)  # float, because USD's doubles may be numpy's
    numbers = np.asarray(authored, np.float64).tolist()
    return tuple(tuple(one) if isinstance(one, list) else one for one in numbers)


PRIMS: dict[str, type[Shape]] = {prim: kind for kind in SHAPES.values() for prim in kind.prims}
"""Prim type -> shape class."""

GEOMETRIES = frozenset(PRIMS) | {"Mesh"}
"""Prim types that `placed_shape` reads."""
