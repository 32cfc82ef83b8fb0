"""What an object is made of: one solid, the mesh in a file, or its parts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.check.vocabulary import TALL
from wmspec.diagnostics import ImpossibleValue
from wmspec.layout.solids import SLAB, Piece, Solid
from wmspec.space import HERE, Pose, Vector, turn

if TYPE_CHECKING:
    from wmspec.layout.values import Values


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
    return not values.has(part, "solid") or bool(values.property(part, "solid"))


def volume(values: Values, owner: str) -> float:
    """How much room an object or part takes (m³): the sum over its parts."""
    return sum(piece.solid.volume for piece in pieces(values, owner))


def own_turn(values: Values, owner: str) -> tuple[float, float, float]:
    """Yaw, pitch and roll (rad) of an object or part."""
    return (values.property(owner, "yaw"), values.property(owner, "pitch"), values.property(owner, "roll"))


def _touched(values: Values, owner: str) -> tuple[Piece, ...]:
    every = every_piece(values, owner)
    return tuple(piece for part, piece in every if touchable(values, part)) or tuple(piece for _, piece in every)


def _pieces(values: Values, owner: str) -> tuple[tuple[str, Piece], ...]:
    parts = values.parts(owner)
    if not parts:
        return ((owner, Piece(_solid(values, owner), HERE)),)
    poses = (Pose(values.property(p, "at"), turn(*own_turn(values, p))) for p in parts)
    return tuple((p, Piece(_solid(values, p), pose)) for p, pose in zip(parts, poses, strict=True))


def _solid(values: Values, owner: str) -> Solid:
    if not values.has(owner, "file"):
        return Solid(values.property(owner, "shape"), _edges(values, owner))
    from wmspec.layout.meshes import load

    path, scale, touched = (values.property(owner, name) for name in ("file", "scale", "collision"))
    try:
        mesh = load(path, scale, touched, touchable(values, owner))
    except ImpossibleValue as error:
        raise error.at(values.place(owner, "file")) from None
    return Solid("mesh", mesh.edges, mesh)


def _edges(values: Values, owner: str) -> Vector:
    """The edges (m) of the upright box around a shape that is not turned."""
    size, shape = values.property(owner, "size"), values.property(owner, "shape")
    if isinstance(size, tuple):
        return _given(values, owner, size, shape)
    if shape == "plane":
        return (size, size, SLAB)
    across, up = size / 2 if shape == "capsule" else size, size
    if values.has(owner, "radius"):
        across = up = 2 * values.property(owner, "radius")
    if values.has(owner, "height") and shape in TALL:
        up = values.property(owner, "height")
    if shape == "capsule" and up <= across:
        raise ImpossibleValue(f"the capsule `{owner}` is not higher than it is wide", values.place(owner))
    return (across, across, up)


def _given(values: Values, owner: str, size: tuple[float, ...], shape: str) -> Vector:
    if len(size) == 3 and shape in ("box", "wedge"):
        return (size[0], size[1], size[2])
    if len(size) == 2 and shape == "plane":
        return (size[0], size[1], SLAB)
    many = "only a plane has two edges" if len(size) == 2 else "only a box or a wedge has three edges"
    raise ImpossibleValue(f"`{owner}` is a {shape}, and {many}", values.place(owner, "size"))
