"""Joints that mimic others, as Newton's, PhysX's and MuJoCo's schemas have them; UsdPhysics itself has none.

One follows the other by `y = c0 + c1 x`, in degrees and the stage's lengths.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from pxr import Usd

from wmspec.core.diagnostics import Report
from wmspec.sim.scene.model import Joint, Mimic
from wmspec.sim.usd.frames import World
from wmspec.sim.usd.prims import applied, present, refuse, value
from wmspec.sim.usd.substitutions import STRICT, Notes

_Said = tuple[str, float, float]
"""The path of the joint that is mimicked, c0 and c1."""


def mimics(
    prims: Sequence[Usd.Prim], joints: Mapping[str, Joint], world: World, problems: Report, notes: Notes = STRICT
) -> dict[str, Joint]:
    """The joints, by their paths, with what they mimic; what mimics a mimic does what that does."""
    said: dict[str, tuple[Usd.Prim, _Said]] = {}
    for prim in prims:
        with problems.gathered():
            if str(prim.GetPath()) in joints and (one := _said(prim, notes)):
                said[str(prim.GetPath())] = prim, one
    made = dict(joints)
    for path, (prim, one) in said.items():
        with problems.gathered():
            made[path] = replace(joints[path], mimic=_mimic(prim, one, said, joints, world))
    return made


def _said(prim: Usd.Prim, notes: Notes) -> _Said | None:
    apis = applied(prim)
    physx = next((api.partition(":")[2] for api in apis if api.startswith("PhysxMimicJointAPI:")), "")
    if physx:
        name = f"physxMimicJoint:{physx}"
        if value(prim, f"{name}:naturalFrequency", 0.0) > 0:
            notes.instead(prim, "joints that mimic others as springs do are not supported", "it mimics it exactly", "")
        offset, gearing = (float(value(prim, f"{name}:{what}", 0.0)) for what in ("offset", "gearing"))
        return _target(prim, f"{name}:referenceJoint"), -offset, -gearing
    if not any(api in apis for api in ("NewtonMimicAPI", "MjcEqualityJointAPI")):
        return None
    if not value(prim, "newton:mimicEnabled", True):
        return None
    if any(value(prim, f"mjc:coef{power}", 0.0) for power in (2, 3, 4)):
        refuse(prim, "it mimics a joint by a polynomial", "author mjc:coef2, mjc:coef3 and mjc:coef4 = 0")
    newton = bool(prim.GetRelationship("newton:mimicJoint").GetTargets())
    low, high = ("newton:mimicCoef0", "newton:mimicCoef1") if newton else ("mjc:coef0", "mjc:coef1")
    at = _target(prim, "newton:mimicJoint" if newton else "mjc:target")
    return at, float(value(prim, low, 0.0)), float(value(prim, high, 1.0))


def _target(prim: Usd.Prim, name: str) -> str:
    paths = present(prim, name)
    if len(paths) != 1:
        refuse(prim, f"{name} has {len(paths)} targets", "target the joint that it mimics")
    return str(paths[0])


def _mimic(
    prim: Usd.Prim,
    said: _Said,
    others: Mapping[str, tuple[Usd.Prim, _Said]],
    joints: Mapping[str, Joint],
    world: World,
) -> Mimic:
    path, offset, ratio = said
    passed = {str(prim.GetPath())}
    while path in others and path not in passed:
        passed.add(path)
        path, below, inner = others[path][1]
        offset, ratio = offset + ratio * below, ratio * inner
    if path in passed:
        refuse(prim, "it mimics itself, by way of others", "let one of the joints mimic none")
    own = joints[str(prim.GetPath())]
    if path not in joints or {own.kind, joints[path].kind} - {"hinge", "slider"}:
        refuse(prim, f"it mimics {path}", "only a joint with one free axis can mimic one, where both hold what moves")
    size, other = (math.radians(1) if j.kind == "hinge" else world.meters for j in (own, joints[path]))
    if not math.isfinite(ratio * offset):
        refuse(prim, f"its coefficients are {offset:g} and {ratio:g}", "author finite numbers")
    return Mimic(joints[path].name, ratio * size / other, offset * size)
