"""The composed difference of two stages: the oracle of the law of one factor.

It knows nothing of how our stages are written. Two stages are equal if no reader of USD can tell them apart by their
prims, properties and the metadata listed here, however their layers and references are arranged.
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
    """What differs, and its value in either stage, None where it has none.

    `path` is that of a prim (the value is its type), of a property (its value, or a relationship's targets), or either
    followed by what else about it differs, as in `/World/ball[apiSchemas]` or `/World/ball.points[interpolation]`.
    """

    path: str
    before: Any
    after: Any


def diff(a: Usd.Stage, b: Usd.Stage) -> tuple[Difference, ...]:
    """Every difference from stage `a` to stage `b`, sorted by path; of a prim that only one has, just the prim.

    Values are compared exactly. A value that is authored equals the same value that is a schema's fallback. Asset paths
    are compared as they are authored.
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
    """The differences of two sets of facts; the fact named '' is the thing itself."""
    for key in a.keys() | b.keys():
        x, y = a.get(key), b.get(key)
        if not _same(x, y):
            yield Difference(f"{path}[{key}]" if key else path, x, y)


def _same(x: Any, y: Any) -> bool:
    """Equal in type and value; not-a-number equals itself."""
    return type(x) is type(y) and (x == y or repr(x) == repr(y))


# ---------------------------------------------------------------- stages and prims


def _stage_metadata(stage: Usd.Stage) -> dict[str, Any]:
    return {key: _plain(stage.GetMetadata(key)) for key in STAGE_METADATA}


def _prims(stage: Usd.Stage) -> dict[str, Usd.Prim]:
    return {str(prim.GetPath()): prim for prim in Usd.PrimRange.Stage(stage, _EVERYTHING)}


def _type(prim: Usd.Prim | None) -> str | None:
    return str(prim.GetTypeName()) if prim else None


def _prim(prim: Usd.Prim, other: Usd.Prim) -> dict[str, Any]:
    """The facts about a prim; the order of its children is told only of those that `other` has too."""
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
    """The value of a property that the other stage has not, or its type if it has none."""
    if not prop:
        return None
    facts = _property(prop)
    return facts[""] if facts[""] is not None else facts.get("type")


def _property(prop: Usd.Property) -> dict[str, Any]:
    """The facts about a property; '' is its value or its targets."""
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
    """The value as something immutable that is compared exactly."""
    if isinstance(value, Sdf.AssetPath):
        return value.path
    if hasattr(value, "__len__") and type(value).__name__.endswith("Array"):
        return tuple(_plain(item) for item in value)
    return value
