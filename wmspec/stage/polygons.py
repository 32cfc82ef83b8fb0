"""Meshes as USD wants them: worked out once, however many stages they stand on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

from wmspec.space import UP, Vector, add, cross, times, unit
from wmspec.stage.document import Prim

if TYPE_CHECKING:
    from wmspec.layout.meshes import Mesh


@dataclass(frozen=True, eq=False)
class Polygons:
    """Points and faces, whose corners go round anticlockwise seen from outside; `st` of each point or None."""

    points: tuple[Vector, ...]
    faces: tuple[tuple[int, ...], ...]
    st: tuple[tuple[float, float], ...] | None = None

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """The number of corners of each face."""
        return tuple(len(face) for face in self.faces)

    @cached_property
    def indices(self) -> tuple[int, ...]:
        """The corners of all faces, one after the other."""
        return tuple(i for face in self.faces for i in face)

    @cached_property
    def normals(self) -> tuple[Vector, ...]:
        """The unit vector that points out of each face."""
        return tuple(_normal(*(self.points[i] for i in face[:3])) for face in self.faces)

    @cached_property
    def extent(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The lowest and the highest corner of the box around the points."""
        columns = tuple(zip(*self.points, strict=True))
        return tuple(map(min, columns)), tuple(map(max, columns))

    def give(self, prim: Prim, form: str) -> None:
        """Make the prim this mesh; `form` is its source."""
        prim.set("points", "point3f[]", self.points, form)
        prim.set("faceVertexCounts", "int[]", self.counts, form)
        prim.set("faceVertexIndices", "int[]", self.indices, form)
        prim.set("subdivisionScheme", "token", "none", form, uniform=True)
        prim.set("primvars:normals", "normal3f[]", self.normals, form, varies="uniform")
        prim.set("extent", "float3[]", self.extent, form)
        if self.st:
            prim.set("primvars:st", "texCoord2f[]", self.st, form, varies="vertex")


@lru_cache(maxsize=256)
def of_mesh(mesh: Mesh) -> Polygons:
    """The mesh of a file."""
    return Polygons(mesh.points, mesh.faces, mesh.st)


@lru_cache(maxsize=256)
def wedge(x: float, y: float, z: float) -> Polygons:
    """The right prism with these edges (m) whose top falls from the left to the right."""
    x, y, z = x / 2, y / 2, z / 2
    points = ((-x, -y, -z), (x, -y, -z), (x, y, -z), (-x, y, -z), (-x, -y, z), (-x, y, z))
    return Polygons(points, ((0, 3, 2, 1), (0, 4, 5, 3), (1, 2, 5, 4), (0, 1, 4), (3, 5, 2)))


def _normal(a: Vector, b: Vector, c: Vector) -> Vector:
    across = cross(add(b, times(-1, a)), add(c, times(-1, a)))
    return unit(across) if any(across) else UP
