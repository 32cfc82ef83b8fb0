"""The composed difference of two stages: the independent check of the one-factor law.

It does not depend on how wmspec writes stages. Two stages are equal if their prims, properties and the metadata listed
here are equal, independent of layers and references.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pxr import Sdf, Usd

import wmspec.sim.usd.schema  # noqa: F401  USD has to know the fallbacks of our own types

STAGE_METADATA = (
    "upAxis",
    "metersPerUnit",
    "kilogramsPerUnit",
    "defaultPrim",
    "startTimeCode",
    "endTimeCode",
    "timeCodesPerSecond",
)
PRIM_METADATA = ("specifier", "active", "instanceable", "kind")
PROPERTY_METADATA = ("interpolation", "elementSize", "colorSpace", "bindMaterialAs")

_EVERYTHING = Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)


@dataclass(frozen=True)
class Difference:
    """A difference between two stages, with its value in each, or None where absent.

    `path` is the path of a prim (the value is its type) or of a property (its value, or a relationship's targets). A
    suffix names other facts, as in `/World/ball[apiSchemas]` or `/World/ball.points[interpolation]`.
    """

    path: str
    before: Any
    after: Any


def diff(a: Usd.Stage, b: Usd.Stage) -> tuple[Difference, ...]:
    """Return all differences from stage `a` to stage `b`, sorted by path; a prim in one stage only is one difference.

    Values are compared exactly. An authored value equals the same fallback value of a schema. Asset paths are compared
    as authored.
    """
    facets = list(_facets("/", _stage_metadata(a), _stage_metadata(b)))
    before, after = _prims(a), _prims(b)
    for path in before.keys() | after.keys():
        x, y = before.get(path), after.get(path)
        if x and y:
            facets += _facets(path, _prim(x, y), _prim(y, x))
            for name in {*x.GetAuthoredPropertyNames(), *y.GetAuthoredPropertyNames()}:
                facets += _property_differences(f"{path}.{name}", x.GetProperty(name), y.GetProperty(name))
        else:
            facets.append(Difference(path, _type(x), _type(y)))
    return tuple(sorted(facets, key=lambda d: d.path))


def _facets(path: str, a: Mapping[str, Any], b: Mapping[str, Any]) -> Iterator[Difference]:
    """Yield the differences of two sets of facts; the fact '' is the object itself."""
    for key in a.keys() | b.keys():
        x, y = a.get(key), b.get(key)
        if not _same(x, y):
            yield Difference(f"{path}[{key}]" if key else path, x, y)


def _same(x: Any, y: Any) -> bool:
    """Whether two values are equal in type and value; NaN equals itself."""
    return type(x) is type(y) and (x == y or repr(x) == repr(y))


# ---------------------------------------------------------------- stages and prims


def _stage_metadata(stage: Usd.Stage) -> dict[str, Any]:
    return {key: _plain(stage.GetMetadata(key)) for key in STAGE_METADATA}


def _prims(stage: Usd.Stage) -> dict[str, Usd.Prim]:
    return {str(prim.GetPath()): prim for prim in Usd.PrimRange.Stage(stage, _EVERYTHING)}


def _type(prim: Usd.Prim | None) -> str | None:
    return str(prim.GetTypeName()) if prim else None


def _prim(prim: Usd.Prim, other: Usd.Prim) -> dict[str, Any]:
    """Return the facts about a prim; the order of children covers only those that `other` also has."""
    shared = set(other.GetAllChildrenNames())
    facts = {key: _plain(prim.GetMetadata(key)) for key in PRIM_METADATA}
    facts["active"] = prim.IsActive()
    facts["instanceable"] = prim.IsInstanceable()
    facts["apiSchemas"] = tuple(prim.GetPrimTypeInfo().GetAppliedAPISchemas())
    facts["order"] = tuple(name for name in prim.GetAllChildrenNames() if name in shared)
    return {"": _type(prim), **facts}


# ---------------------------------------------------------------- properties


def _property_differences(path: str, x: Usd.Property, y: Usd.Property) -> Iterator[Difference]:
    if x and y:
        yield from _facets(path, _property(x), _property(y))
    else:
        yield Difference(path, _summary(x), _summary(y))


def _summary(prop: Usd.Property) -> Any:
    """Return the value of a property that the other stage lacks, or its type if it has no value."""
    if not prop:
        return None
    facts = _property(prop)
    return facts[""] if facts[""] is not None else facts.get("type")


def _property(prop: Usd.Property) -> dict[str, Any]:
    """Return the facts about a property; '' is its value or its targets."""
    facts = {key: _plain(prop.GetMetadata(key)) for key in PROPERTY_METADATA if prop.HasMetadata(key)}
    if isinstance(prop, Usd.Relationship):
        return {"": tuple(map(str, prop.GetTargets())), **facts}
    samples = tuple((time, _plain(prop.Get(time))) for time in prop.GetTimeSamples())
    return {
        "": _plain(prop.Get()),
        "type": str(prop.GetTypeName()),
        "variability": prop.GetVariability(),
        "connections": tuple(map(str, prop.GetConnections())),
        "timeSamples": samples or None,
        "spline": prop.GetSpline() if prop.HasSpline() else None,
        **facts,
    }


def _plain(value: Any) -> Any:
    """Return the value as an immutable object with exact equality."""
    if isinstance(value, Sdf.AssetPath):
        return value.path
    if hasattr(value, "__len__") and type(value).__name__.endswith("Array"):
        return tuple(_plain(item) for item in value)
    return value
