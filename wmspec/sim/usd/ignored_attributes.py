"""What a stage says and nobody here reads, though it would move things: told once for each kind, with the first prim.

Other engines' own attributes; attributes of schemas that are not applied; schemas whose names are misspelt.
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
from wmspec.core.spelling import nearest
from wmspec.sim.usd.prims import applied, targets
from wmspec.sim.usd.substitutions import Notes

_MOST = 6
"""So many names of one kind are told."""

_OTHERS = ("physx", "mjc:", "newton:", "state:")
"""How names begin of what the engines' own schemas say."""

_READ = re.compile(
    r"physxRigidBody:(linear|angular)Damping|physxArticulation:enabledSelfCollisions|physxMimicJoint:.*"
    r"|newton:(mimic.*|selfCollisionEnabled)|mjc:(coef\d|target)"
)
_STILL = re.compile(
    r"physx(Scene|ContactReport|CookedData|ConvexHullCollision|ConvexDecompositionCollision|ResidualReporting):.*"
    r"|physx.*:(.*IterationCount|sleepThreshold|stabilizationThreshold|maxDepenetrationVelocity|retainAccelerations"
    r"|contactOffset|enableCCD|enableSpeculativeCCD|reportForces|improvePatchFriction|.*[cC]ombineMode)"
    r"|mjc:(option|compiler|flag|group|name|priority)(:.*)?|newton:(timeStepsPerSecond|maxSolverIterations|contactGap)"
)
"""What says how an engine computes, reports or combines, not what happens."""

_ON = re.compile(r"physxRigidBody:enable.*")
"""What is on unless it is said to be off; the others say nothing new where they are 0, off or endless."""

_KNOWN = ("RigidBody", "Collision", "MeshCollision", "Mass", "Material", "ArticulationRoot", "FilteredPairs", "Drive")
_APIS = {name: f"Physics{name}API" for name in (*_KNOWN, "Limit")}
_ELSEWHERE = re.compile(r"Physics(JointState|ResidualReporting|Deformable|.*Deformable.*|Attachment.*)API")
"""Schemas of others whose names begin as those of UsdPhysics."""

_PARTAKES = ("Physics", "Physx", "Newton", "Mjc")
_PHYSICS = ("physics:", "drive:", "limit:")
_ANYWAY = re.compile(r"physics:(mass|density|centerOfMass|diagonalInertia|principalAxes|approximation)")
"""What is read on bodies and colliders whether its schema is applied or not."""


@dataclass
class _Kind:
    """What is told together: the first prim, the names in order, and how many prims say them."""

    prim: Usd.Prim
    names: dict[str, None] = field(default_factory=dict)
    prims: set[str] = field(default_factory=set)

    @property
    def told(self) -> str:
        """The names, and the verb."""
        names = list(self.names)
        more = [f"{len(names) - _MOST} more"] if len(names) > _MOST else []
        return f"{', '.join((*names[:_MOST], *more))}{self.elsewhere} {'are' if len(names) > 1 else 'is'}"

    @property
    def elsewhere(self) -> str:
        """On how many other prims."""
        others = len(self.prims) - 1
        return f" (here and on {others} other prim{'s' * (others > 1)})" if others else ""


def tell_unread(stage: Usd.Stage, problems: Report, notes: Notes) -> None:
    """Tell what is not read of the prims that take part in physics; all of it is a problem, if the reader is strict."""
    kinds: dict[tuple[str, str], _Kind] = {}
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        for key, name in _said(prim):
            here = kinds.setdefault(key, _Kind(prim))
            here.names[name] = None
            here.prims.add(str(prim.GetPath()))
    for (sort, which), kind in kinds.items():
        with problems.gathered():
            _TOLD[sort](which, kind, notes)


def _said(prim: Usd.Prim) -> Iterator[tuple[tuple[str, str], str]]:
    """The kind and the name of what a prim says and nobody reads."""
    apis, type_ = applied(prim), str(prim.GetTypeName())
    for api in apis:
        name = api.partition(":")[0]
        if name.startswith("Physics") and name not in _APIS.values() and not _ELSEWHERE.fullmatch(name):
            yield ("schema", name), name
    if type_.startswith("Physics") or any(api.startswith(_PARTAKES) for api in apis):
        yield from _unread(prim)
    if (
        type_.startswith("Physics")
        and type_.endswith("Joint")
        and not any(targets(prim, f"physics:body{end}") for end in (0, 1))
    ):
        yield ("joint", ""), prim.GetName()


def _unread(prim: Usd.Prim) -> Iterator[tuple[tuple[str, str], str]]:
    known: set[str] = set()
    for attribute in prim.GetAuthoredAttributes():
        name = attribute.GetName()
        if name.startswith(_OTHERS):
            if not _READ.fullmatch(name) and not _STILL.fullmatch(name) and _says(name, attribute.Get()):
                yield ("other", name.partition(":")[0]), name
        elif name.startswith(_PHYSICS) and _says(name, attribute.Get()):
            known = known or set(prim.GetPrimDefinition().GetPropertyNames())
            schema = _schema(prim, name)
            if name not in known and (schema or name.count(":") == 1):
                yield ("unapplied", schema), name


def _says(name: str, held: Any) -> bool:
    """Whether a value is another than what holds without it."""
    if _ON.fullmatch(name):
        return held is False
    if isinstance(held, str) or held is None:
        return False
    numbers = np.asarray((held.real, *held.imaginary) if hasattr(held, "imaginary") else held)
    return numbers.dtype.kind in "biuf" and bool((np.abs(numbers.astype(float)) < 1e30).all() and numbers.any())


def _schema(prim: Usd.Prim, name: str) -> str:
    """The API schema of UsdPhysics that has an attribute of this name; none if there is no such attribute."""
    first, _, rest = name.partition(":")
    if first in ("drive", "limit"):
        return f"Physics{first.capitalize()}API:{rest.partition(':')[0]}"
    schemas = [api for api, names in _properties().items() if name in names]
    return schemas[-1 if prim.GetTypeName() == "Material" else 0] if schemas else ""


@cache
def _properties() -> Mapping[str, list[str]]:
    registry = Usd.SchemaRegistry()
    return {api: registry.FindAppliedAPIPrimDefinition(api).GetPropertyNames() for api in _APIS.values()}


def _other(_which: str, kind: _Kind, notes: Notes) -> None:
    remedy = "say it by UsdPhysics, or remove it"
    notes.instead(kind.prim, f"{kind.told} another engine's own, and not read", "left out", remedy)


def _unapplied(api: str, kind: _Kind, notes: Notes) -> None:
    if api:
        taken = "read all the same" if all(map(_ANYWAY.fullmatch, kind.names)) else "left out"
        notes.instead(kind.prim, f"{kind.told} of {api}, which is not applied", taken, f"apply {api}")
        return
    known = [name for names in _properties().values() for name in names]
    near = "physics:velocity" if "physics:linearVelocity" in kind.names else nearest(next(iter(kind.names)), known)
    remedy = f"did you mean {near}?" if near else "remove it"
    notes.instead(kind.prim, f"{kind.told} of no schema that it has", "left out", remedy)


def _misspelt(name: str, kind: _Kind, notes: Notes) -> None:
    core = name.removeprefix("Physics").removesuffix("API")
    near = _APIS.get(nearest(core, _APIS)) or nearest(name, _APIS.values())
    remedy = f"did you mean {near}?" if near else "remove it"
    notes.instead(kind.prim, f"UsdPhysics has no schema {name}{kind.elsewhere}", "left out", remedy)


def _lone(_which: str, kind: _Kind, notes: Notes) -> None:
    notes.instead(kind.prim, f"a joint of no bodies{kind.elsewhere}", "left out", "target one body or two")


_TOLD = {"other": _other, "unapplied": _unapplied, "schema": _misspelt, "joint": _lone}


def tell_sideways(stage: Usd.Stage, notes: Notes) -> None:
    """Tell of an up axis that USD does not have; X is honoured by the strict, too."""
    if not notes.strict and (axis := UsdGeom.GetStageUpAxis(stage)) not in ("Y", "Z"):
        taken = "X is up" if axis == "X" else "Z is up"
        notes.instead(stage.GetPseudoRoot(), f"upAxis = {axis} is neither Y nor Z", taken, 'author upAxis = "Y" or "Z"')
