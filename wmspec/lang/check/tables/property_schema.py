"""Allowed properties of an entity: those of its kind, without those excluded by other properties."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cache

from wmspec.lang.check.tables.vocabulary import MEASURES, PROPERTIES, PropertySpec
from wmspec.lang.check.types.types import A_LENGTH, AN_ANGLE

_FORM = ("shape", *MEASURES)
_MESH = ("file", "scale", "units", "up", "collision")
_TRAFFIC = ("roads", "lane", "keeps")
_DRIVEN = ("axis", "low", "high", "start", "target", "stiffness", "damping", "pace", "strength", "armature")
#: Properties that require another one, and the owner they are for.
_REQUIREMENTS = {
    **dict.fromkeys(("strict", "inertia"), ("file", "an asset")),
    **dict.fromkeys(("scale", "units", "up"), ("file", "a mesh")),
    "collision": ("file", "a mesh"),
    "axes": ("moments", "moments of inertia"),
    "repeats": ("image", "a picture"),
    "gap": ("scatter", "what is scattered"),
    "scatter": ("on", "what rests on something"),
}
#: Appearance properties that a part inherits from its object.
APPEARANCE = ("color", "material", "image", "repeats", "roughness", "metallic")


@dataclass(frozen=True)
class EntityType:
    """Determines the allowed properties: kind, model of a joint or robot, written properties, parts.

    `asset` marks links and joints of assets.
    """

    kind: str
    set_properties: frozenset[str]
    model: str = ""
    parts: bool = False
    asset: bool = False


def entity_type(
    kind: str, written: Collection[str], model: str = "", parts: bool = False, asset: bool = False
) -> EntityType:
    """Return the type of an entity. Only properties that affect others are kept, so there are few types."""
    deciding = {"file", "image", "on", "scatter", "target", "moments"}
    return EntityType(kind, frozenset(deciding & set(written)), model, parts, asset)


def exclusion_reason(of: EntityType, name: str) -> str:
    """Return why an entity cannot have this property of its kind, or ''."""
    if of.kind in ("object", "part"):
        if of.parts and name in (*_FORM, *_MESH):
            return f"an object that is made of parts has no `{name}` of its own"
        if "file" in of.set_properties and name in _FORM:
            return f"{'an object' if of.kind == 'object' else 'a part'} that is a mesh from a file has no `{name}`"
        if name == "inside" and "on" in of.set_properties:
            return "an object rests on something or inside it, not both"
        if name in _REQUIREMENTS and _REQUIREMENTS[name][0] not in of.set_properties:
            other, what = _REQUIREMENTS[name]
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


def remedy(of: EntityType, name: str) -> str:
    """Return the remedy for a disallowed property."""
    lonely = of.kind in ("object", "part") and name in _REQUIREMENTS and _REQUIREMENTS[name][0] not in of.set_properties
    return f"add `{_REQUIREMENTS[name][0]}:` or remove this" if lonely and not of.parts else "remove it"


@cache
def allowed_properties(of: EntityType) -> dict[str, PropertySpec]:
    """Return the properties that an entity can have."""
    return {
        name: _fitted(of, name, slot) for name, slot in PROPERTIES[of.kind].items() if not exclusion_reason(of, name)
    }


def _fitted(of: EntityType, name: str, slot: PropertySpec) -> PropertySpec:
    if of.kind == "joint" and AN_ANGLE in slot.types:
        return replace(slot, types=(AN_ANGLE if of.model == "hinge" else A_LENGTH,))
    if of.kind == "joint" and name == "stiffness" and "target" in of.set_properties:
        return replace(slot, default=None)  # a target without stiffness has no effect
    if of.kind == "robot" and of.model == "arm" and name == "model":
        return replace(slot, optional=False)
    return slot


def inherited_appearance(own: Collection[str], whole: Collection[str]) -> tuple[str, ...]:
    """Return the appearance properties that a part inherits: those of its object (`whole`) without its `own`."""
    return tuple(name for name in APPEARANCE if name in whole and name not in own)
