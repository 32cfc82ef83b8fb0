"""Joints of a compiled MJCF model, and the actuators that drive them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from wmspec.lang.importers.mjcf_model import Compiled
from wmspec.lang.importers.model import Faults, Joint
from wmspec.lang.importers.turns import X
from wmspec.sim.scene.joints.servos import SHARED_LIMIT, UnsupportedActuator, combined, servo, shares_limit
from wmspec.sim.scene.model import Drive, Pose

_Kind = Literal["hinge", "slider", "ball", "free"]


class Joints:
    """Converts joints and actuators. The coordinate of a joint is 0 as the file places its body."""

    def __init__(self, compiled: Compiled, faults: Faults) -> None:
        self._compiled, self._m, self._faults = compiled, compiled.model, faults
        kinds = compiled.mujoco.mjtJoint
        self._kinds: dict[int, _Kind] = {
            int(kinds.mjJNT_HINGE): "hinge",
            int(kinds.mjJNT_SLIDE): "slider",
            int(kinds.mjJNT_BALL): "ball",
            int(kinds.mjJNT_FREE): "free",
        }
        self._own: dict[int, str] = {}

    def name(self, j: int, body: str) -> str:
        """Return the name of a joint of a body."""
        first = int(self._m.body_jntadr[self._m.jnt_bodyid[j]])
        return self._m.joint(j).name or (f"{body} joint" if j == first else f"{body} joint_{j - first + 1}")

    def joint(self, j: int, body: str, parent: str, child: str, here: Pose) -> Joint:
        """Return a joint between two links; `here` is the pose of the child with the joint at 0."""
        m, e = self._m, self._compiled.joints[j]
        kind = self._kinds[int(m.jnt_type[j])]
        if kind == "free":
            self._free(j)
            return Joint(f"{body} free", e.where, kind, parent, child, here, np.zeros(3), X)
        name = self._own[j] = self.name(j, body)
        self._dry(j)
        stiffness, damping = float(m.jnt_stiffness[j]), float(m.dof_damping[m.jnt_dofadr[j]])
        at, axis = np.array(m.jnt_pos[j], np.float64), np.array(m.jnt_axis[j], np.float64)
        armature, low, high, target = float(m.dof_armature[m.jnt_dofadr[j]]), None, None, None
        if kind == "ball":
            if stiffness or damping:
                what = "springs and dampers in ball joints are not supported"
                self._faults.approximate(e.where, what, "left out", "use three hinges")
            if m.jnt_limited[j]:
                what = f"limits of ball joints ({math.degrees(m.jnt_range[j, 1]):.0f} deg) are not supported"
                self._faults.approximate(e.where, what, "left out", "use hinges")
            if armature:
                self._faults.approximate(
                    e.where, "`armature` of a ball joint is not supported", "left out", "use hinges"
                )
            stiffness = damping = armature = 0.0
        else:
            start = float(m.qpos0[m.jnt_qposadr[j]])
            if m.jnt_limited[j]:
                low, high = (float(x) - start for x in m.jnt_range[j])
                if not low <= 0.0 <= high:
                    what = "a start outside the limits of a joint is not supported"
                    self._faults.approximate(e.where, what, "it starts at the nearer limit", "set `start` of the joint")
            target = float(m.qpos_spring[m.jnt_qposadr[j]]) - start if stiffness else None
            stiffness, damping = self._positive(j, stiffness, damping)
        driven = (damping, stiffness, target)
        return Joint(name, e.where, kind, parent, child, here, at, axis, low, high, *driven, armature=armature)

    def _free(self, j: int) -> None:
        """Report properties of a free joint, which are left out."""
        m, where, first = self._m, self._compiled.joints[j].where, int(self._m.jnt_dofadr[j])
        dof = slice(first, first + 6)
        own = {"damping": m.dof_damping[dof], "armature": m.dof_armature[dof], "frictionloss": m.dof_frictionloss[dof]}
        for name in (name for name, values in {**own, "stiffness": m.jnt_stiffness[j]}.items() if np.any(values)):
            what = f"`{name}` of a free joint is not supported"
            help = "set `damping` of the link" if name == "damping" else ""
            self._faults.approximate(where, what, "left out", help)

    def _positive(self, j: int, stiffness: float, damping: float) -> tuple[float, float]:
        if min(stiffness, damping) < 0:
            self._faults.add(self._compiled.joints[j].where, "its stiffness or damping is below 0", "make it 0 or more")
        return max(0.0, stiffness), max(0.0, damping)

    def _dry(self, j: int) -> None:
        """Report properties of a joint that are left out, with their sizes."""
        m, where, dof = self._m, self._compiled.joints[j].where, int(self._m.jnt_dofadr[j])
        unit = "N" if self._kinds[int(m.jnt_type[j])] == "slider" else "N m"
        if m.dof_frictionloss[dof]:
            what = f"dry friction in joints ({float(m.dof_frictionloss[dof]):.2g} {unit}) is not supported"
            self._faults.approximate(where, what, "left out", "use `damping`")
        if np.any(m.jnt_stiffnesspoly[j]) or np.any(m.dof_dampingpoly[dof]):
            what = "springs and dampers by polynomials are not supported"
            self._faults.approximate(where, what, "their linear part", "")

    # ------------------------------------------------------------ actuators

    def drive(self, joints: dict[str, Joint]) -> None:
        """Add the drives of position and velocity actuators; others are reported."""
        for a in range(int(self._m.nu)):
            where = self._compiled.actuators[a].where
            try:
                name, own = self._actuator(a)
                joint = joints.get(name)
                if joint is None or joint.kind not in ("hinge", "slider"):
                    raise UnsupportedActuator("of no hinge or slide is not supported")
                if shares_limit(_spring(joint), own):
                    self._faults.approximate(where, SHARED_LIMIT, "it limits their sum", "")
                joints[name] = _driven(joint, own)
            except UnsupportedActuator as error:
                self._faults.approximate(where, f"an actuator {error}", "left out", "let the spec exert a `force`")

    def _actuator(self, a: int) -> tuple[str, Drive]:
        """Return the joint and the drive of an actuator, about the coordinate of the joint here."""
        m, mj = self._m, self._compiled.mujoco
        affine = int(m.actuator_biastype[a]) == int(mj.mjtBias.mjBIAS_AFFINE)
        known = affine or int(m.actuator_biastype[a]) == int(mj.mjtBias.mjBIAS_NONE)
        if not known or int(m.actuator_gaintype[a]) not in (
            int(mj.mjtGain.mjGAIN_FIXED),
            int(mj.mjtGain.mjGAIN_AFFINE),
        ):
            raise UnsupportedActuator("of this type is not supported")
        control = _range(m.actuator_ctrlrange[a]) if m.actuator_ctrllimited[a] else None
        bias = [float(x) for x in m.actuator_biasprm[a, :3]] if affine else [0.0, 0.0, 0.0]
        j = int(m.actuator_trnid[a, 0])
        gear = float(m.actuator_gear[a, 0])
        made = servo(float(m.actuator_gainprm[a, 0]), bias, gear, control, self._force_range(a, j, gear))
        start = float(m.qpos0[m.jnt_qposadr[j]])
        return self._own.get(j, ""), replace(made, target=made.target - start if made.stiffness else 0.0)

    def _force_range(self, a: int, j: int, gear: float) -> tuple[float, float] | None:
        """Return the range of an actuator's force, also limited by the range of the force on its joint."""
        m, own = self._m, (-math.inf, math.inf)
        if m.actuator_forcelimited[a]:
            own = _range(m.actuator_forcerange[a])
        if m.jnt_actfrclimited[j] and gear:
            low, high = sorted(x / gear for x in _range(m.jnt_actfrcrange[j]))
            own = max(own[0], low), min(own[1], high)
        return own if math.isfinite(max(own)) or math.isfinite(min(own)) else None


def _driven(joint: Joint, own: Drive) -> Joint:
    """Return a joint with a drive added to its spring and damper."""
    made = combined(_spring(joint), own)
    return replace(
        joint,
        stiffness=made.stiffness,
        damping=made.damping,
        target=made.target if made.stiffness else None,
        pace=made.velocity,
        strength=made.max_force if math.isfinite(made.max_force) else None,
    )


def _spring(joint: Joint) -> Drive:
    """Return the spring and damper of a joint as a drive."""
    most = math.inf if joint.strength is None else joint.strength
    return Drive(joint.stiffness, joint.damping, joint.target or 0.0, joint.pace, most)


def _range(numbers: Sequence[float]) -> tuple[float, float]:
    low, high = numbers
    return float(low), float(high)
