"""URDF joints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

import numpy as np

from wmspec.lang.importers.markup import MAX_MAGNITUDE, Element, Reader
from wmspec.lang.importers.model import Joint, Link
from wmspec.lang.importers.urdf_links import origin
from wmspec.sim.scene.model import Array, Pose
from wmspec.sim.scene.model.transform import compose, from_rotation_vector, identity

_KINDS: dict[str, Literal["hinge", "slider", "ball", "fixed", "free"]] = {
    "revolute": "hinge",
    "continuous": "hinge",
    "prismatic": "slider",
    "fixed": "fixed",
    "floating": "free",
    "spherical": "ball",  # an extension of Bullet
}


_UNLIMITED = "it has no limits"
#: Elements for other programs.
_IGNORED = ("safety_controller", "calibration", "hardwareInterface", "limit_properties", "motor")
#: Limits of motors (https://docs.ros.org/en/rolling/p/urdf), which passive joints lack.
_MOTOR_LIMITS = ("effort", "velocity", "acceleration", "deceleration", "jerk")


class Joints:
    """Converts joints."""

    def __init__(self, read: Reader) -> None:
        self.read = read

    def joints(self, e: Element) -> Iterator[tuple[Joint, Link | None]]:
        """Yield a joint, or the joints of a planar one, each but the last with the frame that it moves."""
        planar = e.attributes.get("type") == "planar"
        made = self._joint(replace(e, attributes={**e.attributes, "type": "continuous"}) if planar else e)
        if made is None:
            return
        if not planar:
            yield made, None
            return
        what = "a planar joint is not supported"
        self.read.faults.approximate(e.where, what, "two sliders and a hinge with light links between", "use hinges")
        x = np.cross(made.axis, np.eye(3)[int(np.argmin(np.abs(made.axis)))])
        x /= np.linalg.norm(x)
        parent, place = made.parent, made.place
        for letter, axis in (("x", x), ("y", np.cross(made.axis, x))):
            frame = f"{made.child} {letter}"
            slide = replace(made, name=f"{made.name} {letter}", kind="slider", axis=axis, damping=0.0)
            yield replace(slide, parent=parent, child=frame, place=place), Link(frame, e.where)
            parent, place = frame, identity()
        yield replace(made, parent=parent, place=place), None

    def _joint(self, e: Element) -> Joint | None:
        """Return a joint, or None if it is invalid."""
        children = ("origin", "parent", "child", "axis", "limit", "dynamics")
        self.read.known(e, ("name", "type"), (*children, *_IGNORED, "mimic"))
        for mimic in e.all("mimic"):
            what = "a joint that mimics another is not supported in a spec"
            self.read.faults.approximate(e.where, what, "it does not follow", "let the spec drive it")
            self.read.known(mimic, ("joint", "multiplier", "offset"))
        ends = [self.read.only(e, end) for end in ("parent", "child")]
        for end in ends:
            if end is not None:
                self.read.known(end, ("link",))
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
        (low, high), axis, place = self._limits(e), self._axis(e), origin(self.read, e)
        if low is not None and low == high:  # it never moves
            turn = from_rotation_vector(axis * low) if kind == "hinge" else identity().orientation
            place = compose(place, Pose(axis * low if kind == "slider" else np.zeros(3), turn))
            kind, low, high = "fixed", None, None
        moves = kind in ("hinge", "slider")
        damping, (stiffness, target) = (self._damping(e), self._spring(e)) if moves else (0.0, (0.0, None))
        name = e.attributes.get("name", "")
        return Joint(
            name, e.where, kind, parent, child, place, np.zeros(3), axis, low, high, damping, stiffness, target
        )

    def _axis(self, joint: Element) -> Array:
        e = next(iter(joint.all("axis")), None)
        if e is not None:
            self.read.known(e, ("xyz",))
        axis = np.array(self.read.numbers(e, "xyz", 3, (1.0, 0.0, 0.0)) if e is not None else (1.0, 0.0, 0.0))
        size = float(np.linalg.norm(axis))
        if size < 1e-6 and joint.attributes.get("type") in ("fixed", "floating", "spherical"):
            return np.array((1.0, 0.0, 0.0))
        if size < 1e-6 and e is not None:
            self.read.faults.add(joint.where, "its axis is 0", 'write something like <axis xyz="0 0 1"/>')
            return np.array((1.0, 0.0, 0.0))
        return axis / size

    def _limits(self, joint: Element) -> tuple[float | None, float | None]:
        """Return the limits of a `revolute` or `prismatic` joint; Bullet ignores those without a range."""
        e = self.read.only(joint, "limit")
        if e is not None:
            self.read.known(e, ("lower", "upper", *_MOTOR_LIMITS))
        if joint.attributes.get("type") not in ("revolute", "prismatic"):
            return None, None
        if e is None or not ("lower" in e.attributes or "upper" in e.attributes):
            what, help = "a joint of this type needs `lower` and `upper`", "add them, or make it `continuous`"
            self.read.faults.approximate(joint.where, what, _UNLIMITED, help)
            return None, None
        low, high = (self._limit(e, name) for name in ("lower", "upper"))
        if low is not None and high is not None and low > high:
            what = f"its lower limit {low:g} is above its upper limit {high:g}"
            self.read.faults.approximate(joint.where, what, _UNLIMITED, "correct them")
            return None, None
        return low, high

    def _limit(self, e: Element, name: str) -> float | None:
        """Return one limit; None if it is so far away that it means that there is none."""
        try:
            far = abs(float(e.attributes.get(name, "0"))) > MAX_MAGNITUDE
        except ValueError:
            far = False
        return None if far else self.read.number(e, name, 0.0)

    def _spring(self, joint: Element) -> tuple[float, float | None]:
        """Return stiffness and rest position of Drake's and Gazebo's extension of `dynamics`."""
        e = next(iter(joint.all("dynamics")), None)
        stiffness = self.read.number(e, "spring_stiffness", 0.0) if e is not None else 0.0
        if e is None or stiffness <= 0:
            return 0.0, None
        return stiffness, self.read.number(e, "spring_reference", 0.0)

    def _damping(self, joint: Element) -> float:
        e = self.read.only(joint, "dynamics")
        if e is None:
            return 0.0
        self.read.known(e, ("damping", "friction", "spring_stiffness", "spring_reference"))
        if dry := self.read.number(e, "friction", 0.0):
            unit = "N" if joint.attributes.get("type") == "prismatic" else "N m"
            what = f"dry friction in joints ({dry:g} {unit}) is not supported"
            self.read.faults.approximate(joint.where, what, "left out", "use `damping`")
        damping = self.read.number(e, "damping", 0.0)
        if damping < 0:
            self.read.faults.add(joint.where, "its damping is below 0", "make it 0 or more")
        return max(0.0, damping)
