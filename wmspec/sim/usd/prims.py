"""Reading single values, and saying what is wrong with a prim."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, NoReturn

import numpy as np
from pxr import Gf, Sdf, Usd, Vt

from wmspec.core.diagnostics import StageError
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.model import Array
from wmspec.sim.usd.substitutions import STRICT, Notes

NOW = Usd.TimeCode.EarliestTime()
"""A value without time samples, or the only sample of one: anything else is refused as animated."""


_ENDLESS = ("physics:gravityMagnitude", "physics:centerOfMass", "Limit", ":low", ":high", "Force", "breakTorque")
"""How the names end of what may be infinite: there UsdPhysics means by it that there is no bound, or no value."""
_SHORT = 4  # how many numbers are told


def still(attribute: Usd.Attribute) -> Any:
    """The attribute's composed value (or the fallback of its schema), or None.

    Raises:
        StageError: if it changes in time, or holds a number that is not finite and does not mean that there is none.
    """
    name = attribute.GetName()
    if attribute.ValueMightBeTimeVarying():
        refuse(attribute.GetPrim(), f"{name} is animated", "author one value without time samples")
    held = attribute.Get(NOW)
    if isinstance(held, Sdf.UnregisteredValue) or not (kind := attribute.GetTypeName()):
        refuse(attribute.GetPrim(), f"{name} is of a type that USD does not know", "correct its type")
    if held is not None and not _fits(held, kind):  # an opinion may be of another type than the schema's
        refuse(attribute.GetPrim(), f"{name} is {_called(_form(held))}", f"expected {_called(_form_of(kind))}")
    if held is None or isinstance(held, bool | int | str) or (isinstance(held, float) and math.isfinite(held)):
        return held  # most are, and need no more than this
    numbers = _numbers(held)
    if np.isfinite(numbers).all() or (name.endswith(_ENDLESS) and not np.isnan(numbers).any()):
        return held
    shown = f"{name} = {held}" if numbers.size <= _SHORT else f"one of {name}"
    refuse(attribute.GetPrim(), f"{shown} is not finite", "author finite numbers")


def value(prim: Usd.Prim, name: str, fallback: Any = None) -> Any:
    """The attribute's value, as `still` says; `fallback` if it has none."""
    attribute = prim.GetAttribute(name)
    authored = still(attribute) if attribute else None
    if authored is None:
        return fallback
    if isinstance(fallback, int | float) and _form(authored) != _NUMBER:
        refuse(prim, f"{name} is {_called(_form(authored))}", "expected a number")
    return authored


_NUMBER, _TEXT = (), ("text",)


def _form(held: Any) -> tuple[Any, ...]:
    """What a value is, whatever its precision: a number, a text, or so many of which."""
    if isinstance(held, bool | int | float):
        return _NUMBER
    if isinstance(held, str):
        return _TEXT
    if hasattr(held, "imaginary"):
        return ("quaternion",)
    if isinstance(held, Vt.TokenArray | Vt.StringArray):
        return ("texts",)
    if type(held).__module__.startswith("pxr.Sdf"):  # paths, times
        return (type(held).__name__,)
    numbers = np.asarray(held)
    return numbers.shape if isinstance(held, _SINGLE) else ("array", *numbers.shape[1:])


_SINGLE = (Gf.Vec2d, Gf.Vec2f, Gf.Vec2h, Gf.Vec2i, Gf.Vec3d, Gf.Vec3f, Gf.Vec3h, Gf.Vec3i, Gf.Vec4d, Gf.Vec4f, Gf.Vec4h,
           Gf.Vec4i, Gf.Matrix2d, Gf.Matrix3d, Gf.Matrix4d)  # fmt: skip


#: Whether a value of such a type fits into an attribute of such a type: its class alone tells its form.
_FITTING: dict[tuple[type, Sdf.ValueTypeName], bool] = {}


def _fits(held: Any, kind: Sdf.ValueTypeName) -> bool:
    key = (type(held), kind)
    if key not in _FITTING:
        _FITTING[key] = _form(held) == _form_of(kind)
    return _FITTING[key]


@cache
def _form_of(name: Sdf.ValueTypeName) -> tuple[Any, ...]:
    return _form(name.defaultValue)


def _called(form: tuple[Any, ...]) -> str:
    match form:
        case ():
            return "a number"
        case ("array", *more):
            return f"an array of {_called(tuple(more))}"
        case (str(name),):
            return name if name == "texts" else f"a {name}"
    return " x ".join(map(str, form)) + " numbers"


def _numbers(held: Any) -> Array:
    """The floating-point numbers (n,) of a value of any type."""
    if hasattr(held, "imaginary"):  # a quaternion, which numpy does not know
        held = (held.real, *held.imaginary)
    numbers = np.asarray(held)
    return numbers.reshape(-1) if numbers.dtype.kind == "f" else np.empty(0)


def targets(prim: Usd.Prim, name: str) -> list[str]:
    """The paths that the relationship points to, forwarded; empty if there is no such relationship."""
    relationship = prim.GetRelationship(name)
    return [str(path) for path in relationship.GetForwardedTargets()] if relationship else []


def present(prim: Usd.Prim, name: str, notes: Notes = STRICT) -> list[str]:
    """The targets of the relationship that are on the stage, which all must be."""
    paths = targets(prim, name)
    lost = [path for path in paths if not prim.GetStage().GetPrimAtPath(Sdf.Path(path).GetPrimPath())]
    for path in lost:
        notes.instead(prim, f"{name} -> {path} is not on the stage", "left out", "target a prim that exists")
    return [path for path in paths if path not in lost]


def applied(prim: Usd.Prim) -> list[str]:
    """The API schemas that are authored on the prim, also those that USD does not know."""
    return list(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def refuse(prim: Usd.Prim, reason: str, remedy: str) -> NoReturn:
    """Raise a `StageError` about this prim."""
    raise StageError(reason, PrimPlace(str(prim.GetPath())), remedy)


def seconds(prim: Usd.Prim, name: str) -> float:
    """The attribute, which is a time of at least 0 s; 0 if it has none."""
    time = float(value(prim, name, 0.0))
    if not 0 <= time < math.inf:
        refuse(prim, f"{name} = {time:g}", "expected at least 0 s")
    return time


def target(prim: Usd.Prim, name: str, known: Mapping[str, Any], what: str) -> Any:
    """What the relationship points to, which must be one of `known`, by their paths."""
    paths = targets(prim, name)
    if len(paths) != 1 or paths[0] not in known:
        refuse(prim, f"{name} -> {paths} is not one {what} of the stage", f"target the prim of one {what}")
    return known[paths[0]]


class Names:
    """Gives every path a name of its own: its last part if that is free."""

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def give(self, *wishes: str) -> str:
        """The first wish that is free, or the last with a number; `/` becomes `_`."""
        plain = [wish.strip("/").replace("/", "_") for wish in wishes]
        numbered = (f"{plain[-1]}_{i}" for i in range(2, 2 + len(self._taken)))
        name = next(name for name in (*plain, *numbered, plain[-1]) if name not in self._taken)
        self._taken.add(name)
        return name
