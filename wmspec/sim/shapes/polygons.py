"""Meshes in USD's form, and meshes that record the shape that they stand for."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import UP, Vector, add, cross, scale, unit

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from wmspec.sim.shapes.shape import Shape

SHAPE_ATTRIBUTE = "wms:shape"
"""The attribute of a mesh that names its shape; `wms:shape:radius` and the like hold its numbers."""


@dataclass(frozen=True, eq=False)
class Polygons:
    """Points and faces with corners counter-clockwise from outside; `st` per point or None.

    `smooth` holds unit normals per point; without it faces are flat. `numbers` are extra attributes: name, type, value.
    """

    type: ClassVar[str] = "Mesh"

    points: tuple[Vector, ...]
    faces: tuple[tuple[int, ...], ...]
    st: tuple[tuple[float, float], ...] | None = None
    smooth: tuple[Vector, ...] | None = None
    numbers: tuple[tuple[str, str, Any], ...] = ()

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Number of corners of each face."""
        return tuple(len(face) for face in self.faces)

    @cached_property
    def indices(self) -> tuple[int, ...]:
        """Corners of all faces, concatenated."""
        return tuple(i for face in self.faces for i in face)

    @cached_property
    def normals(self) -> tuple[Vector, ...]:
        """Outward unit normal of each face."""
        return tuple(_normal(*(self.points[i] for i in face[:3])) for face in self.faces)

    @cached_property
    def extent(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Lowest and highest corner of the bounding box."""
        columns = tuple(zip(*self.points, strict=True))
        return tuple(map(min, columns)), tuple(map(max, columns))

    @property
    def triangles(self) -> NDArray[np.int32]:
        """The faces as triangle fans (m, 3)."""
        import numpy as np

        return np.array([(f[0], f[i], f[i + 1]) for f in self.faces for i in range(1, len(f) - 1)], np.int32)


@lru_cache(maxsize=256)
def shape_polygons(shape: Shape) -> Polygons:
    """Return the triangles of a shape with its word in the language and its numbers."""
    from wmspec.sim.shapes import shape_word
    from wmspec.sim.shapes.facets import tessellate

    facets = tessellate(shape)
    numbers = tuple((f"{SHAPE_ATTRIBUTE}:{field.name}", *_typed(getattr(shape, field.name))) for field in fields(shape))
    return Polygons(
        tuple((x, y, z) for x, y, z in facets.points.tolist()),
        tuple((a, b, c) for a, b, c in facets.faces.tolist()),
        tuple((s, t) for s, t in facets.st.tolist()),
        tuple((x, y, z) for x, y, z in facets.normals.tolist()),
        ((SHAPE_ATTRIBUTE, "token", shape_word(shape)), *numbers),
    )


def _typed(value: Any) -> tuple[str, Any]:
    """Return USD's type of a number, a point, or a tuple of either, and the value."""
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):
        return f"double{len(value[0])}[]", value
    if isinstance(value, tuple):
        return "double[]", value
    return ("int", value) if isinstance(value, int) else ("double", value)


def _normal(a: Vector, b: Vector, c: Vector) -> Vector:
    across = cross(add(b, scale(-1, a)), add(c, scale(-1, a)))
    return unit(across) if any(across) else UP
