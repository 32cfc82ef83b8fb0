"""The scene's joints as MJCF: a body below its parent, held by a joint; a drive is an actuator."""

from __future__ import annotations

from math import inf
from xml.etree import ElementTree as ET

import numpy as np

from wmspec.sim.scene.joints.articulations import Link
from wmspec.sim.scene.model import Friction, Scene
from wmspec.sim.scene.model.transform import rotate

from .impact import IMPEDANCE, solref
from .text import text

KINDS = {"hinge": "hinge", "slider": "slide", "ball": "ball"}
X = np.array([1.0, 0.0, 0.0])
FAR = 1e10  # rad or m: MuJoCo's own limit of what is finite


def hang(element: ET.Element, limb: Link, scene: Scene, step: float) -> None:
    """Give a body the joint that holds it to the body around it; none holds it fast. `step` in s."""
    if limb.kind == "fixed":
        return
    if limb.kind == "free":
        ET.SubElement(element, "freejoint", name=scene.bodies[limb.body].name)
        return
    joint = ET.Element("joint", name=scene.joints[limb.joint].name, type=KINDS[limb.kind], pos=text(limb.below[:3]))
    if limb.kind != "ball":
        joint.set("axis", text(rotate(np.array(limb.below[3:]), X)))
        joint.set("ref", text([limb.start]))
    if limb.limits:
        low, high = limb.limits
        joint.set("range", text([max(low, -FAR), min(high, FAR)]))
        joint.set("solreflimit", text(solref(Friction(), step)))
        joint.set("solimplimit", text([IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0]))
    element.insert(0, joint)


def actuator(root: ET.Element, limb: Link, scene: Scene) -> None:
    """A drive: the control is `stiffness * target + damping * velocity`."""
    stiffness, damping, _, _, most = limb.drive
    name = scene.joints[limb.joint].name
    made = ET.SubElement(root, "general", name=name, joint=name, biastype="affine", gainprm="1")
    made.set("biasprm", text([0.0, -stiffness, -damping]))
    if most < inf:
        made.set("forcerange", text([-most, most]))


def control(limb: Link) -> float:
    """What the actuator of a drive is told at the start."""
    stiffness, damping, target, velocity, _ = limb.drive
    return stiffness * target + damping * velocity
