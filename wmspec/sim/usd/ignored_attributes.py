"""Warns once per kind about physics attributes and prims that wmspec ignores, with the first prim.

These are attributes of other engines, attributes of schemas that are not applied, misspelled schemas, and prims of
unknown types that target a body or a joint, such as actuators and tendons.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from wmspec.core.diagnostics import Report
from wmspec.core.spelling import closest_word
from wmspec.sim.usd import actuators
from wmspec.sim.usd.prims import applied_schemas, targets
from wmspec.sim.usd.substitutions import Substitutions

_MAX_LISTED = 6
"""Number of names listed per kind."""

_FOREIGN_PREFIXES = ("physx", "mjc:", "newton:", "state:")
"""Prefixes of attributes of engine-specific schemas."""

_READ_FOREIGN = re.compile(
    r"physxRigidBody:(linear|angular)Damping|physxArticulation:enabledSelfCollisions|physxMimicJoint:.*"
    r"|physxSurfaceVelocity:.*|newton:(armature|mimic.*|selfCollisionEnabled)"
    r"|mjc:(armature|coef\d|target)|physxJoint:armature"
)
_HARMLESS = re.compile(
    r"physx(Scene|ContactReport|CookedData|ConvexHullCollision|ConvexDecompositionCollision|ResidualReporting):.*"
    r"|physx.*:(.*IterationCount|sleepThreshold|stabilizationThreshold|maxDepenetrationVelocity|retainAccelerations"
    r"|contactOffset|enableCCD|enableSpeculativeCCD|reportForces|improvePatchFriction|.*[cC]ombineMode)"
    r"|mjc:(option|compiler|flag|group|name|priority)(:.*)?|newton:(timeStepsPerSecond|maxSolverIterations|contactGap)"
)
"""Attributes about computation, reports or combination, without an effect on motion."""

_DEFAULT_ON = re.compile(r"physxRigidBody:enable.*")
"""Attributes that are on by default; others have no effect if they are 0, off or infinite."""

_KNOWN = ("RigidBody", "Collision", "MeshCollision", "Mass", "Material", "ArticulationRoot", "FilteredPairs", "Drive")
_APIS = {name: f"Physics{name}API" for name in (*_KNOWN, "Limit")}
_FOREIGN_SCHEMAS = re.compile(r"Physics(JointState|ResidualReporting|Deformable|.*Deformable.*|Attachment.*)API")
"""Foreign schemas with the prefix of UsdPhysics."""

_PHYSICS_NAMESPACES = ("Physics", "Physx", "Newton", "Mjc")
_PHYSICS = ("physics:", "drive:", "limit:")
_READ_UNAPPLIED = re.compile(r"physics:(mass|density|centerOfMass|diagonalInertia|principalAxes|approximation)")
"""Attributes that are read on bodies and colliders even if the schema is not applied."""


@dataclass
class _IgnoredKind:
    """One warning: the first prim, the names in order, and the number of prims."""

    prim: Usd.Prim
    names: dict[str, None] = field(default_factory=dict)
    prims: set[str] = field(default_factory=set)

    @property
    def subject(self) -> str:
        """The names, and the verb."""
        names = list(self.names)
        more = [f"{len(names) - _MAX_LISTED} more"] if len(names) > _MAX_LISTED else []
        return f"{', '.join((*names[:_MAX_LISTED], *more))}{self.other_prims} {'are' if len(names) > 1 else 'is'}"

    @property
    def other_prims(self) -> str:
        """On how many other prims."""
        others = len(self.prims) - 1
        return f" (here and on {others} other prim{'s' * (others > 1)})" if others else ""


def warn_ignored_attributes(stage: Usd.Stage, problems: Report, notes: Substitutions) -> None:
    """Warn about ignored attributes of prims with physics; in strict mode, each is an error."""
    kinds: dict[tuple[str, str], _IgnoredKind] = {}
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        for key, name in _ignored(prim):
            here = kinds.setdefault(key, _IgnoredKind(prim))
            here.names[name] = None
            here.prims.add(str(prim.GetPath()))
    for (sort, which), kind in kinds.items():
        with problems.collect_errors():
            _WARNINGS[sort](which, kind, notes)


def _ignored(prim: Usd.Prim) -> Iterator[tuple[tuple[str, str], str]]:
    """Yield kind and name of ignored opinions of a prim."""
    apis, type_ = applied_schemas(prim), str(prim.GetTypeName())
    if type_ in actuators.TYPES:
        return
    for api in apis:
        name = api.partition(":")[0]
        if name.startswith("Physics") and name not in _APIS.values() and not _FOREIGN_SCHEMAS.fullmatch(name):
            yield ("schema", name), name
    if not _is_known(type_) and (acted := _physical_target(prim)):
        yield ("type", type_), acted
    if type_.startswith("Physics") or any(api.startswith(_PHYSICS_NAMESPACES) for api in apis):
        yield from _ignored_of_prim(prim)
    if (
        type_.startswith("Physics")
        and type_.endswith("Joint")
        and not any(targets(prim, f"physics:body{end}") for end in (0, 1))
    ):
        yield ("joint", ""), prim.GetName()


@cache
def _is_known(type_: str) -> bool:
    """Whether USD or wmspec defines a prim type; '' is a prim without a type."""
    return not type_ or type_.startswith("Wms") or Usd.SchemaRegistry().FindConcretePrimDefinition(type_) is not None


def _physical_target(prim: Usd.Prim) -> str:
    """Return the path of the first body or joint that a relationship of the prim targets, or ''."""
    for relationship in prim.GetRelationships():
        for path in relationship.GetTargets():
            acted = prim.GetStage().GetPrimAtPath(path.GetPrimPath())
            if acted and (
                str(acted.GetTypeName()).startswith("Physics")
                or any(api.startswith(_PHYSICS_NAMESPACES) for api in applied_schemas(acted))
            ):
                return str(acted.GetPath())
    return ""


def _ignored_of_prim(prim: Usd.Prim) -> Iterator[tuple[tuple[str, str], str]]:
    known: set[str] = set()
    for attribute in prim.GetAuthoredAttributes():
        name = attribute.GetName()
        if name.startswith(_FOREIGN_PREFIXES):
            if (
                not _READ_FOREIGN.fullmatch(name)
                and not _HARMLESS.fullmatch(name)
                and _is_effective(name, attribute.Get())
            ):
                yield ("other", name.partition(":")[0]), name
        elif name.startswith(_PHYSICS) and _is_effective(name, attribute.Get()):
            known = known or set(prim.GetPrimDefinition().GetPropertyNames())
            schema = _schema(prim, name)
            if name not in known and (schema or name.count(":") == 1):
                yield ("unapplied", schema), name


def _is_effective(name: str, held: Any) -> bool:
    """Whether a value differs from its default effect."""
    if _DEFAULT_ON.fullmatch(name):
        return held is False
    if isinstance(held, str) or held is None:
        return False
    numbers = np.asarray((held.real, *held.imaginary) if hasattr(held, "imaginary") else held)
    return numbers.dtype.kind in "biuf" and bool((np.abs(numbers.astype(float)) < 1e30).all() and numbers.any())


def _schema(prim: Usd.Prim, name: str) -> str:
    """Return the UsdPhysics API schema with an attribute of this name, or ''."""
    first, _, rest = name.partition(":")
    if first in ("drive", "limit"):
        return f"Physics{first.capitalize()}API:{rest.partition(':')[0]}"
    schemas = [api for api, names in _properties().items() if name in names]
    return schemas[-1 if prim.GetTypeName() == "Material" else 0] if schemas else ""


@cache
def _properties() -> Mapping[str, list[str]]:
    registry = Usd.SchemaRegistry()
    return {api: registry.FindAppliedAPIPrimDefinition(api).GetPropertyNames() for api in _APIS.values()}


def _warn_foreign(_which: str, kind: _IgnoredKind, notes: Substitutions) -> None:
    remedy = "express it with UsdPhysics, or remove it"
    notes.record(kind.prim, f"{kind.subject} specific to another engine and ignored", "ignored", remedy)


def _warn_unapplied(api: str, kind: _IgnoredKind, notes: Substitutions) -> None:
    if api:
        taken = "still read" if all(map(_READ_UNAPPLIED.fullmatch, kind.names)) else "ignored"
        notes.record(kind.prim, f"{kind.subject} of {api}, which is not applied", taken, f"apply {api}")
        return
    known = [name for names in _properties().values() for name in names]
    near = "physics:velocity" if "physics:linearVelocity" in kind.names else closest_word(next(iter(kind.names)), known)
    remedy = f"did you mean {near}?" if near else "remove it"
    notes.record(kind.prim, f"{kind.subject} of a schema that is not applied", "ignored", remedy)


def _warn_misspelled(name: str, kind: _IgnoredKind, notes: Substitutions) -> None:
    core = name.removeprefix("Physics").removesuffix("API")
    near = _APIS.get(closest_word(core, _APIS)) or closest_word(name, _APIS.values())
    remedy = f"did you mean {near}?" if near else "remove it"
    notes.record(kind.prim, f"UsdPhysics has no schema {name}{kind.other_prims}", "ignored", remedy)


def _warn_empty_joint(_which: str, kind: _IgnoredKind, notes: Substitutions) -> None:
    notes.record(kind.prim, f"a joint without bodies{kind.other_prims}", "ignored", "target one body or two")


def _warn_unknown_type(type_: str, kind: _IgnoredKind, notes: Substitutions) -> None:
    reason = f"the type {type_}, acting on {next(iter(kind.names))}{kind.other_prims}, is not supported"
    notes.record(kind.prim, reason, "ignored", "express it with UsdPhysics, such as PhysicsDriveAPI, or remove it")


_WARNINGS = {
    "type": _warn_unknown_type,
    "other": _warn_foreign,
    "unapplied": _warn_unapplied,
    "schema": _warn_misspelled,
    "joint": _warn_empty_joint,
}


def warn_up_axis(stage: Usd.Stage, notes: Substitutions) -> None:
    """Warn about an up axis that USD does not define; X is accepted in strict mode too."""
    if not notes.strict and (axis := UsdGeom.GetStageUpAxis(stage)) not in ("Y", "Z"):
        taken = "X is up" if axis == "X" else "Z is up"
        notes.record(stage.GetPseudoRoot(), f"upAxis = {axis} is neither Y nor Z", taken, 'author upAxis = "Y" or "Z"')
