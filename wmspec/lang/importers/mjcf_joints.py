"""MJCF joints, and the position actuators that drive them."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from wmspec.lang.importers.markup import Element
from wmspec.lang.importers.mjcf_defaults import Defaults
from wmspec.lang.importers.model import Joint
from wmspec.lang.importers.turns import X
from wmspec.sim.scene.model import Pose

_KINDS: dict[str, Literal["hinge", "slider", "ball", "free"]] = {
    "hinge": "hinge",
    "slide": "slider",
    "ball": "ball",
    "free": "free",
}
_JOINT = (
    "name", "type", "pos", "axis", "range", "limited", "stiffness", "damping", "springref", "group", "frictionloss",
    "armature", "ref",
)  # fmt: skip
_POSITION = ("name", "joint", "kp", "kv", "gear", "ctrlrange", "ctrllimited", "group")


class Joints:
    """Creates the joint between a body and its parent."""

    def __init__(self, read: Defaults) -> None:
        self.read = read
        self.faults = read.faults

    def of(self, body: Element, parent: str, inherited: str) -> Joint:
        """Return the joint of a body; a body without a joint is fixed."""
        name, here = body.attributes["name"], self.read.place(body)
        free = body.all("freejoint")
        joints = [*free, *(self.read.full(e, inherited) for e in body.all("joint"))]
        if len(joints) > 1:
            what = "several joints of one body are not supported"
            self.faults.add(joints[1].where, what, "put a body, with a geom, between each two of them")
        if not joints:
            return Joint(f"{name} fixed", body.where, "fixed", parent, name, here, np.zeros(3), X)
        joint = joints[0]
        if free:
            self.read.known(joint, ("name", "group", "align"))
            return Joint(f"{name} free", joint.where, "free", parent, name, here, np.zeros(3), X)
        return self._joint(joint, name, parent, here)

    def _joint(self, e: Element, body: str, parent: str, here: Pose) -> Joint:
        self.read.known(e, _JOINT)
        type_ = e.attributes.get("type", "hinge")
        kind = _KINDS.get(type_)
        if kind is None:
            what = f"joints of type `{type_[:30]}` are not supported"
            self.faults.add(e.where, what, f"make it one of {', '.join(_KINDS)}")
            kind = "hinge"
        for name in ("frictionloss", "armature", "ref"):
            if self.read.number(e, name, 0.0) != 0:
                self.faults.add(e.where, f"`{name}` of a joint is not supported", "make it 0")
        axis = np.array(self.read.numbers(e, "axis", 3, (0.0, 0.0, 1.0)))
        size = float(np.linalg.norm(axis))
        if size < 1e-6:
            self.faults.add(e.where, "its axis is 0", 'write something like axis="0 0 1"')
            axis, size = X, 1.0
        at = np.array(self.read.numbers(e, "pos", 3, (0.0, 0.0, 0.0)))
        low, high = self._limits(e, kind)
        stiffness, damping, rest = (self.read.number(e, n, 0.0) for n in ("stiffness", "damping", "springref"))
        if kind == "ball" and (stiffness or damping):
            self.faults.add(e.where, "springs and dampers in ball joints are not supported", "make them 0")
        if min(stiffness, damping) < 0:
            self.faults.add(e.where, "its stiffness or damping is below 0", "make it 0 or more")
        unit = self.read.angle if kind == "hinge" else 1.0
        name = e.attributes.get("name") or f"{body} joint"
        spring = rest * unit if stiffness else None
        return Joint(name, e.where, kind, parent, body, here, at, axis / size, low, high, damping, stiffness, spring)

    def _limits(self, e: Element, kind: str) -> tuple[float | None, float | None]:
        limited = e.attributes.get("limited", "auto")
        if limited == "false" or "range" not in e.attributes or (limited == "auto" and not self.read.limited):
            return None, None
        low, high = self.read.numbers(e, "range", 2)
        if kind == "ball":
            self.faults.add(e.where, "ball joints with limits are not supported", "remove `range`")
            return None, None
        if low >= high and limited == "auto":  # MuJoCo: no limit
            return None, None
        if low >= high:
            self.faults.add(e.where, "it can never move: its range leaves no room", "correct it, or remove the joint")
        unit = self.read.angle if kind == "hinge" else 1.0
        return low * unit, high * unit

    def drive(self, root: Element, joints: dict[str, Joint]) -> None:
        """Add the drives defined by `position` actuators."""
        for e in (e for actuators in root.all("actuator") for e in actuators.children):
            if e.tag != "position":
                what = f"`{e.tag}` actuators are not supported"
                self.faults.add(e.where, what, "make it `position`, or remove it and let the spec pull with a `force`")
                continue
            full = self.read.full(e, "")
            self.read.known(full, _POSITION)
            joint = joints.get(full.attributes.get("joint", ""))
            if joint is None or joint.kind not in ("hinge", "slider"):
                self.faults.add(e.where, "it drives no hinge or slide", "correct its `joint`")
                continue
            if joint.stiffness:
                self.faults.add(e.where, f"`{joint.name}` has a spring or another drive already", "keep one of them")
            gear = self.read.numbers(full, "gear", len(full.attributes.get("gear", "1").split()), (1.0,))[0]
            if gear == 0:
                self.faults.add(e.where, "its gear is 0: it moves nothing", "correct it, or remove the actuator")
            kp, kv = self.read.number(full, "kp", 1.0, above=0.0), self.read.number(full, "kv", 0.0)
            joints[joint.name] = replace(
                joint, stiffness=kp * gear**2, damping=joint.damping + kv * gear**2, target=0.0
            )
