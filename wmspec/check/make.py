"""Tasks made in Python instead of written as text: the same IR, with the language's defaults for what is left out.

Values are SI numbers, truth values, words and names as strings, tuples and lists of these, or expressions of
`wmspec.check.ir`, such as `Ref(name="pace")` for the value of a factor. Units are not checked here.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Literal

from wmspec.check import ir
from wmspec.check.defaults import default_value
from wmspec.check.verbs import VERBS
from wmspec.check.vocabulary import PROPERTIES, Slot
from wmspec.errors import WmsError, suggestion

#: The place of whatever stands in no text.
HERE = ir.Place(file="<python>", line=1, column=1, start=0, end=0)

Part = ir.Factor | ir.Let | ir.Require | ir.Thing | ir.Observation | ir.Question
_NODES = (ir.Value, ir.Ref, ir.Property, ir.Operation, ir.Call, ir.Items)


def expression(value: Any) -> ir.Expr:
    """A Python value as an expression; an expression as it is. Raises WmsError for anything else."""
    if isinstance(value, _NODES):
        return value
    if isinstance(value, bool | str):
        return ir.Value(value=value)
    if isinstance(value, int | float):
        return ir.Value(value=float(value))
    if isinstance(value, list | tuple):
        return ir.Items(items=tuple(expression(v) for v in value))
    raise WmsError(f"{value!r} is no value of a task; give a number, a truth value, a string, a tuple or an ir.Expr")


def factor(name: str, values: Iterable[float | bool | str], unit: str = "") -> ir.Factor:
    """A factor with these values, all of one kind; `unit` is the SI unit of numbers, such as `m/s`."""
    choices = tuple(float(v) if isinstance(v, int) and not isinstance(v, bool) else v for v in values)
    return ir.Factor(name=name, domain=ir.Choices(values=choices), nuisance=False, unit=unit, place=HERE)


def nuisance(name: str, low: float, high: float, unit: str = "") -> ir.Factor:
    """A nuisance drawn uniformly from an interval."""
    return ir.Factor(name=name, domain=ir.Interval(low=low, high=high), nuisance=True, unit=unit, place=HERE)


def let(name: str, value: Any) -> ir.Let:
    """A named value."""
    return ir.Let(name=name, value=expression(value), place=HERE)


def thing(kind: Literal["object", "camera", "light", "world"], name: str, **properties: Any) -> ir.Thing:
    """An object, camera, light or the world. Raises WmsError for a property that its kind lacks or that is missing."""
    return ir.Thing(kind=kind, name=name, properties=_filled(PROPERTIES[kind], properties, kind, name), place=HERE)


def action(name: str, verb: str, *, start: Any = 0.0, duration: Any = None, **arguments: Any) -> ir.Thing:
    """An action: `start` (s), for verbs that last a `duration` (s), and the arguments of the verb."""
    if verb not in VERBS:
        raise WmsError(f"there is no verb `{verb}`; {suggestion(verb, VERBS)}")
    if VERBS[verb].lasts != (duration is not None):
        raise WmsError(f"`{verb}` {'needs a' if VERBS[verb].lasts else 'happens at once and has no'} duration")
    properties = _filled(VERBS[verb].arguments, arguments, "action", name) | {"start": _setting(start)}
    if duration is not None:
        properties["duration"] = _setting(duration)
    return ir.Thing(kind="action", name=name, verb=verb, properties=properties, place=HERE)


def observe(camera: str, times: Sequence[Any]) -> ir.Observation:
    """What a camera sees at times (s)."""
    return ir.Observation(camera=camera, times=expression(list(times)), place=HERE)


def task(
    name: str, *parts: Part, dimension: str = "custom", repeat: int = 1, horizon: Any = None, **about: str
) -> ir.TaskSpec:
    """A task of parts in any order. It lasts until `horizon` (s), or else until the last observation.

    `about` may hold `title`, `description`, `license` and `source`.
    """
    by_type: dict[type, list[Any]] = {}
    for part in parts:
        by_type.setdefault(type(part), []).append(part)
    seen = tuple(o.times for o in by_type.get(ir.Observation, []))
    texts = {"title": name, "description": "", "license": "", "source": ""} | about
    return ir.TaskSpec.model_validate(
        {
            "name": name,
            "dimension": dimension,
            "repeat": repeat,
            "factors": by_type.get(ir.Factor, ()),
            "lets": by_type.get(ir.Let, ()),
            "requires": by_type.get(ir.Require, ()),
            "things": sorted(by_type.get(ir.Thing, ()), key=lambda t: t.kind == "action"),
            "observations": by_type.get(ir.Observation, ()),
            "questions": by_type.get(ir.Question, ()),
            "horizon": expression(horizon) if horizon is not None else ir.Call(function="max", arguments=seen),
            **texts,
        }
    )


def _setting(value: Any) -> ir.Setting:
    return ir.Setting(value=expression(value), place=HERE)


def _filled(table: dict[str, Slot], given: dict[str, Any], kind: str, name: str) -> dict[str, ir.Setting]:
    for key in given:
        if key not in table:
            raise WmsError(f"the {kind} `{name}` has no `{key}`; {suggestion(key, table)}")
    found = {key: _setting(value) for key, value in given.items()}
    for key, slot in table.items():
        if key not in found and slot.default is not None:
            found[key] = _setting(default_value(slot))
        elif key not in found and not slot.optional:
            raise WmsError(f"the {kind} `{name}` needs `{key}`: {slot.meaning}")
    return found
