"""Masses of objects: of each touchable piece, or of the body if its moments are given."""

from __future__ import annotations

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import all_pieces, inertia_excess, touchable
from wmspec.compile.stage.document import Prim
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import from_ypr
from wmspec.sim.scene.physics.gyration import is_impossible

#: Minimum volume (m³), of a cube of about 0.05 mm; smaller objects are an error.
MIN_VOLUME = 1e-13
#: Relative rounding error of a number of a stage, with a margin: twice half a unit of single precision.
ROUNDING = 2.0**-22


def has_own_mass(name: str, values: Evaluator) -> bool:
    """Whether an object declares its own mass distribution. Raises WmsError if it has no mass."""
    touched = any(touchable(values, part) for part, _ in all_pieces(values, name))
    if not touched and not (values.has(name, "mass") and values.has(name, "moments")):
        raise ImpossibleValue(
            f"nothing of `{name}` can be touched, so nothing says what it weighs",
            values.source_location(name),
            "give it `mass` and `moments`, or make a part of it solid",
        )
    return values.has(name, "centre") or values.has(name, "moments")


def add_own_mass(body: Prim, name: str, values: Evaluator) -> None:
    """Add mass, centre of mass and moments of an object to its body."""
    if values.has(name, "mass"):
        body.set("physics:mass", "float", values.number(name, "mass"), f"{name}.mass")
    if values.has(name, "centre"):
        body.set("physics:centerOfMass", "point3f", values.vector(name, "centre"), f"{name}.centre")
    if values.has(name, "moments"):
        body.set("physics:diagonalInertia", "float3", _moments(name, values), f"{name}.moments")
        if is_impossible(inertia_excess(values, name)):
            forms = tuple(f"{part}.form" for part, _ in all_pieces(values, name))
            body.set("wms:inertia", "token", "authored", f"{name}.moments", f"{name}.mass", *forms, uniform=True)
        body.set("physics:principalAxes", "quatf", from_ypr(*values.vector(name, "axes")), f"{name}.axes")


def _moments(name: str, values: Evaluator) -> tuple[float, ...]:
    """Return the moments of inertia; for flat objects, rounded so that none exceeds the sum of the others."""
    moments = values.vector(name, "moments")
    largest, rest = max(moments), sum(moments) - max(moments)
    if largest > rest * (1 + 1e-6):
        numbers, place = ", ".join(f"{m:g}" for m in moments), values.source_location(name, "moments")
        raise ImpossibleValue(f"no solid has the moments ({numbers}) of `{name}`: one is above the others' sum", place)
    return tuple(min(m, rest * (1 - ROUNDING)) if m == largest else m for m in moments)


def add_mass(prim: Prim, name: str, volume: float, values: Evaluator) -> None:
    """Add the mass of a piece of this volume (m³): its share of the object's mass, or its density."""
    if values.flag(name, "fixed") and not values.has(name, "mass"):
        return
    whole = _whole(name, values)
    if not values.has(name, "mass"):
        prim.set("physics:density", "float", values.number(name, "density"), f"{name}.density")
    elif not has_own_mass(name, values):
        parts = (f"{name}.form",) if values.parts(name) else ()
        share = values.number(name, "mass") * (volume / whole)
        prim.set("physics:mass", "float", share, f"{name}.mass", *parts)


def _whole(name: str, values: Evaluator) -> float:
    """Return the touchable volume (m³) of an object. Raises WmsError if it is too small."""
    whole = sum(piece.solid.volume for part, piece in all_pieces(values, name) if touchable(values, part))
    if whole < MIN_VOLUME:
        raise ImpossibleValue(f"`{name}` is too small to have a mass: {whole:g} m³", values.source_location(name))
    return whole
