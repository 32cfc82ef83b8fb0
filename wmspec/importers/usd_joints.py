"""The joints of UsdPhysics, led away from the base: each has a parent that is nearer to it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from pxr import Usd

from wmspec.importers.frames import inverse
from wmspec.importers.model import Array, Joint
from wmspec.importers.usd_prims import Prims

_AXES = {"X": np.array((1.0, 0.0, 0.0)), "Y": np.array((0.0, 1.0, 0.0)), "Z": np.array((0.0, 0.0, 1.0))}
_KINDS: dict[str, Literal["hinge", "slider", "ball", "fixed"]] = {
    "PhysicsRevoluteJoint": "hinge",
    "PhysicsPrismaticJoint": "slider",
    "PhysicsSphericalJoint": "ball",
    "PhysicsFixedJoint": "fixed",
}
#: Joints must fit at the start within these, m and rad.
_GAP, _BEND = 1e-3, 1e-2


@dataclass(frozen=True)
class _End:
    """One side of a joint: the link, and the joint's frame in it and in the world."""

    link: str
    own: Array
    world: Array


def welded(parent: str, child: str, where: str) -> Joint:
    """A joint that fixes a link where it is."""
    return Joint("", where, "fixed", parent, child, np.eye(4), np.zeros(3), _AXES["X"])


def joints(
    prims: Prims, found: Sequence[Usd.Prim], ends: Mapping[str, str], frames: Mapping[str, Array], root: str
) -> Iterator[Joint]:
    """The joints: `ends` are the links by the paths of their bodies, `frames` their places, `root` is all else."""
    waiting: list[tuple[Usd.Prim, tuple[_End, _End]]] = []
    for prim in found:
        if prims.value(prim, "physics:jointEnabled", True) and not _odd(prims, prim):
            both = tuple(_end(prims, prim, i, ends, frames, root) for i in (0, 1))
            waiting.append((prim, (both[0], both[1])))
    reached = {root} if any(end.link == root for _, both in waiting for end in both) else set(list(frames)[:1])
    while waiting:
        ready = [item for item in waiting if any(end.link in reached for end in item[1])]
        for prim, (first, second) in ready or waiting:  # what is not reached is no tree, which is told of it
            turned = first.link not in reached or (second.link in reached and second.link == root)
            made = _joint(prims, prim, second if turned else first, first if turned else second, turned)
            reached |= {first.link, second.link}
            yield made
        waiting = [item for item in waiting if ready and item not in ready]


def _odd(prims: Prims, prim: Usd.Prim) -> bool:
    """Whether a joint cannot be honoured, which is reported."""
    before = len(prims.faults.found)
    where = prims.where(prim)
    for breaks in ("Force", "Torque"):
        if float(prims.value(prim, f"physics:break{breaks}", math.inf)) < 1e30:
            prims.faults.add(where, "joints that break are not supported", f"author physics:break{breaks} = inf")
    if prims.value(prim, "physics:collisionEnabled", False):
        what = "the two links of a joint pass through each other"
        prims.faults.add(where, what, "author physics:collisionEnabled = false")
    if str(prim.GetTypeName()) == "PhysicsSphericalJoint":
        for name in ("coneAngle0Limit", "coneAngle1Limit"):
            if 0 <= float(prims.value(prim, f"physics:{name}", -1.0)) < math.inf:
                prims.faults.add(where, "ball joints with limits are not supported", f"author physics:{name} = -1")
    for i in (0, 1):
        paths = prim.GetRelationship(f"physics:body{i}").GetTargets()
        if len(paths) > 1 or (paths and not prims.stage.GetPrimAtPath(paths[0])):
            prims.faults.add(where, f"physics:body{i} is not one prim that exists", "target one, or none for the world")
    return len(prims.faults.found) > before


def _end(prims: Prims, prim: Usd.Prim, i: int, ends: Mapping[str, str], frames: Mapping[str, Array], root: str) -> _End:
    paths = prim.GetRelationship(f"physics:body{i}").GetTargets()
    at = prims.stage.GetPrimAtPath(paths[0] if paths else "/")
    link = next((ends[p] for p in map(str, at.GetPath().GetAncestorsRange()) if p in ends), root)
    here = np.array(prims.value(prim, f"physics:localPos{i}", (0, 0, 0)), float)
    turn = prims.value(prim, f"physics:localRot{i}", None)
    made = np.eye(4)
    made[:3, :3] = prims.rigid(at)[0][:3, :3]
    if turn is not None and turn.GetLength() > 0:
        made[:3, :3] = made[:3, :3] @ prims.turn(turn)
    made[:3, 3] = (prims.world(at) @ (*here, 1.0))[:3]
    return _End(link, inverse(frames[link]) @ made if link in frames else made, made)


def _joint(prims: Prims, prim: Usd.Prim, parent: _End, child: _End, turned: bool) -> Joint:
    """The joint by its ends at parent and child; `turned` if the file has them the other way round.

    Then its axis is turned too, and its coordinate stays the same.
    """
    kind = _KINDS[str(prim.GetTypeName())]
    axis = _AXES[str(prims.value(prim, "physics:axis", "X"))]
    along = -axis if turned else axis
    start = _start(prims, prim, kind, inverse(parent.world) @ child.world, along)
    low, high = _limits(prims, prim, kind)
    start = _allowed(prims, prim, start, low, high)
    stiffness, damping, target = _drive(prims, prim, kind)
    between = np.eye(4) if kind in ("hinge", "slider") else inverse(parent.world) @ child.world
    place, here = parent.own @ between @ inverse(child.own), child.own
    return Joint(
        prim.GetName(), prims.where(prim), kind, parent.link, child.link, place, here[:3, 3],
        here[:3, :3] @ along, low, high, damping, stiffness, target, start,
    )  # fmt: skip


def _start(prims: Prims, prim: Usd.Prim, kind: str, between: Array, axis: Array) -> float | None:
    """Where a joint is on the stage: what its frame at the child is, seen from that at the parent. It must fit."""
    gap, turn = between[:3, 3], between[:3, :3]
    angle = math.atan2(axis @ (turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]),
                       np.trace(turn) - 1)  # fmt: skip
    shift = float(gap @ axis)
    aside = float(np.linalg.norm(gap - shift * axis)) if kind == "slider" else float(np.linalg.norm(gap))
    bend = {"hinge": turn @ axis - axis, "ball": np.zeros(3)}.get(kind, turn - np.eye(3))
    if aside > _GAP or np.abs(bend).max() > _BEND:
        prims.faults.add(prims.where(prim), "its two ends do not meet", "correct its frames, or where its bodies are")
    return {"hinge": angle, "slider": shift}.get(kind)


def _allowed(prims: Prims, prim: Usd.Prim, start: float | None, low: float | None, high: float | None) -> float | None:
    """Where a joint starts, without the rounding that takes it beyond a limit."""
    if start is None:
        return None
    near = max(-math.inf if low is None else low, min(math.inf if high is None else high, start))
    if abs(near - start) > _GAP:
        prims.faults.add(prims.where(prim), "its bodies are beyond its limits", "move them, or correct its limits")
    return near


def _limits(prims: Prims, prim: Usd.Prim, kind: str) -> tuple[float | None, float | None]:
    """Its limits, rad or m; None where it has none."""
    if kind not in ("hinge", "slider"):
        return None, None
    unit = math.pi / 180 if kind == "hinge" else prims.meters
    found = [
        float(prims.value(prim, f"physics:{end}Limit", inf)) for end, inf in (("lower", -math.inf), ("upper", math.inf))
    ]
    low, high = (x * unit if math.isfinite(x) else None for x in found)
    if low is not None and high is not None and low >= high:
        prims.faults.add(prims.where(prim), "it can never move: its limits leave no room", "correct them, or fix it")
    return low, high


def _drive(prims: Prims, prim: Usd.Prim, kind: str) -> tuple[float, float, float | None]:
    """Stiffness, damping and target of its drive, SI."""
    name = {"hinge": "angular", "slider": "linear"}.get(kind, "")
    drives = [api for api in prim.GetAppliedSchemas() if api.startswith("PhysicsDriveAPI:")]
    for api in drives:
        if api != f"PhysicsDriveAPI:{name}":
            prims.faults.add(prims.where(prim), f"`{api}` is not supported here", "remove it")
            return 0.0, 0.0, None
    if not drives:
        return 0.0, 0.0, None
    own = f"drive:{name}:physics"
    if prims.value(prim, f"{own}:type", "force") != "force":
        prims.faults.add(prims.where(prim), "drives by acceleration are not supported", f"author {own}:type = force")
    if float(prims.value(prim, f"{own}:maxForce", math.inf)) < 1e30:
        prims.faults.add(prims.where(prim), "drives of limited force are not supported", f"remove {own}:maxForce")
    if prims.number(prim, f"{own}:targetVelocity", 0.0) != 0:
        prims.faults.add(prims.where(prim), "drives to a velocity are not supported", f"remove {own}:targetVelocity")
    unit = math.pi / 180 if kind == "hinge" else prims.meters
    force = prims.kilograms * prims.meters ** (2 if kind == "hinge" else 1)
    stiffness, damping = (prims.number(prim, f"{own}:{n}", 0.0) * force / unit for n in ("stiffness", "damping"))
    target = prims.number(prim, f"{own}:targetPosition", 0.0) * unit
    return stiffness, damping, target if stiffness > 0 else None
