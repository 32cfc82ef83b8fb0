"""What an object is made of: one solid, the mesh in a file, or its parts."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from wmspec.compile.layout.solids import Piece
from wmspec.core.canonical import dumped, loaded
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import HERE, Pose, turn
from wmspec.lang.check.tables.vocabulary import MEASURES
from wmspec.lang.check.types.types import article, either
from wmspec.sim.shapes import SHAPES, Shape
from wmspec.sim.shapes.shape import UnfitError

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values


def pieces(values: Values, owner: str) -> tuple[Piece, ...]:
    """The solids of an object that can be touched, or if none can all, each in the object's frame.

    Raises WmsError if a size makes no sense.
    """
    return values.once((owner, "pieces"), lambda: _touched(values, owner))


def every_piece(values: Values, owner: str) -> tuple[tuple[str, Piece], ...]:
    """All that an object is made of, drawn or touched: the name of each part, or of the object, and its solid."""
    return values.once((owner, "every piece"), lambda: _pieces(values, owner))


def touchable(values: Values, part: str) -> bool:
    """Whether a part can be touched, or an object that is not made of parts."""
    return not values.has(part, "solid") or values.flag(part, "solid")


def volume(values: Values, owner: str) -> float:
    """How much room an object or part takes (m³): the sum over its parts."""
    return sum(piece.solid.volume for piece in pieces(values, owner))


def mass(values: Values, name: str) -> float:
    """What an object weighs (kg), as it says itself or by its density."""
    if values.has(name, "mass"):
        return values.number(name, "mass")
    return values.number(name, "density") * volume(values, name)


def own_turn(values: Values, owner: str) -> tuple[float, float, float]:
    """Yaw, pitch and roll (rad) of an object or part."""
    return (values.number(owner, "yaw"), values.number(owner, "pitch"), values.number(owner, "roll"))


def _touched(values: Values, owner: str) -> tuple[Piece, ...]:
    every = every_piece(values, owner)
    return tuple(piece for part, piece in every if touchable(values, part)) or tuple(piece for _, piece in every)


def _pieces(values: Values, owner: str) -> tuple[tuple[str, Piece], ...]:
    parts = values.parts(owner)
    if not parts:
        return ((owner, Piece(_solid(values, owner), HERE)),)
    poses = (Pose(values.vector(p, "at"), turn(*own_turn(values, p))) for p in parts)
    return tuple((p, Piece(_solid(values, p), pose)) for p, pose in zip(parts, poses, strict=True))


def _solid(values: Values, owner: str) -> Shape:
    if not values.has(owner, "file"):
        return _shape(values, owner)
    from wmspec.compile.layout.meshes import load

    path, touched, scale = values.text(owner, "file"), values.text(owner, "collision"), values.property(owner, "scale")
    assert isinstance(scale, float | tuple)
    try:
        return load(path, scale, touched, touchable(values, owner))
    except ImpossibleValue as error:
        raise error.at(values.place(owner, "file")) from None


def _shape(values: Values, owner: str) -> Shape:
    """A shape of the table, of the sizes that are said."""
    word = values.text(owner, "shape")
    kind = SHAPES[word]
    words = {name: values.property(owner, name) for name in MEASURES if values.has(owner, name)}
    edges = len(words["size"]) if isinstance(words["size"], tuple) else 1
    if edges not in kind.lengths:
        having = either([article(other) for other, one in SHAPES.items() if edges in one.lengths])
        many = f"only {having} has {'two' if edges == 2 else 'three'} edges"
        raise ImpossibleValue(f"`{owner}` is a {word}, and {many}", values.place(owner, "size"))
    try:
        return _formed(word, dumped(words))
    except UnfitError as error:
        place = values.place(owner, error.name) if error.name in words else values.place(owner)
        raise ImpossibleValue(f"the {word} `{owner}` {error}", place) from None


@lru_cache(maxsize=1024)
def _formed(word: str, words: bytes) -> Shape:
    """A shape, of which many things may be, by its name and its dumped measures. Raises UnfitError."""
    return SHAPES[word].from_words(loaded(words))
