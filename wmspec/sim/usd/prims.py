"""Reads single values of prims and reports errors."""

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
from wmspec.sim.usd.substitutions import STRICT, Substitutions

NOW = Usd.TimeCode.EarliestTime()
"""The only time at which values are read; animated values are refused."""


_MAY_BE_INFINITE = (
    "physics:gravityMagnitude",
    "physics:centerOfMass",
    "Limit",
    ":low",
    ":high",
    "Force",
    "breakTorque",
)
"""Suffixes of attributes in which infinity means no bound or no value in UsdPhysics."""
_MAX_LISTED_NUMBERS = 4  # numbers listed in messages


def static_value(attribute: Usd.Attribute) -> Any:
    """Return the composed value of an attribute (or its schema fallback), or None.

    Raises: StageError: if it is animated, or has an infinite number where that has no meaning.
    """
    name = attribute.GetName()
    if attribute.ValueMightBeTimeVarying():
        refuse(attribute.GetPrim(), f"{name} is animated", "author one value without time samples")
    held = attribute.Get(NOW)
    if isinstance(held, Sdf.UnregisteredValue) or not (kind := attribute.GetTypeName()):
        refuse(attribute.GetPrim(), f"{name} has a type unknown to USD", "correct its type")
    if held is not None and not _fits(held, kind):  # an opinion may have another type than the schema
        refuse(
            attribute.GetPrim(), f"{name} is {_form_name(_value_form(held))}", f"expected {_form_name(_form_of(kind))}"
        )
    if held is None or isinstance(held, bool | int | str) or (isinstance(held, float) and math.isfinite(held)):
        return held  # fast path for most values
    numbers = _numbers(held)
    if np.isfinite(numbers).all() or (name.endswith(_MAY_BE_INFINITE) and not np.isnan(numbers).any()):
        return held
    shown = f"{name} = {held}" if numbers.size <= _MAX_LISTED_NUMBERS else f"one of {name}"
    refuse(attribute.GetPrim(), f"{shown} is not finite", "author finite numbers")


def value(prim: Usd.Prim, name: str, fallback: Any = None) -> Any:
    """Return `static_value` of an attribute, or `fallback`."""
    attribute = prim.GetAttribute(name)
    authored = static_value(attribute) if attribute else None
    if authored is None:
        return fallback
    if isinstance(fallback, int | float) and _value_form(authored) != _NUMBER:
        refuse(prim, f"{name} is {_form_name(_value_form(authored))}", "expected a number")
    return authored


_NUMBER, _TEXT = (), ("text",)


def _value_form(held: Any) -> tuple[Any, ...]:
    """Return the form of a value, independent of precision: a number, a text, or a count of them."""
    if isinstance(held, bool | int | float):
        return _NUMBER
    if isinstance(held, str):
        return _TEXT
    if hasattr(held, "imaginary"):
        return ("quaternion",)
    if isinstance(held, Vt.TokenArray | Vt.StringArray):
        return ("texts",)
    if type(held).__module__.startswith("pxr.Sdf"):  # paths and times
        return (type(held).__name__,)
    numbers = np.asarray(held)
    return numbers.shape if isinstance(held, _SINGLE) else ("array", *numbers.shape[1:])


_SINGLE = (Gf.Vec2d, Gf.Vec2f, Gf.Vec2h, Gf.Vec2i, Gf.Vec3d, Gf.Vec3f, Gf.Vec3h, Gf.Vec3i, Gf.Vec4d, Gf.Vec4f, Gf.Vec4h,
           Gf.Vec4i, Gf.Matrix2d, Gf.Matrix3d, Gf.Matrix4d)  # fmt: skip


#: Cached fit of value classes to attribute types.
_FITTING: dict[tuple[type, Sdf.ValueTypeName], bool] = {}


def _fits(held: Any, kind: Sdf.ValueTypeName) -> bool:
    key = (type(held), kind)
    if key not in _FITTING:
        _FITTING[key] = _value_form(held) == _form_of(kind)
    return _FITTING[key]


@cache
def _form_of(name: Sdf.ValueTypeName) -> tuple[Any, ...]:
    return _value_form(name.defaultValue)


def _form_name(form: tuple[Any, ...]) -> str:
    match form:
        case ():
            return "a number"
        case ("array", *more):
            return f"an array of {_form_name(tuple(more))}"
        case (str(name),):
            return name if name == "texts" else f"a {name}"
    return " x ".join(map(str, form)) + " numbers"


def _numbers(held: Any) -> Array:
    """Return the floating-point numbers (n,) of a value of any type."""
    if hasattr(held, "imaginary"):  # numpy cannot convert quaternions
        held = (held.real, *held.imaginary)
    numbers = np.asarray(held)
    return numbers.reshape(-1) if numbers.dtype.kind == "f" else np.empty(0)


def targets(prim: Usd.Prim, name: str) -> list[str]:
    """Return the forwarded target paths of a relationship; empty if there is none."""
    relationship = prim.GetRelationship(name)
    return [str(path) for path in relationship.GetForwardedTargets()] if relationship else []


def existing_targets(prim: Usd.Prim, name: str, notes: Substitutions = STRICT) -> list[str]:
    """Return the targets of a relationship, all of which must be on the stage."""
    paths = targets(prim, name)
    lost = [path for path in paths if not prim.GetStage().GetPrimAtPath(Sdf.Path(path).GetPrimPath())]
    for path in lost:
        notes.record(prim, f"{name} -> {path} is not on the stage", "left out", "target a prim that exists")
    return [path for path in paths if path not in lost]


def applied_schemas(prim: Usd.Prim) -> list[str]:
    """Return the API schemas authored on a prim, including those unknown to USD."""
    return list(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def refuse(prim: Usd.Prim, reason: str, remedy: str) -> NoReturn:
    """Raise a `StageError` about this prim."""
    raise StageError(reason, PrimPlace(str(prim.GetPath())), remedy)


def seconds(prim: Usd.Prim, name: str) -> float:
    """Return an attribute that is a time of at least 0 s; 0 if unauthored."""
    time = float(value(prim, name, 0.0))
    if not 0 <= time < math.inf:
        refuse(prim, f"{name} = {time:g}", "expected at least 0 s")
    return time


def single_target(prim: Usd.Prim, name: str, known: Mapping[str, Any], what: str) -> Any:
    """Return the target of a relationship among `known`, by path."""
    paths = targets(prim, name)
    if len(paths) != 1 or paths[0] not in known:
        refuse(prim, f"{name} -> {paths} is not one {what} of the stage", f"target the prim of one {what}")
    return known[paths[0]]


class Names:
    """Gives every path a unique name: its last part if that is free."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._numbers: dict[str, int] = {}

    def give(self, *wishes: str) -> str:
        """Return the first free wish, or the last one with a number; `/` becomes `_`."""
        plain = [wish.strip("/").replace("/", "_") for wish in wishes]
        last, number = plain[-1], self._numbers.get(plain[-1], 2)
        while f"{last}_{number}" in self._taken:
            number += 1
        self._numbers[last] = number  # those before it are taken
        name = next((name for name in plain if name not in self._taken), f"{last}_{number}")
        self._taken.add(name)
        return name
