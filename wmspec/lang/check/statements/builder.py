"""Builds tasks in Python instead of text: the same IR, with the language's defaults.

Values are SI numbers, truth values, words and names as strings, tuples and lists of these, or expressions of
`wmspec.lang.check.ir.ir`, such as `Ref(name="pace")` for the value of a factor. Units are not checked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, cast

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.places import Location
from wmspec.lang.check.expressions.expressions import default_value
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.property_schema import (
    EntityType,
    allowed_properties,
    entity_type,
    exclusion_reason,
    inherited_appearance,
)
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS, Verb
from wmspec.lang.check.tables.vocabulary import FACTOR_DIMENSIONS, JOINTS, TOLERANCES, PropertySpec

#: Location of nodes without source text.
PYTHON_LOCATION = Location(file="<python>", line=1, column=1, start=0, end=0)

Part = ir.Factor | ir.Let | ir.Require | ir.Holdout | ir.Entity | ir.Observation | ir.Film | ir.Question
_NODES = (ir.Value, ir.Ref, ir.Property, ir.Operation, ir.Call, ir.Items, ir.WhatIf, ir.Cause)


def expression(value: Any) -> ir.Expr:
    """Return a Python value as an expression; expressions are returned unchanged. Raises WmsError for other types."""
    if isinstance(value, _NODES):
        return value
    if isinstance(value, bool | str):
        return ir.Value(value=value)
    if isinstance(value, int | float):
        return ir.Value(value=float(value))
    if isinstance(value, list | tuple):
        return ir.Items(items=tuple(expression(v) for v in value))
    raise WmsError(f"{value!r} is no value of a task; give a number, a truth value, a string, a tuple or an ir.Expr")


def factor(
    name: str, values: Iterable[float | bool | str | Sequence[float]], unit: str = "", about: str = ""
) -> ir.Factor:
    """Return a factor with these values, all of one type; `unit` is their SI unit, such as `m/s`.

    `about` is its dimension, such as `color`; '' derives it. Raises WmsError if there is no such dimension.
    """
    if about and about not in FACTOR_DIMENSIONS:
        raise WmsError(f"there is no dimension `{about}`; {suggestion(about, FACTOR_DIMENSIONS)}")
    domain = ir.Choices(values=tuple(_constant(v) for v in values))
    return ir.Factor(name=name, domain=domain, nuisance=False, unit=unit, place=PYTHON_LOCATION, about=about)


def _constant(value: float | bool | str | Sequence[float]) -> ir.Scalar | tuple[float, ...]:
    if isinstance(value, bool | str):
        return value
    return float(value) if isinstance(value, int | float) else tuple(float(v) for v in value)


def nuisance(name: str, low: float, high: float, unit: str = "") -> ir.Factor:
    """Return a nuisance drawn uniformly from an interval."""
    return ir.Factor(name=name, domain=ir.Interval(low=low, high=high), nuisance=True, unit=unit, place=PYTHON_LOCATION)


def holdout(**levels: float | bool | str | Sequence[float]) -> ir.Holdout:
    """Return a hold-out: levels by factor that training never sees together."""
    chosen = tuple(_constant(level) for level in levels.values())
    return ir.Holdout(factors=tuple(levels), levels=(chosen,), place=PYTHON_LOCATION)


def let(name: str, value: Any) -> ir.Let:
    """Return a named value."""
    return ir.Let(name=name, value=expression(value), place=PYTHON_LOCATION)


def thing(
    kind: Literal["object", "camera", "light", "world"], name: str, *, set: str = "", **properties: Any
) -> ir.Entity:
    """Return an object, camera, light or the world. Raises WmsError for a disallowed or missing property."""
    return _thing(name, entity_type(kind, properties), properties, set=set)


def compound(name: str, parts: Mapping[str, Mapping[str, Any]], **properties: Any) -> tuple[ir.Entity, ...]:
    """Return an object with parts (properties by part name), followed by the parts. Raises WmsError as `thing` does."""
    whole = _thing(name, entity_type("object", properties, parts=True), properties)
    return whole, *(_part(whole, part, properties_of) for part, properties_of in parts.items())


def objects(
    name: str, most: int, properties: Callable[[int], Mapping[str, Any]], count: Any = None
) -> tuple[ir.Entity, ...]:
    """Return the members of a set, `name_0` to `name_{most - 1}`, with properties computed from their index.

    With a `count` expression, only the first `count` members are present.
    """
    members = [thing("object", f"{name}_{i}", set=name, **properties(i)) for i in range(most)]
    return tuple(members if count is None else (_below(m, i, expression(count)) for i, m in enumerate(members)))


def joint(name: str, model: str, **properties: Any) -> ir.Entity:
    """Return a joint of a model: hinge, slider, ball or fixed. Raises WmsError as `thing` does."""
    if model not in JOINTS:
        raise WmsError(f"there is no kind of joint `{model}`; {suggestion(model, JOINTS)}")
    return _thing(name, entity_type("joint", properties, model), properties, model=model)


def robot(name: str, model: str, **properties: Any) -> ir.Entity:
    """Return a robot of a model. Raises WmsError as `thing` does."""
    if model not in ROBOTS:
        raise WmsError(f"there is no kind of robot `{model}`; {suggestion(model, ROBOTS)}")
    return _thing(name, entity_type("robot", properties, model), properties, model=model)


def action(
    name: str, verb: str, *, by: ir.Entity | None = None, start: Any = 0.0, duration: Any = None, **arguments: Any
) -> ir.Entity:
    """Return an action with `start` (s), for lasting verbs `duration` (s), and the verb's arguments.

    `by` is the acting robot, for verbs of robots.
    """
    verbs: Mapping[str, Verb] = ROBOTS[by.model] if by is not None else VERBS
    if verb not in verbs:
        raise WmsError(f"there is no verb `{verb}`; {suggestion(verb, verbs)}")
    if verbs[verb].lasts != (duration is not None):
        raise WmsError(f"`{verb}` {'needs a' if verbs[verb].lasts else 'is instantaneous and has no'} duration")
    properties = _filled(verbs[verb].arguments, arguments, f"the action `{name}`") | {"start": _setting(start)}
    if duration is not None:
        properties["duration"] = _setting(duration)
    of = by.name if by is not None else ""
    return ir.Entity(kind="action", name=name, verb=verb, of=of, properties=properties, place=PYTHON_LOCATION)


def observe(camera: str, times: Sequence[Any], channels: tuple[ir.Channel, ...] = ("rgb",)) -> ir.Observation:
    """Return an observation: a camera, times (s), and the recorded channels."""
    return ir.Observation(camera=camera, times=expression(list(times)), channels=channels, place=PYTHON_LOCATION)


def film(camera: str, start: Any = None, end: Any = None) -> ir.Film:
    """Return the film of a task: a camera, first and last time (s), by default from 0 to the last picture."""
    times = (None if time is None else expression(time) for time in (start, end))
    return ir.Film(camera=camera, start=next(times), end=next(times), place=PYTHON_LOCATION)


def task(
    name: str,
    *parts: Part,
    dimension: str = "custom",
    repeat: int = 1,
    horizon: Any = None,
    plan: ir.Plan | None = None,
    tolerances: Mapping[str, float] | None = None,
    title: str = "",
    description: str = "",
    license: str = "",
    source: str = "",
) -> ir.TaskSpec:
    """Return a task with parts in any order. It ends at `horizon` (s), by default at the last observation.

    `tolerances` (SI) are the allowed disagreement between engines. Raises WmsError for unknown ones,
    and for a hold-out of other levels than those of its factors.
    """
    for key in tolerances or {}:
        if key not in TOLERANCES:
            raise WmsError(f"there is no tolerance `{key}`; {suggestion(key, TOLERANCES)}")
    by_type: dict[type, list[Any]] = {}
    for part in parts:
        by_type.setdefault(type(part), []).append(part)
    for out in by_type.get(ir.Holdout, ()):
        _check_holdout(out, by_type.get(ir.Factor, ()))
    return ir.TaskSpec(
        name=name,
        dimension=dimension,
        repeat=repeat,
        plan=plan or ir.Plan(),
        tolerances=dict(tolerances or {}),
        factors=tuple(by_type.get(ir.Factor, ())),
        lets=tuple(by_type.get(ir.Let, ())),
        requires=tuple(by_type.get(ir.Require, ())),
        holdouts=tuple(by_type.get(ir.Holdout, ())),
        things=tuple(sorted(by_type.get(ir.Entity, ()), key=lambda t: t.kind == "action")),
        observations=tuple(by_type.get(ir.Observation, ())),
        questions=tuple(by_type.get(ir.Question, ())),
        film=next(iter(by_type.get(ir.Film, ())), None),
        horizon=expression(horizon)
        if horizon is not None
        else ir.time_of_last_picture(by_type.get(ir.Observation, [])),
        title=title or name,
        description=description,
        license=license,
        source=source,
    )


def _check_holdout(out: ir.Holdout, factors: Iterable[ir.Factor]) -> None:
    """Raise WmsError if a hold-out names no factor of the task, or no level of it."""
    domains = {f.name: f.domain.values for f in factors if not f.nuisance and isinstance(f.domain, ir.Choices)}
    for name, level in zip(out.factors, out.levels[0], strict=True):
        if name not in domains:
            raise WmsError(f"hold-out: there is no factor `{name}`; {suggestion(name, domains)}".rstrip("; "))
        if level not in domains[name]:
            raise WmsError(f"hold-out: {level!r} is none of the values of `{name}`")


def _setting(value: Any) -> ir.Setting:
    return ir.Setting(value=expression(value), place=PYTHON_LOCATION)


def _thing(name: str, of: EntityType, properties: dict[str, Any], *, model: str = "", set: str = "") -> ir.Entity:
    """Return an entity of a type. Raises WmsError for a disallowed or missing property."""
    whose = f"the {of.kind} `{name}`"
    for key in properties:
        if reason := exclusion_reason(of, key):
            raise WmsError(f"of {whose}: {reason}")
    filled = _filled(allowed_properties(of), properties, whose)
    kind = cast(ir.EntityKind, of.kind)
    return ir.Entity(kind=kind, name=name, model=model, set=set, properties=filled, place=PYTHON_LOCATION)


def _part(whole: ir.Entity, name: str, given: Mapping[str, Any]) -> ir.Entity:
    name = f"{whole.name}.{name}"
    properties = _filled(allowed_properties(entity_type("part", given)), given, f"the part `{name}`")
    for look in inherited_appearance(given, whole.properties):
        properties[look] = _setting(ir.Property(owner=ir.Value(value=whole.name), name=look))
    return ir.Entity(kind="part", name=name, of=whole.name, properties=properties, place=PYTHON_LOCATION)


def _below(member: ir.Entity, index: int, count: ir.Expr) -> ir.Entity:
    """Return the member, present where its index is below `count`."""
    there: ir.Expr = ir.Operation(operator="<", operands=(ir.Value(value=float(index)), count))
    present = member.properties["present"].value
    if present != ir.Value(value=True):
        there = ir.Operation(operator="and", operands=(there, present))
    return replace(member, properties=member.properties | {"present": _setting(there)})


def _filled(table: Mapping[str, PropertySpec], given: Mapping[str, Any], whose: str) -> dict[str, ir.Setting]:
    for key in given:
        if key not in table:
            raise WmsError(f"{whose} has no `{key}`; {suggestion(key, table)}")
    settings = {key: _setting(value) for key, value in given.items()}
    for key, slot in table.items():
        if key not in settings and slot.default is not None:
            settings[key] = _setting(default_value(slot))
        elif key not in settings and not slot.optional:
            raise WmsError(f"{whose} needs `{key}`: {slot.meaning}")
    return settings
