"""URDF, as https://wiki.ros.org/urdf/XML has it: what bears on a passive mechanism is read, what cannot be is refused.

Not read, since they are for other programs: `gazebo`, `transmission`, `safety_controller`, `calibration`, whatever has
a prefix, and the `effort` and `velocity` of a limit, which bound a motor.
"""

from __future__ import annotations

from wmspec.lang.importers.markup import Element, Reader
from wmspec.lang.importers.model import MOST_LINKS, MOST_SHAPES, Asset, Faults, Joint, Link
from wmspec.lang.importers.urdf_joints import Joints
from wmspec.lang.importers.urdf_links import Find, Links


def urdf(robot: Element, find: Find, faults: Faults) -> Asset:
    """The asset in the root element of a URDF. Raises Broken if it is none."""
    if robot.tag != "robot":
        raise faults.stop(
            robot.where,
            "is neither a URDF nor an MJCF, whose roots are `robot` and `mujoco`",
            "is this the right file?",
        )
    return _asset(robot, Reader(faults), find)


def _asset(robot: Element, read: Reader, find: Find) -> Asset:
    """The links and joints; of two of one name the first."""
    read.known(robot, ("name", "version"), ("link", "joint", "material", "gazebo", "transmission"))
    elements = robot.all("link")
    shapes = sum(len(e.all("visual")) + len(e.all("collision")) for e in elements)
    if len(elements) > MOST_LINKS or shapes > MOST_SHAPES:
        what = f"has more than {MOST_LINKS} links or {MOST_SHAPES} shapes"
        raise read.faults.stop(robot.where, what, "make it simpler")
    make_link = Links(read, find, {read.text(m, "name"): m for m in robot.all("material")}).link
    make_joint = Joints(read).joint
    links: dict[str, Link] = {}
    joints: dict[str, Joint] = {}
    for e in elements:
        _once(read, e, links)
        links.setdefault(e.attributes.get("name", ""), make_link(e))
    for e in robot.all("joint"):
        _once(read, e, joints)
        joint = make_joint(e)
        if joint is not None:
            joints.setdefault(joint.name, joint)
    return Asset(links, joints)


def _once(read: Reader, e: Element, known: dict[str, Link] | dict[str, Joint]) -> None:
    if read.text(e, "name") in known:
        read.faults.add(e.where, f"there is another {e.tag} of this name", "rename one of them")
