"""URDF links: visuals, collisions, colours, masses."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from wmspec.lang.importers.markup import Element, Reader
from wmspec.lang.importers.model import (
    OVERRIDING_PROPERTIES,
    Appearance,
    Color,
    Form,
    Link,
    MeshFile,
    Shape,
    conditional,
)
from wmspec.lang.importers.turns import pose_from_rpy
from wmspec.sim.scene.model import Inertia, Pose
from wmspec.sim.scene.model.transform import multiply, rotation
from wmspec.sim.scene.physics.inertia import principal
from wmspec.sim.shapes import Box, Capsule, Cylinder, Sphere

#: Resolves a mesh reference to a path relative to the spec; '' if it is missing, which is reported.
MeshResolver = Callable[[Element, str], str]

#: Children of `contact`, and the property of an object that each sets.
_CONTACT = {"lateral_friction": "friction", "restitution": "restitution"}


class Links:
    """Converts links; `materials` collects the named materials."""

    def __init__(self, read: Reader, find: MeshResolver, materials: dict[str, Element]) -> None:
        self.read = read
        self.find = find
        self.materials = materials

    def link(self, e: Element) -> Link:
        """Return a link with all its shapes; an equal visual and collision are one shape."""
        self.read.known(e, ("name", "type"), ("inertial", "visual", "collision", "contact"))
        drawn = [s for v in e.all("visual") if (s := self._shape(v)) is not None]
        touched = [s for c in e.all("collision") if (s := self._shape(c)) is not None]
        shapes = []
        for s in drawn:
            same = next((t for t in touched if _same_geometry(s, t)), None)
            touched = [t for t in touched if t is not same]
            shapes.append(replace(s, solid=same is not None))
        shapes += [replace(t, drawn=not drawn) for t in touched]
        return Link(e.attributes.get("name", ""), e.where, tuple(shapes), self._mass(e), self._contact(e))

    def _contact(self, link: Element) -> dict[str, float]:
        """Return friction and restitution of Bullet's extension `contact` (PyBullet Quickstart Guide, "URDF")."""
        e = self.read.only(link, "contact")
        if e is None:
            return {}
        self.read.known(e, (), tuple(_CONTACT))
        given: dict[str, float] = {}
        for tag, name in _CONTACT.items():
            child = self.read.only(e, tag)
            if child is not None:
                self.read.known(child, ("value",))
                given[name] = self._coefficient(child, highest=1.0 if name == "restitution" else math.inf)
        return given

    def _coefficient(self, e: Element, highest: float) -> float:
        value = self.read.number(e, "value")
        if not 0 <= value <= highest:
            bounds = "0 or more" if highest == math.inf else f"from 0 to {highest:g}"
            self.read.faults.add(e.where, f"`{e.tag}` is {value:g}", f"make it {bounds}")
        return value

    def _mass(self, link: Element) -> Inertia | None:
        """Return the `inertial`, or None."""
        e = self.read.only(link, "inertial")
        if e is None:
            return None
        self.read.known(e, (), ("origin", "mass", "inertia"))
        mass, inertia = self.read.only(e, "mass"), self.read.only(e, "inertia")
        if mass is None or inertia is None:
            self.read.faults.add(
                link.where, "its `inertial` needs a `mass` and an `inertia`", "add it, or remove `inertial`"
            )
            return None
        self.read.known(mass, ("value",))
        names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        self.read.known(inertia, names)
        kg = self.read.number(mass, "value", above=0.0)
        xx, yy, zz = (self.read.number(inertia, name, above=0.0) for name in names[:3])
        xy, xz, yz = (self.read.number(inertia, name, 0.0) for name in names[3:])
        here, tensor = origin(self.read, e), np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
        axes, moments = principal(tensor)
        return Inertia(kg, here.position, multiply(here.orientation, axes), moments)

    def _shape(self, e: Element) -> Shape | None:
        """Return a `visual` or `collision`."""
        drawn = e.tag == "visual"
        self.read.known(e, ("name",), ("origin", "geometry", *(("material",) if drawn else ())))
        geometry = self.read.only(e, "geometry")
        if geometry is None or len(geometry.children) != 1:
            self.read.faults.add(e.where, "it needs one `geometry` with one shape in it", "add it")
            return None
        self.read.known(geometry, (), ("box", "sphere", "cylinder", "capsule", "mesh"))
        here = origin(self.read, e)
        form = self._form(geometry.children[0])
        return Shape(form, here, self._look(e) if drawn else Appearance()) if form else None

    def _form(self, e: Element) -> Form | None:
        match e.tag:
            case "box":
                self.read.known(e, ("size",))
                x, y, z = self.read.numbers(e, "size", 3, above=0.0)
                return Box((x / 2, y / 2, z / 2))
            case "sphere":
                self.read.known(e, ("radius",))
                return Sphere(self.read.number(e, "radius", above=0.0))
            case "cylinder" | "capsule":
                self.read.known(e, ("radius", "length"))
                radius, length = (self.read.number(e, name, above=0.0) for name in ("radius", "length"))
                return (Cylinder if e.tag == "cylinder" else Capsule)(radius, length)
            case "mesh":
                return self._mesh(e)
        return None  # already reported

    def _mesh(self, e: Element) -> MeshFile | None:
        self.read.known(e, ("filename", "scale"))
        scale = self.read.scale(e)
        file = self.find(e, self.read.text(e, "filename"))
        return MeshFile(file, scale) if file else None

    def _look(self, e: Element) -> Appearance:
        """Return the colour of a `visual`, with errors."""
        with self.read.faults.separately() as faults:
            material = self.read.only(e, "material")
            color = self._color(self._definition(material)) if material is not None else None
        return Appearance(color, conditional=conditional(faults, OVERRIDING_PROPERTIES))

    def _definition(self, material: Element) -> Element:
        """Return the definition of a `material`: itself, or the first one of its name."""
        name = material.attributes.get("name", "")
        if material.children:
            self.materials.setdefault(name, material)
        elif name not in self.materials:
            self.read.faults.add(material.where, "there is no material of this name", 'give it `<color rgba="..."/>`')
        return material if material.children else self.materials.get(name, material)

    def _color(self, e: Element) -> Color | None:
        self.read.known(e, ("name",), ("color", "texture"))
        for texture in e.all("texture"):
            what, help = "textures of an asset are not supported", "remove it"
            self.read.faults.add(texture.where, what, help)
        color = self.read.only(e, "color")
        if color is None:
            return None
        self.read.known(color, ("rgba",))
        r, g, b, a = self.read.numbers(color, "rgba", 4)
        if not all(0 <= x <= 1 for x in (r, g, b, a)):
            self.read.faults.add(e.where, "its colour is not four numbers from 0 to 1", "correct it")
        elif a < 1:
            self.read.faults.add(
                e.where, "what is transparent is not supported", "make the last number of its colour 1"
            )
        return r, g, b


def origin(read: Reader, e: Element) -> Pose:
    """Return the pose given by `origin`."""
    origin_ = read.only(e, "origin")
    if origin_ is None:
        return pose_from_rpy()
    read.known(origin_, ("xyz", "rpy"))
    nowhere = (0.0, 0.0, 0.0)
    return pose_from_rpy(read.numbers(origin_, "xyz", 3, nowhere), read.numbers(origin_, "rpy", 3, nowhere))


def _same_geometry(a: Shape, b: Shape) -> bool:
    """Whether two shapes have the same geometry and pose."""
    if a.form != b.form:
        return False
    here, there = ((s.pose.position, rotation(s.pose.orientation)) for s in (a, b))
    return all(np.allclose(x, y, rtol=0, atol=1e-9) for x, y in zip(here, there, strict=True))
