"""What objects weigh: the mass of each piece that can be touched, or of the body if its moments are said."""

from __future__ import annotations

from wmspec.compile.layout.geometry import every_piece, touchable
from wmspec.compile.layout.values import Values
from wmspec.compile.stage.document import Prim
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import turn

#: What is smaller than this (m³) is taken for a mistake: a tenth of a millimetre across.
LEAST_VOLUME = 1e-13
#: By so much a number of a stage may be off: half the distance between neighbours of simple precision, twice.
ROUNDING = 2.0**-22


def own(name: str, values: Values) -> bool:
    """Whether an object says more of how its mass is spread than its pieces do. Raises WmsError if it has no mass."""
    touched = any(touchable(values, part) for part, _ in every_piece(values, name))
    if not touched and not (values.has(name, "mass") and values.has(name, "moments")):
        raise ImpossibleValue(
            f"nothing of `{name}` can be touched, so nothing says what it weighs",
            values.place(name),
            "give it `mass` and `moments`, or make a part of it solid",
        )
    return values.has(name, "centre") or values.has(name, "moments")


def add_own(body: Prim, name: str, values: Values) -> None:
    """The mass, the centre of mass and the moments of an object on its body."""
    if values.has(name, "mass"):
        body.set("physics:mass", "float", values.number(name, "mass"), f"{name}.mass")
    if values.has(name, "centre"):
        body.set("physics:centerOfMass", "point3f", values.vector(name, "centre"), f"{name}.centre")
    if values.has(name, "moments"):
        body.set("physics:diagonalInertia", "float3", _moments(name, values), f"{name}.moments")
        body.set("physics:principalAxes", "quatf", turn(*values.vector(name, "axes")), f"{name}.axes")


def _moments(name: str, values: Values) -> tuple[float, ...]:
    """The moments of inertia; of a flat thing, one of which is the others' sum, so that rounding does not exceed it."""
    moments = values.vector(name, "moments")
    largest, rest = max(moments), sum(moments) - max(moments)
    if largest > rest * (1 + 1e-6):
        numbers, place = ", ".join(f"{m:g}" for m in moments), values.place(name, "moments")
        raise ImpossibleValue(f"no solid has the moments ({numbers}) of `{name}`: one is above the others' sum", place)
    return tuple(min(m, rest * (1 - ROUNDING)) if m == largest else m for m in moments)


def add_mass(prim: Prim, name: str, volume: float, values: Values) -> None:
    """What a piece of this volume (m³) weighs: its share of the object's mass, or its density."""
    if values.flag(name, "fixed") and not values.has(name, "mass"):
        return
    whole = _whole(name, values)
    if not values.has(name, "mass"):
        prim.set("physics:density", "float", values.number(name, "density"), f"{name}.density")
    elif not own(name, values):
        parts = (f"{name}.form",) if values.parts(name) else ()
        share = values.number(name, "mass") * (volume / whole)
        prim.set("physics:mass", "float", share, f"{name}.mass", *parts)


def _whole(name: str, values: Values) -> float:
    """The volume (m³) of all that can be touched of an object. Raises WmsError if it is too small."""
    whole = sum(piece.solid.volume for part, piece in every_piece(values, name) if touchable(values, part))
    if whole < LEAST_VOLUME:
        raise ImpossibleValue(f"`{name}` is too small to have a mass: {whole:g} m³", values.place(name))
    return whole
