"""The dimension that a factor is about: declared in the spec, or derived from what the factor changes."""

from __future__ import annotations

from collections.abc import Iterable

from wmspec.compile.design.depend import FORM, PLACEMENT
from wmspec.core.memoize import LRU
from wmspec.lang.check.ir.evaluate import subexpressions
from wmspec.lang.check.ir.ir import Choices, Entity, Expr, Factor, Ref, TaskSpec
from wmspec.lang.check.tables.vocabulary import MEASURES, WORDS

#: Dimensions by property of objects and parts; all other properties are `other`.
_OF_PROPERTY = {
    **dict.fromkeys((*PLACEMENT, "scatter", "gap", "start"), "position"),
    **dict.fromkeys(FORM, "shape"),
    **dict.fromkeys((*MEASURES, "scale"), "size"),
    **dict.fromkeys(("profile", "outline"), "shape"),
    **dict.fromkeys(("material", "image", "repeats", "roughness", "metallic"), "material"),
    "color": "color",
}
_SURROUNDINGS = ("camera", "light", "world")
#: A form comes with its measures, and both with the places that they need: the first of these is what varies.
_NESTED = ("shape", "size", "position")

_MAX_CACHED = 8
_latest: LRU[int, tuple[TaskSpec, dict[str, frozenset[str]]]] = LRU(_MAX_CACHED)


def dimension(spec: TaskSpec, factor: Factor) -> str:
    """Return the dimension of a factor or nuisance, one of `FACTOR_DIMENSIONS`.

    Without `about`, it follows from the values, if these are words for colors, shapes or materials, or else from the
    properties that depend on the factor directly or through a `let`. If these differ, it is `other`.
    """
    if factor.about:
        return factor.about
    values = set(factor.domain.values) if isinstance(factor.domain, Choices) else set()
    for vocabulary in ("color", "shape", "material"):
        if values and values <= {*WORDS[vocabulary]}:
            return vocabulary
    _, changed = _latest.get(id(spec), lambda: (spec, _changed_dimensions(spec)))
    return _single(changed.get(factor.name, frozenset()))


def _single(changed: frozenset[str]) -> str:
    """Return the dimension of a factor that changes properties of these dimensions."""
    if "world" in changed:
        return "world"
    if len(changed) > 1 and changed <= {*_NESTED}:
        return next(name for name in _NESTED if name in changed)
    return next(iter(changed)) if len(changed) == 1 else "other"


def _changed_dimensions(spec: TaskSpec) -> dict[str, frozenset[str]]:
    """Return the dimensions of the properties that name each factor directly or through a `let`."""
    lets = {let.name: let.value for let in spec.lets}
    known: dict[str, frozenset[str]] = {}
    changed: dict[str, set[str]] = {factor.name: set() for factor in spec.factors}
    for thing in spec.things:
        for name, setting in thing.properties.items():
            for factor in _named(setting.value, lets, known) & changed.keys():
                changed[factor].add(_property_dimension(thing, name))
    return {name: frozenset(dimensions) for name, dimensions in changed.items()}


def _property_dimension(thing: Entity, name: str) -> str:
    """Return the dimension of a property."""
    if thing.kind in _SURROUNDINGS:
        return "world"
    return _OF_PROPERTY.get(name, "other") if thing.kind != "action" else "other"


def _named(value: Expr, lets: dict[str, Expr], known: dict[str, frozenset[str]]) -> frozenset[str]:
    """Return the names in an expression, with those in the `let`s that it names."""
    names: set[str] = set()
    for name in _references(value):
        if name in lets and name not in known:
            known[name] = _named(lets[name], lets, known)
        names |= {name, *known.get(name, ())}
    return frozenset(names)


def _references(value: Expr) -> Iterable[str]:
    return (part.name for part in subexpressions(value) if isinstance(part, Ref))
