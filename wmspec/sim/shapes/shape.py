"""What a shape says of itself. Whoever writes a new one fills this in, and needs nothing else.

The language, the layout, the stage, the scene and the engines ask for no more than what is here. Most answers have a
default that holds for every convex solid, so a shape says how far it reaches, what it weighs and how it is drawn.
Numbers are metres and plain tuples, with z upwards in the shape's own frame: checking a spec asks for these, and should
not wait for numpy. What is drawn or collides as arrays is imported where it is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol, Self

from wmspec.core.space import HERE, ORIGIN, UP, Pose, Vector, times

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.polygons import Polygons

    Array = NDArray[np.float64]

Tensor = tuple[Vector, Vector, Vector]
Flat = tuple[Vector, float]
"""A flat side: its outward unit normal, and how far (m) it is from the origin."""
Symmetry = Literal["ball", "axis", "none"]

AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), UP)


class UnfitError(ValueError):
    """Sizes that make no such shape. The text goes on after its name, such as `is not higher than it is wide`.

    `name` is the property that is wrong, if it is one.
    """

    def __init__(self, reason: str, name: str = "") -> None:
        super().__init__(reason)
        self.name = name


@dataclass(frozen=True)
class Parameter:
    """A property that a shape has in the language besides `size`, `radius` and `height`; it may be left out.

    `kind` is what it takes, in the words of `wmspec.lang.check.tables.vocabulary.PARAMETERS`.
    """

    kind: str
    meaning: str
    above: float | None = None
    least: float | None = None
    most: float | None = None


@dataclass(frozen=True)
class Gprim:
    """A shape as a prim of USD: its type, its attributes (name, type, value, whether uniform), and its own transform.

    The prim's middle is at `offset` (m) in the shape's frame, and it is `scale` times as large.
    """

    type: str
    attributes: tuple[tuple[str, str, Any, bool], ...]
    half: Vector
    offset: Vector = ORIGIN
    scale: Vector | None = None

    @property
    def extent(self) -> tuple[Vector, Vector]:
        """The lowest and the highest corner of the box around the prim, before its scale."""
        return times(-1.0, self.half), self.half


def round_gprim(type: str, radius: float, height: float, half: float) -> Gprim:
    """A prim that is round about z, of a radius and a height (m); it reaches from -`half` to `half` (m) along z."""
    attributes = (
        ("radius", "double", radius, False),
        ("height", "double", height, False),
        ("axis", "token", "Z", True),
    )
    return Gprim(type, attributes, (radius, radius, half))


class Prim(Protocol):
    """What is asked of a prim of USD to read a shape from it. A number that makes no shape is refused there."""

    def positive(self, name: str, fallback: float) -> float:
        """The attribute, which is above 0."""
        ...

    def least(self, name: str, fallback: float) -> float:
        """The attribute, which is at least 0."""
        ...

    def radius(self, fallback: float) -> float:
        """The one radius of a prim that may have two."""
        ...

    @property
    def scale(self) -> Vector:
        """How much larger it is along its own axes; below 0 it is mirrored."""
        ...

    def around(self) -> tuple[float, float]:
        """How much larger it is across and along its axis; across, it is the same both ways."""
        ...

    def uniform(self) -> float:
        """How much larger it is, the same along all axes."""
        ...


@dataclass(frozen=True)
class Shape:
    """A solid, homogeneous and centred as its own file says. Subclasses are frozen dataclasses of plain numbers."""

    parameters: ClassVar[frozenset[str]] = frozenset({"size"})
    """Which properties of the language say how large it is."""
    properties: ClassVar[Mapping[str, Parameter]] = {}
    """What those are that only some shapes have."""
    lengths: ClassVar[frozenset[int]] = frozenset({1})
    """How many lengths its `size` may have."""
    prims: ClassVar[tuple[str, ...]] = ()
    """The types of USD prims that are read as this shape by `read`."""
    symmetry: ClassVar[Symmetry] = "none"
    """Which turns change nothing that can be seen: all of them, those about z, none."""
    convex: ClassVar[bool] = True
    """Whether it is its own convex hull."""
    rim: ClassVar[bool] = False
    """Whether it has a round edge, on which engines differ."""

    hollow: ClassVar[bool] = False
    """Whether things can lie in it: then it has a `floor`."""

    # ------------------------------------------------------------ the language

    @classmethod
    def takes(cls, name: str) -> bool:
        """Whether the language can say this of it."""
        return name in cls.parameters or name in cls.properties

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """The shape that the language's properties describe. Raises UnfitError if they describe none.

        `words` holds `size`, and of `radius`, `height` and its own properties those that are given.
        """
        raise NotImplementedError

    @property
    def words(self) -> Mapping[str, Any]:
        """The language's properties that describe it. By default they are called as its numbers are."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    # ------------------------------------------------------------ what it is

    @property
    def volume(self) -> float:
        """How much room it takes, m³."""
        raise NotImplementedError

    @property
    def center(self) -> Vector:
        """Its centre of mass."""
        return ORIGIN

    @property
    def tensor(self) -> Tensor:
        """The tensor of inertia of 1 kg of it about its centre of mass, m²."""
        raise NotImplementedError

    def reach(self, direction: Vector) -> float:
        """How far (m) it goes from its origin along a unit vector: its support function."""
        raise NotImplementedError

    def floor(self, x: float, y: float) -> float | None:
        """How high (m) the lowest part of it is that is above or below a place of its own, or None if none is."""
        raise NotImplementedError

    @property
    def flats(self) -> tuple[Flat, ...]:
        """All sides of a solid that has flat ones only, on which things can rest; none for what is round."""
        return ()

    @property
    def sizes(self) -> Sequence[float]:
        """The numbers that must be above 0: by default all that it is made of."""
        return tuple(_numbers(getattr(self, field.name) for field in fields(self)))

    @property
    def half_extent(self) -> Vector:
        """Half the edges of the upright box around its origin that holds it."""
        x, y, z = (max(self.reach(axis), self.reach(times(-1.0, axis))) for axis in AXES)
        return (x, y, z)

    def bounds(self, turn: Array) -> Array:
        """The lowest and highest coordinates (2, 3) m of it, turned by a matrix (3, 3)."""
        import numpy as np

        rows: list[Vector] = [(x, y, z) for x, y, z in turn.tolist()]
        low, high = [-self.reach(times(-1.0, row)) for row in rows], [self.reach(row) for row in rows]
        return np.array([low, high])

    # ------------------------------------------------------------ how it is drawn

    def facets(self) -> Facets:
        """Its triangles. Ask `wmspec.sim.shapes.facets.tessellate`, which keeps them."""
        raise NotImplementedError

    def triangles(self) -> tuple[Array, NDArray[np.int32]]:
        """Points (n, 3) and faces (m, 3) as plainly as they can be said."""
        from wmspec.sim.shapes.facets import tessellate

        facets = tessellate(self)
        return facets.points, facets.faces

    def unwrapped(self, facets: Facets, every: Array) -> Array:
        """Texture coordinates (n, 2) for an image that is repeated `every` (2,) times on a metre."""
        from wmspec.sim.shapes.texcoords import flat

        return flat(facets, every)

    # ------------------------------------------------------------ how it collides

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]] | None:
        """What all engines have for it, or None.

        Box (half its edges), sphere (radius), cylinder or capsule (radius, height of the straight part, along z).
        """
        return None

    def pieces(self) -> tuple[tuple[Shape, Pose], ...]:
        """Convex shapes, and where they are, that collide for it."""
        return ((self, HERE),)

    def corners(self) -> Array:
        """The corners (n, 3), n <= 250, of the convex solid that collides for what is no primitive."""
        from wmspec.sim.shapes.facets import tessellate
        from wmspec.sim.shapes.hull import hull, thinned

        return thinned(hull(tessellate(self).points), also=[*AXES, *(times(-1.0, axis) for axis in AXES)])

    def depth_at(self, point: Array) -> tuple[float, Array]:
        """How far (m) a point is below the surface (negative: outside), and how that grows with the point (3,)."""
        return min(self.depths_at(point), key=lambda side: side[0])

    def depths_at(self, point: Array) -> list[tuple[float, Array]]:
        """The same of each of its sides, where it is convex."""
        from wmspec.sim.shapes.sides import below, of_hull

        return below(self.flats, point) if self.flats else of_hull(self.corners(), point)

    # ------------------------------------------------------------ how it stands in USD

    def prim(self) -> Gprim | Polygons:
        """What it is on a stage: one of USD's own shapes, or a mesh.

        By default a mesh that says its name and numbers, from which `wmspec.sim.usd` reads the very same shape.
        """
        from wmspec.sim.shapes.polygons import named

        return named(self)

    @classmethod
    def read(cls, prim: Prim) -> tuple[Shape, float]:
        """The shape of a prim of one of its `prims`, and how far (m) along z it is from the prim's origin."""
        raise NotImplementedError

    @classmethod
    def remade(cls, numbers: Mapping[str, Any]) -> Self:
        """The shape of these numbers by their names: what `wmspec.sim.shapes.polygons.named` has written."""
        return cls(**numbers)


def across_and_up(words: Mapping[str, Any], slim: float = 1.0, tall: bool = False) -> tuple[float, float]:
    """Width and height (m) of what has one `size`: `slim` times as wide, or twice its `radius`, maybe of a `height`."""
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
