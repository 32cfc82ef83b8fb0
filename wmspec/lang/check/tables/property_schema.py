"""Which properties a thing has: its kind's, without those that make no sense beside the others that are said."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cache

from wmspec.lang.check.tables.vocabulary import MEASURES, PROPERTIES, Slot
from wmspec.lang.check.types.types import A_LENGTH, AN_ANGLE

_FORM = ("shape", *MEASURES)
_MESH = ("file", "scale", "collision")
_TRAFFIC = ("roads", "lane", "keeps")
_DRIVEN = ("axis", "low", "high", "start", "target", "stiffness", "damping", "pace", "strength")
#: A property that says nothing without another, and what it is for.
_NEEDS = {
    "scale": ("file", "a mesh"),
    "collision": ("file", "a mesh"),
    "axes": ("moments", "moments of inertia"),
    "repeats": ("image", "a picture"),
    "gap": ("scatter", "what is scattered"),
    "scatter": ("on", "what rests on something"),
}
#: The looks that a part has from its object where it does not say its own.
LOOKS = ("color", "material", "image", "repeats", "roughness", "metallic")


@dataclass(frozen=True)
class ThingType:
    """What decides which properties a thing has: its kind, a joint's or robot's model, what is said, if it has parts.

    `asset` is whether it is a link or a joint of one.
    """

    kind: str
    said: frozenset[str]
    model: str = ""
    parts: bool = False
    asset: bool = False


def thing_type(
    kind: str, written: Collection[str], model: str = "", parts: bool = False, asset: bool = False
) -> ThingType:
    """The type of a thing. Only the properties that decide about others are kept, so that there are few types."""
    deciding = {"file", "image", "on", "scatter", "target", "moments"}
    return ThingType(kind, frozenset(deciding & set(written)), model, parts, asset)


def unfit(of: ThingType, name: str) -> str:
    """Why a thing cannot have this property of its kind; empty if it can."""
    if of.kind in ("object", "part"):
        if of.parts and name in (*_FORM, *_MESH):
            return f"an object that is made of parts has no `{name}` of its own"
        if "file" in of.said and name in _FORM:
            return f"{'an object' if of.kind == 'object' else 'a part'} that is a mesh from a file has no `{name}`"
        if name == "inside" and "on" in of.said:
            return "an object rests on something or inside it, not both"
        if name in _NEEDS and _NEEDS[name][0] not in of.said:
            other, what = _NEEDS[name]
            return f"`{name}` is for {what}, and there is no `{other}`"
    if of.kind == "joint" and of.model not in ("hinge", "slider") and name in _DRIVEN:
        return f"`{name}` is for a hinge or a slider"
    if of.kind == "robot" and of.model not in ("", "car") and name in _TRAFFIC:
        return f"`{name}` is for a car"
    if of.kind == "robot" and of.model not in ("", "arm") and name == "model":
        return "`model` is for an arm"
    if name == "start" and not of.asset:
        return "`start` is for a joint of an asset; this one holds its objects as they are placed"
    return ""


def remedy(of: ThingType, name: str) -> str:
    """What to do about a property that the thing cannot have."""
    lonely = of.kind in ("object", "part") and name in _NEEDS and _NEEDS[name][0] not in of.said
    return f"add `{_NEEDS[name][0]}:` or remove this" if lonely and not of.parts else "remove it"


@cache
def slots(of: ThingType) -> dict[str, Slot]:
    """The properties that a thing can have."""
    return {name: _fitted(of, name, slot) for name, slot in PROPERTIES[of.kind].items() if not unfit(of, name)}


def _fitted(of: ThingType, name: str, slot: Slot) -> Slot:
    if of.kind == "joint" and AN_ANGLE in slot.types:
        return replace(slot, types=(AN_ANGLE if of.model == "hinge" else A_LENGTH,))
    if of.kind == "joint" and name == "stiffness" and "target" in of.said:
        return replace(slot, default=None)  # a target without stiffness would do nothing
    if of.kind == "robot" and of.model == "arm" and name == "model":
        return replace(slot, optional=False)
    return slot


def inherited(own: Collection[str], whole: Collection[str]) -> tuple[str, ...]:
    """The looks that a part has from its object: those that the object has (`whole`) and the part does not say."""
    return tuple(name for name in LOOKS if name in whole and name not in own)
