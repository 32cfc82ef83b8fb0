"""URDF joints."""

from __future__ import annotations

from typing import Literal

import numpy as np

from wmspec.lang.importers.markup import Element, Reader
from wmspec.lang.importers.model import Joint
from wmspec.lang.importers.urdf_links import origin
from wmspec.sim.scene.model import Array

_KINDS: dict[str, Literal["hinge", "slider", "fixed", "free"]] = {
    "revolute": "hinge",
    "continuous": "hinge",
    "prismatic": "slider",
    "fixed": "fixed",
    "floating": "free",
}


class Joints:
    """Converts joints."""

    def __init__(self, read: Reader) -> None:
        self.read = read

    def joint(self, e: Element) -> Joint | None:
        """Return a joint, or None if it is invalid."""
        skipped = ("safety_controller", "calibration")
        children = ("origin", "parent", "child", "axis", "limit", "dynamics")
        self.read.known(e, ("name", "type"), (*children, *skipped, "mimic"))
        for mimic in e.all("mimic"):
            what = "a spec cannot say that a joint mimics another; `wmspec run` of a USD stage can"
            self.read.faults.add(e.where, what, f"remove `mimic` (line {mimic.line})")
        ends = [self.read.only(e, end) for end in ("parent", "child")]
        kind = _KINDS.get(self.read.text(e, "type"))
        if kind is None:
            known = ", ".join(_KINDS)
            what = f"joints of type `{e.attributes.get('type', '')[:30]}` are not supported"
            self.read.faults.add(e.where, what, f"make it one of {known}")
        if kind is None or ends[0] is None or ends[1] is None:
            if None in ends:
                self.read.faults.add(e.where, "it needs a `parent` and a `child`", "add them")
            return None
        parent, child = (self.read.text(end, "link") for end in ends if end is not None)
        low, high = self._limits(e)
        return Joint(
            e.attributes.get("name", ""), e.where, kind, parent, child, origin(self.read, e), np.zeros(3),
            self._axis(e), low, high, self._damping(e),
        )  # fmt: skip

    def _axis(self, joint: Element) -> Array:
        e = self.read.only(joint, "axis")
        axis = np.array(self.read.numbers(e, "xyz", 3, (1.0, 0.0, 0.0)) if e is not None else (1.0, 0.0, 0.0))
        size = float(np.linalg.norm(axis))
        if size < 1e-6 and e is not None:
            self.read.faults.add(joint.where, "its axis is 0", 'write something like <axis xyz="0 0 1"/>')
            return np.array((1.0, 0.0, 0.0))
        return axis / size

    def _limits(self, joint: Element) -> tuple[float | None, float | None]:
        """Return the limits of a `revolute` or `prismatic` joint, which are required."""
        e = self.read.only(joint, "limit")
        if joint.attributes.get("type") not in ("revolute", "prismatic"):
            return None, None
        if e is None:
            self.read.faults.add(joint.where, "it needs a `limit`", "add it, or make a revolute joint `continuous`")
            return None, None
        self.read.known(e, ("lower", "upper", "effort", "velocity"))
        low, high = self.read.number(e, "lower", 0.0), self.read.number(e, "upper", 0.0)
        if low >= high:
            what = f"it can never move: its lower limit {low:g} is not below its upper limit {high:g}"
            self.read.faults.add(joint.where, what, "correct them, or make it `fixed`")
        return low, high

    def _damping(self, joint: Element) -> float:
        e = self.read.only(joint, "dynamics")
        if e is None:
            return 0.0
        self.read.known(e, ("damping", "friction"))
        if self.read.number(e, "friction", 0.0) != 0:
            self.read.faults.add(
                joint.where, "dry friction in joints is not supported", "make it 0; `damping` slows a joint"
            )
        damping = self.read.number(e, "damping", 0.0)
        if damping < 0:
            self.read.faults.add(joint.where, "its damping is below 0", "make it 0 or more")
        return max(0.0, damping)
