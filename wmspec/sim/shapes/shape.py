"""The interface of shapes: everything that language, layout, stage, scene and engines need to know.

Most methods have a default that is valid for every convex solid; a shape defines its support, mass properties and
triangles. Numbers are metres in plain tuples with z up in the shape frame, because checking a spec must not import
numpy. Array methods import it when called.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol, Self

from wmspec.core.space import IDENTITY, ORIGIN, UP, Pose, Vector, scale

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.polygons import Polygons

    Array = NDArray[np.float64]

Tensor = tuple[Vector, Vector, Vector]
Flat = tuple[Vector, float]
"""A flat face: outward unit normal, and distance (m) from the origin."""
Symmetry = Literal["ball", "axis", "none"]

AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), UP)


class UnfitError(ValueError):
    """Invalid sizes. The text continues the name of the shape, such as `is not higher than it is wide`.

    `name` is the wrong property, if it is one.
    """

    def __init__(self, reason: str, name: str = "") -> None:
        super().__init__(reason)
        self.name = name


@dataclass(frozen=True)
class Parameter:
    """An optional property of a shape in the language, other than `size`, `radius` and `height`.

    `kind` is its type, a key of `wmspec.lang.check.tables.vocabulary.PARAMETERS`.
    """

    kind: str
    meaning: str
    above: float | None = None
    least: float | None = None
    most: float | None = None


@dataclass(frozen=True)
class Gprim:
    """A shape as a USD prim: type, attributes (name, type, value, whether uniform), and its own transform.

    The prim is centred at `offset` (m) in the shape frame and scaled by `scale`.
    """

    type: str
    attributes: tuple[tuple[str, str, Any, bool], ...]
    half: Vector
    offset: Vector = ORIGIN
    scale: Vector | None = None

    @property
    def extent(self) -> tuple[Vector, Vector]:
        """Lowest and highest corner of the bounding box before scaling."""
        return scale(-1.0, self.half), self.half


def round_gprim(type: str, radius: float, height: float, half: float) -> Gprim:
    """A prim that is round about z, of a radius and a height (m); it reaches from -`half` to `half` (m) along z."""
    attributes = (
        ("radius", "double", radius, False),
        ("height", "double", height, False),
        ("axis", "token", "Z", True),
    )
    return Gprim(type, attributes, (radius, radius, half))


class Prim(Protocol):
    """The part of a USD prim that shapes read. Invalid numbers are rejected here."""

    def positive(self, name: str, fallback: float) -> float:
        """Return an attribute above 0."""
        ...

    def least(self, name: str, fallback: float) -> float:
        """Return an attribute of at least 0."""
        ...

    def radius(self, fallback: float) -> float:
        """Return the single radius of a prim that may have two."""
        ...

    @property
    def scale(self) -> Vector:
        """Return the scale along its axes; negative if mirrored."""
        ...

    def around(self) -> tuple[float, float]:
        """Return the scales across and along its axis. Both scales across must be equal."""
        ...

    def uniform(self) -> float:
        """Return the uniform scale."""
        ...


@dataclass(frozen=True)
class Shape:
    """A solid, homogeneous shape. Subclasses are frozen dataclasses of plain numbers."""

    parameters: ClassVar[frozenset[str]] = frozenset({"size"})
    """Properties of the language that give its size."""
    properties: ClassVar[Mapping[str, Parameter]] = {}
    """Further properties of this shape only."""
    lengths: ClassVar[frozenset[int]] = frozenset({1})
    """Valid numbers of lengths in `size`."""
    prims: ClassVar[tuple[str, ...]] = ()
    """Types of USD prims that `read` accepts."""
    engine_kind: ClassVar[str] = ""
    """Its name as a primitive of all engines, if it is one."""
    symmetry: ClassVar[Symmetry] = "none"
    """Rotations that leave its appearance unchanged: all, those about z, or none."""
    convex: ClassVar[bool] = True
    """Whether it equals its convex hull."""
    rim: ClassVar[bool] = False
    """Whether it has a round edge, on which engines differ."""

    hollow: ClassVar[bool] = False
    """Whether objects fit inside; it then has a `floor`."""

    # ------------------------------------------------------------ the language

    @classmethod
    def accepts(cls, name: str) -> bool:
        """Whether the language allows this property for it."""
        return name in cls.parameters or name in cls.properties

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """Return the shape for properties of the language. Raises UnfitError if they are invalid.

        `words` holds `size` and those of `radius`, `height` and its own properties that are given.
        """
        raise NotImplementedError

    @property
    def words(self) -> Mapping[str, Any]:
        """Return its properties in the language; by default its fields."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    # ------------------------------------------------------------ what it is

    @property
    def volume(self) -> float:
        """Volume, m³."""
        raise NotImplementedError

    @property
    def center(self) -> Vector:
        """Centre of mass."""
        return ORIGIN

    @property
    def tensor(self) -> Tensor:
        """Inertia tensor for 1 kg about the centre of mass, m²."""
        raise NotImplementedError

    def reach(self, direction: Vector) -> float:
        """Return the support function: the extent (m) from the origin along a unit vector."""
        raise NotImplementedError

    def floor(self, x: float, y: float) -> float | None:
        """Return the lowest height (m) of the cavity at (x, y), or None outside."""
        raise NotImplementedError

    @property
    def flat_faces(self) -> tuple[Flat, ...]:
        """Return all faces of a polyhedron, on which objects can rest; none for round shapes."""
        return ()

    @property
    def sizes(self) -> Sequence[float]:
        """Return the numbers that must be positive; by default all fields."""
        return tuple(_numbers(getattr(self, field.name) for field in fields(self)))

    @property
    def half_extent(self) -> Vector:
        """Half edges of the axis-aligned box around the origin."""
        x, y, z = (max(self.reach(axis), self.reach(scale(-1.0, axis))) for axis in AXES)
        return (x, y, z)

    def bounds(self, turn: Array) -> Array:
        """Return lowest and highest coordinates (2, 3) m after rotation by a matrix (3, 3)."""
        import numpy as np

        rows: list[Vector] = [(x, y, z) for x, y, z in turn.tolist()]
        low, high = [-self.reach(scale(-1.0, row)) for row in rows], [self.reach(row) for row in rows]
        return np.array([low, high])

    # ------------------------------------------------------------ how it is drawn

    def facets(self) -> Facets:
        """Return its triangles. Use `wmspec.sim.shapes.facets.tessellate`, which caches them."""
        raise NotImplementedError

    def triangles(self) -> tuple[Array, NDArray[np.int32]]:
        """Return a minimal triangulation: points (n, 3) and faces (m, 3)."""
        from wmspec.sim.shapes.facets import tessellate

        facets = tessellate(self)
        return facets.points, facets.faces

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Return texture coordinates (n, 2) of an image repeated `every` (2,) times per metre."""
        from wmspec.sim.shapes.texcoords import planar_texcoords

        return planar_texcoords(facets, every)

    # ------------------------------------------------------------ how it collides

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]] | None:
        """Return the equivalent primitive of all engines, or None.

        Box (half edges), sphere (radius), cylinder or capsule (radius, height of the straight part, along z).
        """
        return (self.engine_kind, tuple(self.sizes)) if self.engine_kind else None

    @property
    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """Return the convex collision shapes and their poses."""
        return ((self, IDENTITY),)

    def corners(self) -> Array:
        """Return the corners (n, 3), n <= 250, of the collision hull of a shape without a primitive."""
        from wmspec.sim.shapes.facets import tessellate
        from wmspec.sim.shapes.hull import hull, limit_corners

        return limit_corners(hull(tessellate(self).points), also=[*AXES, *(scale(-1.0, axis) for axis in AXES)])

    def depth_at(self, point: Array) -> tuple[float, Array]:
        """Return the depth (m) of a point below the surface (negative outside) and its gradient (3,)."""
        return min(self.depths_at(point), key=lambda side: side[0])

    def depths_at(self, point: Array) -> list[tuple[float, Array]]:
        """Return the same for each side of a convex shape."""
        from wmspec.sim.shapes.sides import hull_depths, plane_depths

        return plane_depths(self.flat_faces, point) if self.flat_faces else hull_depths(self.corners(), point)

    # ------------------------------------------------------------ how it stands in USD

    def prim(self) -> Gprim | Polygons:
        """Return its USD form: a gprim, or a mesh.

        By default a mesh that records name and numbers, from which `wmspec.sim.usd` restores the same shape.
        """
        from wmspec.sim.shapes.polygons import shape_polygons

        return shape_polygons(self)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """Return the shape of a prim of one of its `prims`, and its offset (m) along z from the prim."""
        raise NotImplementedError

    @classmethod
    def from_record(cls, numbers: Mapping[str, Any]) -> Self:
        """Return the shape of recorded numbers, as written by `wmspec.sim.shapes.polygons.shape_polygons`."""
        return cls(**numbers)


def width_and_height(words: Mapping[str, Any], slim: float = 1.0, tall: bool = False) -> tuple[float, float]:
    """Return width and height (m) for a `size`, `radius` or `height`; `slim` is the default aspect ratio."""
    across, up = words["size"] * slim, words["size"]
    if "radius" in words:
        across = up = 2 * words["radius"]
    return across, (words["height"] if tall and "height" in words else up)


def _numbers(values: Any) -> Iterator[float]:
    for value in values:
        if isinstance(value, tuple):
            yield from _numbers(value)
        else:
            yield float(value)
