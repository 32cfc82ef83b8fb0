"""The geometry of an object: one solid, the mesh of a file, or its parts."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from wmspec.compile.layout.solids import PlacedShape, bounds
from wmspec.core.canonical import dumps, loads
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import IDENTITY, Pose, from_ypr
from wmspec.lang.check.tables.vocabulary import MEASURES, MESH_UNITS, Y_UP
from wmspec.lang.check.types.types import article, either
from wmspec.sim.scene.physics.gyration import farthest_corner, gyration_excess
from wmspec.sim.shapes import SHAPES, Shape
from wmspec.sim.shapes.shape import UnfitError

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator


def pieces(values: Evaluator, owner: str) -> tuple[PlacedShape, ...]:
    """Return the touchable solids of an object, or all if none is touchable, each in the object's frame.

    Raises WmsError for invalid sizes.
    """
    return values.memoized((owner, "pieces"), lambda: _touchable_pieces(values, owner))


def all_pieces(values: Evaluator, owner: str) -> tuple[tuple[str, PlacedShape], ...]:
    """Return all solids of an object, visual and touchable, each with the name of its part or of the object."""
    return values.memoized((owner, "every piece"), lambda: _pieces(values, owner))


def touchable(values: Evaluator, part: str) -> bool:
    """Whether a part is touchable, or an object without parts."""
    return not values.has(part, "solid") or values.flag(part, "solid")


def volume(values: Evaluator, owner: str) -> float:
    """Return the volume (m³) of an object or part, as the sum over its parts."""
    return sum(piece.solid.volume for piece in pieces(values, owner))


def mass(values: Evaluator, name: str) -> float:
    """Return the mass (kg) of an object, explicit or from its density."""
    if values.has(name, "mass"):
        return values.number(name, "mass")
    return values.number(name, "density") * volume(values, name)


def inertia_excess(values: Evaluator, name: str) -> float:
    """Return the largest of the `moments` of an object relative to its mass times its squared size."""
    moments, middle = values.vector(name, "moments"), (0.0, 0.0, 0.0)
    if values.has(name, "centre"):
        middle = values.vector(name, "centre")
    low, high = bounds(pieces(values, name), IDENTITY)
    return gyration_excess(mass(values, name), moments, farthest_corner(low, high, middle))


def own_rotation(values: Evaluator, owner: str) -> tuple[float, float, float]:
    """Return yaw, pitch and roll (rad) of an object or part."""
    return (values.number(owner, "yaw"), values.number(owner, "pitch"), values.number(owner, "roll"))


def _touchable_pieces(values: Evaluator, owner: str) -> tuple[PlacedShape, ...]:
    every = all_pieces(values, owner)
    return tuple(piece for part, piece in every if touchable(values, part)) or tuple(piece for _, piece in every)


def _pieces(values: Evaluator, owner: str) -> tuple[tuple[str, PlacedShape], ...]:
    parts = values.parts(owner)
    if not parts:
        return ((owner, PlacedShape(_solid(values, owner), IDENTITY)),)
    poses = (Pose(values.vector(p, "at"), from_ypr(*own_rotation(values, p))) for p in parts)
    return tuple((p, PlacedShape(_solid(values, p), pose)) for p, pose in zip(parts, poses, strict=True))


def _solid(values: Evaluator, owner: str) -> Shape:
    if not values.has(owner, "file"):
        return _shape(values, owner)
    from wmspec.compile.layout.meshes import load

    path, touched, scale = values.text(owner, "file"), values.text(owner, "collision"), values.property(owner, "scale")
    assert isinstance(scale, float | tuple)
    metres = MESH_UNITS[values.text(owner, "units")] if values.has(owner, "units") else None
    up = values.text(owner, "up") if values.has(owner, "up") else "y" if path.lower().endswith(Y_UP) else "z"
    try:
        return load(path, scale, touched, touchable(values, owner), metres=metres, up=up)
    except ImpossibleValue as error:
        raise error.at(values.source_location(owner, "file")) from None


def _shape(values: Evaluator, owner: str) -> Shape:
    """Return a shape of the shape table with the specified sizes."""
    word = values.text(owner, "shape")
    kind = SHAPES[word]
    words = {name: values.property(owner, name) for name in MEASURES if values.has(owner, name)}
    edges = len(words["size"]) if isinstance(words["size"], tuple) else 1
    if edges not in kind.lengths:
        having = either([article(other) for other, one in SHAPES.items() if edges in one.lengths])
        many = f"only {having} has {'two' if edges == 2 else 'three'} edges"
        remedy = "write `radius:` and `height:`" if {"radius", "height"} <= kind.parameters else "write one length"
        raise ImpossibleValue(f"`{owner}` is a {word}, and {many}", values.source_location(owner, "size"), remedy)
    try:
        return _cached_shape(word, dumps(words))
    except UnfitError as error:
        place = values.source_location(owner, error.name) if error.name in words else values.source_location(owner)
        raise ImpossibleValue(f"the {word} `{owner}` {error}", place) from None


@lru_cache(maxsize=1024)
def _cached_shape(word: str, words: bytes) -> Shape:
    """Return a shape by name and serialized sizes, cached since many objects share it. Raises UnfitError."""
    return SHAPES[word].from_words(loads(words))
