"""Joints as MJCF: nested bodies with joints; drives are actuators."""

from __future__ import annotations

from math import inf
from xml.etree import ElementTree as ET

import numpy as np

from wmspec.sim.scene.joints.articulations import Link
from wmspec.sim.scene.model import Friction, Scene
from wmspec.sim.scene.model.transform import rotate

from .impact import SOLIMP, solref
from .text import text

KINDS = {"hinge": "hinge", "slider": "slide", "ball": "ball"}
X = np.array([1.0, 0.0, 0.0])
MAX_FINITE = 1e10  # rad or m: MuJoCo's limit of finite values


def add_joint(element: ET.Element, limb: Link, scene: Scene, step: float) -> None:
    """Add the joint between a body and its parent; none for a fixed one. `step` in s."""
    if limb.kind == "fixed":
        return
    if limb.kind == "free":
        ET.SubElement(element, "freejoint", name=scene.bodies[limb.body].name)
        return
    joint = ET.Element("joint", name=scene.joints[limb.joint].name, type=KINDS[limb.kind], pos=text(limb.below[:3]))
    if limb.kind != "ball":
        joint.set("axis", text(rotate(np.array(limb.below[3:]), X)))
        joint.set("ref", text([limb.start]))
    if limb.armature:
        joint.set("armature", text([limb.armature]))
    if limb.limits:
        low, high = limb.limits
        joint.set("range", text([max(low, -MAX_FINITE), min(high, MAX_FINITE)]))
        joint.set("solreflimit", text(solref(Friction(), step)))
        joint.set("solimplimit", text(SOLIMP))
    element.insert(0, joint)


def add_actuator(root: ET.Element, limb: Link, scene: Scene) -> None:
    """Add a drive; its control is `stiffness * target + damping * velocity`."""
    stiffness, damping, _, _, most = limb.drive
    name = scene.joints[limb.joint].name
    made = ET.SubElement(root, "general", name=name, joint=name, biastype="affine", gainprm="1")
    made.set("biasprm", text([0.0, -stiffness, -damping]))
    if most < inf:
        made.set("forcerange", text([-most, most]))


def initial_control(limb: Link) -> float:
    """Return the initial control of a drive."""
    stiffness, damping, target, velocity, _ = limb.drive
    return stiffness * target + damping * velocity
