"""Imports URDF (https://wiki.ros.org/urdf/XML): passive mechanisms.

Elements for other programs are ignored silently: prefixed ones, those in `_IGNORED` here and in `urdf_joints`, those in
`_OTHERS` and `_SOLVER` in `urdf_links`, and the motor limits of `limit`. Other unknown elements and attributes are
ignored with a warning.
"""

from __future__ import annotations

from wmspec.lang.importers.markup import Element, Reader
from wmspec.lang.importers.model import MAX_LINKS, MAX_SHAPES, Asset, Faults, Joint, Link
from wmspec.lang.importers.urdf_joints import Joints
from wmspec.lang.importers.urdf_links import Links, MeshResolver, check_material, named_materials

#: Elements for other programs.
_IGNORED = (
    "gazebo",
    "transmission",
    "sensor",
    "ros2_control",
    "self_collision_checking",
    "disable_collisions",
    "group",
)


def urdf(robot: Element, find: MeshResolver, faults: Faults) -> Asset:
    """Return the asset of a URDF root element. Raises Broken if it is invalid."""
    if robot.tag != "robot":
        raise faults.stop(
            robot.where,
            "is neither a URDF nor an MJCF, whose roots are `robot` and `mujoco`",
            "is this the right file?",
        )
    return _asset(robot, Reader(faults), find)


def _asset(robot: Element, read: Reader, find: MeshResolver) -> Asset:
    """Return the links and joints; of duplicates the first."""
    read.known(robot, ("name", "version"), ("link", "joint", "material", *_IGNORED))
    for material in robot.all("material"):
        check_material(read, material)
    elements = robot.all("link")
    shapes = sum(len(e.all("visual")) + len(e.all("collision")) for e in elements)
    if len(elements) > MAX_LINKS or shapes > MAX_SHAPES:
        what = f"has more than {MAX_LINKS} links or {MAX_SHAPES} shapes"
        raise read.faults.stop(robot.where, what, "make it simpler")
    of_links = Links(read, find, named_materials(robot))
    make_joint = Joints(read).joints
    links: dict[str, Link] = {}
    joints: dict[str, Joint] = {}
    for e in elements:
        _once(read, e, links)
        links.setdefault(e.attributes.get("name", ""), of_links.link(e))
    for e in robot.all("joint"):
        _once(read, e, joints)
        for joint, frame in make_joint(e):
            joints.setdefault(joint.name, joint)
            if frame is not None:
                links.setdefault(frame.name, frame)
    held = {joint.child for joint in joints.values()}
    for name in (name for name in of_links.ignored_moments if name in held):
        what = "a link of mass 0 with moments of inertia is not supported"
        read.faults.approximate(of_links.ignored_moments[name], what, "they are left out", "set them to 0, or its mass")
    return Asset(links, joints)


def _once(read: Reader, e: Element, known: dict[str, Link] | dict[str, Joint]) -> None:
    if read.text(e, "name") in known:
        read.faults.add(e.where, f"there is another {e.tag} of this name", "rename one of them")
