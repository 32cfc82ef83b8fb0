"""Mimic joints in the schemas of Newton, PhysX and MuJoCo; UsdPhysics has none.

A joint follows another by `y = c0 + c1 x`, in degrees and stage lengths.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from pxr import Usd

from wmspec.core.diagnostics import Report
from wmspec.sim.scene.model import Joint, Mimic
from wmspec.sim.usd.frames import StageFrame
from wmspec.sim.usd.prims import applied_schemas, existing_targets, refuse, value
from wmspec.sim.usd.substitutions import STRICT, Substitutions

_MimicSpec = tuple[str, float, float]
"""Path of the leader, c0 and c1."""


def mimics(
    prims: Sequence[Usd.Prim],
    joints: Mapping[str, Joint],
    world: StageFrame,
    problems: Report,
    notes: Substitutions = STRICT,
) -> dict[str, Joint]:
    """Return the joints by path with their mimics; chains of mimics are resolved to the first leader."""
    said: dict[str, tuple[Usd.Prim, _MimicSpec]] = {}
    for prim in prims:
        with problems.collect_errors():
            if str(prim.GetPath()) in joints and (one := _said(prim, notes)):
                said[str(prim.GetPath())] = prim, one
    made = dict(joints)
    for path, (prim, one) in said.items():
        with problems.collect_errors():
            made[path] = replace(joints[path], mimic=_mimic(prim, one, said, joints, world))
    return made


def _said(prim: Usd.Prim, notes: Substitutions) -> _MimicSpec | None:
    apis = applied_schemas(prim)
    physx = next((api.partition(":")[2] for api in apis if api.startswith("PhysxMimicJointAPI:")), "")
    if physx:
        name = f"physxMimicJoint:{physx}"
        if value(prim, f"{name}:naturalFrequency", 0.0) > 0:
            notes.record(prim, "compliant mimic joints are not supported", "it follows exactly", "")
        offset, gearing = (float(value(prim, f"{name}:{what}", 0.0)) for what in ("offset", "gearing"))
        return _target(prim, f"{name}:referenceJoint"), -offset, -gearing
    if not any(api in apis for api in ("NewtonMimicAPI", "MjcEqualityJointAPI")):
        return None
    if not value(prim, "newton:mimicEnabled", True):
        return None
    if any(value(prim, f"mjc:coef{power}", 0.0) for power in (2, 3, 4)):
        refuse(prim, "it mimics a joint with a polynomial", "author mjc:coef2, mjc:coef3 and mjc:coef4 = 0")
    newton = bool(prim.GetRelationship("newton:mimicJoint").GetTargets())
    low, high = ("newton:mimicCoef0", "newton:mimicCoef1") if newton else ("mjc:coef0", "mjc:coef1")
    at = _target(prim, "newton:mimicJoint" if newton else "mjc:target")
    return at, float(value(prim, low, 0.0)), float(value(prim, high, 1.0))


def _target(prim: Usd.Prim, name: str) -> str:
    paths = existing_targets(prim, name)
    if len(paths) != 1:
        refuse(prim, f"{name} has {len(paths)} targets", "target the joint that it mimics")
    return str(paths[0])


def _mimic(
    prim: Usd.Prim,
    said: _MimicSpec,
    others: Mapping[str, tuple[Usd.Prim, _MimicSpec]],
    joints: Mapping[str, Joint],
    world: StageFrame,
) -> Mimic:
    path, offset, ratio = said
    passed = {str(prim.GetPath())}
    while path in others and path not in passed:
        passed.add(path)
        path, below, inner = others[path][1]
        offset, ratio = offset + ratio * below, ratio * inner
    if path in passed:
        refuse(prim, "it mimics itself through other joints", "remove one of the mimics")
    own = joints[str(prim.GetPath())]
    if path not in joints or {own.kind, joints[path].kind} - {"hinge", "slider"}:
        refuse(prim, f"it mimics {path}", "mimic and leader must have one free axis each and join dynamic bodies")
    size, other = (math.radians(1) if j.kind == "hinge" else world.meters for j in (own, joints[path]))
    if not math.isfinite(ratio * offset):
        refuse(prim, f"its coefficients are {offset:g} and {ratio:g}", "author finite numbers")
    return Mimic(joints[path].name, ratio * size / other, offset * size)
