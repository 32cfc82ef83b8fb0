"""URDF, as https://wiki.ros.org/urdf/XML has it: what bears on a passive mechanism is read, what cannot be is refused.

Not read, since they are for other programs: `gazebo`, `transmission`, `safety_controller`, `calibration`, whatever has
a prefix, and the `effort` and `velocity` of a limit, which bound a motor.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np

from wmspec.check.assets.frames import place
from wmspec.check.assets.markup import Element, Reader
from wmspec.check.assets.model import MOST_LINKS, MOST_SHAPES, Array, Asset, Color, Faults, Joint, Link, Mass, Shape

#: Where a mesh that is named in an element lies, seen from the spec; empty if it is nowhere, which was reported.
Find = Callable[[Element, str], str]

_KINDS: dict[str, Literal["hinge", "slider", "fixed", "free"]] = {
    "revolute": "hinge",
    "continuous": "hinge",
    "prismatic": "slider",
    "fixed": "fixed",
    "floating": "free",
}


def urdf(robot: Element, find: Find, faults: Faults) -> Asset:
    """The asset in the root element of a URDF. Raises Broken if it is none."""
    if robot.tag != "robot":
        raise faults.stop(
            robot.where,
            "is neither a URDF nor an MJCF, whose roots are `robot` and `mujoco`",
            "is this the right file?",
        )
    return _Urdf(robot, find, faults).asset()


class _Urdf(Reader):
    def __init__(self, robot: Element, find: Find, faults: Faults) -> None:
        super().__init__(faults)
        self.robot = robot
        self.find = find
        self.colors: dict[str, Color | None] = {}

    def asset(self) -> Asset:
        """The links and joints; of two of one name the first."""
        self.known(self.robot, ("name", "version"), ("link", "joint", "material", "gazebo", "transmission"))
        elements = self.robot.all("link")
        shapes = sum(len(e.all("visual")) + len(e.all("collision")) for e in elements)
        if len(elements) > MOST_LINKS or shapes > MOST_SHAPES:
            what = f"has more than {MOST_LINKS} links or {MOST_SHAPES} shapes"
            raise self.faults.stop(self.robot.where, what, "make it simpler")
        for material in self.robot.all("material"):
            self.colors[self.text(material, "name")] = self.color(material)
        links: dict[str, Link] = {}
        joints: dict[str, Joint] = {}
        for e in elements:
            self.once(e, links)
            links.setdefault(e.attributes.get("name", ""), self.link(e))
        for e in self.robot.all("joint"):
            self.once(e, joints)
            joint = self.joint(e)
            if joint is not None:
                joints.setdefault(joint.name, joint)
        return Asset(links, joints)

    def once(self, e: Element, known: dict[str, Link] | dict[str, Joint]) -> None:
        if self.text(e, "name") in known:
            self.faults.add(e.where, f"there is another {e.tag} of this name", "rename one of them")

    # ------------------------------------------------------------ links

    def link(self, e: Element) -> Link:
        """A link with all its shapes: what is drawn and touched alike is one shape."""
        self.known(e, ("name", "type"), ("inertial", "visual", "collision"))
        drawn = [s for v in e.all("visual") if (s := self.shape(v)) is not None]
        touched = [s for c in e.all("collision") if (s := self.shape(c)) is not None]
        shapes = []
        for s in drawn:
            same = next((t for t in touched if _alike(s, t)), None)
            touched = [t for t in touched if t is not same]
            shapes.append(replace(s, solid=same is not None))
        shapes += [replace(t, drawn=not drawn) for t in touched]
        return Link(e.attributes.get("name", ""), e.where, tuple(shapes), self.mass(e))

    def mass(self, link: Element) -> Mass | None:
        """What `inertial` says; None if there is none."""
        e = self.only(link, "inertial")
        if e is None:
            return None
        self.known(e, (), ("origin", "mass", "inertia"))
        mass, inertia = self.only(e, "mass"), self.only(e, "inertia")
        if mass is None or inertia is None:
            self.faults.add(
                link.where, "its `inertial` needs a `mass` and an `inertia`", "add it, or remove `inertial`"
            )
            return None
        self.known(mass, ("value",))
        names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        self.known(inertia, names)
        kg = self.number(mass, "value", above=0.0)
        xx, yy, zz = (self.number(inertia, name, above=0.0) for name in names[:3])
        xy, xz, yz = (self.number(inertia, name, 0.0) for name in names[3:])
        origin = self.origin(e)
        axes, tensor = origin[:3, :3], np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
        return Mass(kg, origin[:3, 3], axes @ tensor @ axes.T)

    def shape(self, e: Element) -> Shape | None:
        """A `visual` or `collision`."""
        drawn = e.tag == "visual"
        self.known(e, ("name",), ("origin", "geometry", *(("material",) if drawn else ())))
        geometry = self.only(e, "geometry")
        if geometry is None or len(geometry.children) != 1:
            self.faults.add(e.where, "it needs one `geometry` with one shape in it", "add it")
            return None
        self.known(geometry, (), ("box", "sphere", "cylinder", "capsule", "mesh"))
        made = self.form(geometry.children[0], self.origin(e))
        material = self.only(e, "material") if drawn else None
        return made if made is None or material is None else replace(made, color=self.material(material))

    def form(self, e: Element, here: Array) -> Shape | None:
        match e.tag:
            case "box":
                self.known(e, ("size",))
                return Shape("box", self.numbers(e, "size", 3, above=0.0), here)
            case "sphere":
                self.known(e, ("radius",))
                return Shape("sphere", (self.number(e, "radius", above=0.0),), here)
            case "cylinder" | "capsule":
                self.known(e, ("radius", "length"))
                radius, length = (self.number(e, name, above=0.0) for name in ("radius", "length"))
                if e.tag == "cylinder":
                    return Shape("cylinder", (radius, length), here)
                return Shape("capsule", (radius, length + 2 * radius), here)
            case "mesh":
                return self.mesh(e, here)
        return None  # it was complained about

    def mesh(self, e: Element, here: Array) -> Shape | None:
        self.known(e, ("filename", "scale"))
        scale = self.scale(e)
        file = self.find(e, self.text(e, "filename"))
        return Shape("mesh", (), here, file, scale) if file else None

    def material(self, e: Element) -> Color | None:
        """The colour of a `material`, which it says or which one of this name said."""
        own, name = self.color(e), e.attributes.get("name", "")
        if own is None and not e.children:
            if name not in self.colors:
                self.faults.add(e.where, "there is no material of this name", 'give it `<color rgba="..."/>`')
            return self.colors.get(name)
        self.colors.setdefault(name, own)
        return own

    def color(self, e: Element) -> Color | None:
        self.known(e, ("name",), ("color", "texture"))
        for texture in e.all("texture"):
            what, help = "textures of an asset are not supported", "use `color`, or `image:` in the spec"
            self.faults.add(texture.where, what, help)
        color = self.only(e, "color")
        if color is None:
            return None
        self.known(color, ("rgba",))
        r, g, b, a = self.numbers(color, "rgba", 4)
        if not all(0 <= x <= 1 for x in (r, g, b, a)):
            self.faults.add(e.where, "its colour is not four numbers from 0 to 1", "correct it")
        elif a < 1:
            self.faults.add(e.where, "what is transparent is not supported", "make the last number of its colour 1")
        return r, g, b

    # ------------------------------------------------------------ joints

    def joint(self, e: Element) -> Joint | None:
        """A joint; None if it makes no sense."""
        skipped = ("safety_controller", "calibration")
        said = ("origin", "parent", "child", "axis", "limit", "dynamics")
        self.known(e, ("name", "type"), (*said, *skipped, "mimic"))
        for mimic in e.all("mimic"):
            what = "joints that mimic others are not supported: the engines solve each by itself"
            self.faults.add(e.where, what, f"remove `mimic` (line {mimic.line})")
        ends = [self.only(e, end) for end in ("parent", "child")]
        kind = _KINDS.get(self.text(e, "type"))
        if kind is None:
            known = ", ".join(_KINDS)
            what = f"joints of type `{e.attributes.get('type', '')[:30]}` are not supported"
            self.faults.add(e.where, what, f"make it one of {known}")
        if kind is None or ends[0] is None or ends[1] is None:
            if None in ends:
                self.faults.add(e.where, "it needs a `parent` and a `child`", "add them")
            return None
        parent, child = (self.text(end, "link") for end in ends if end is not None)
        low, high = self.limits(e)
        return Joint(
            e.attributes.get("name", ""), e.where, kind, parent, child, self.origin(e), np.zeros(3),
            self.axis(e), low, high, self.damping(e),
        )  # fmt: skip

    def axis(self, joint: Element) -> Array:
        e = self.only(joint, "axis")
        found = np.array(self.numbers(e, "xyz", 3, (1.0, 0.0, 0.0)) if e is not None else (1.0, 0.0, 0.0))
        size = float(np.linalg.norm(found))
        if size < 1e-6 and e is not None:
            self.faults.add(joint.where, "its axis is 0", 'write something like <axis xyz="0 0 1"/>')
            return np.array((1.0, 0.0, 0.0))
        return found / size

    def limits(self, joint: Element) -> tuple[float | None, float | None]:
        """The limits of a `revolute` or `prismatic` joint, which must have some."""
        e = self.only(joint, "limit")
        if joint.attributes.get("type") not in ("revolute", "prismatic"):
            return None, None
        if e is None:
            self.faults.add(joint.where, "it needs a `limit`", "add it, or make a revolute joint `continuous`")
            return None, None
        self.known(e, ("lower", "upper", "effort", "velocity"))
        low, high = self.number(e, "lower", 0.0), self.number(e, "upper", 0.0)
        if low >= high:
            what = f"it can never move: its lower limit {low:g} is not below its upper limit {high:g}"
            self.faults.add(joint.where, what, "correct them, or make it `fixed`")
        return low, high

    def damping(self, joint: Element) -> float:
        e = self.only(joint, "dynamics")
        if e is None:
            return 0.0
        self.known(e, ("damping", "friction"))
        if self.number(e, "friction", 0.0) != 0:
            self.faults.add(
                joint.where, "dry friction in joints is not supported", "make it 0; `damping` slows a joint"
            )
        damping = self.number(e, "damping", 0.0)
        if damping < 0:
            self.faults.add(joint.where, "its damping is below 0", "make it 0 or more")
        return max(0.0, damping)

    def origin(self, e: Element) -> Array:
        """The place that its `origin` says."""
        origin = self.only(e, "origin")
        if origin is None:
            return place()
        self.known(origin, ("xyz", "rpy"))
        nowhere = (0.0, 0.0, 0.0)
        return place(self.numbers(origin, "xyz", 3, nowhere), self.numbers(origin, "rpy", 3, nowhere))


def _alike(a: Shape, b: Shape) -> bool:
    """Whether two shapes are the same in the same place, whatever they look like."""
    same = (a.kind, a.size, a.file, a.scale) == (b.kind, b.size, b.file, b.scale)
    return same and np.allclose(a.place, b.place, rtol=0, atol=1e-9)
