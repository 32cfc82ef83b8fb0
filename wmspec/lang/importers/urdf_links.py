"""URDF links: visuals, collisions, colours, masses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from wmspec.core.places import FilePlace
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
#: Children of `contact` that only concern how Bullet computes.
_SOLVER = ("friction_anchor", "contact_erp", "contact_cfm", "inertia_scaling")
#: The moments and products of inertia.
_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
#: Highest friction of a spec.
_MAX_FRICTION = 5.0
#: Children for other programs.
_OTHERS = ("self_collision_checking", "self_filter", "verbose", "sensor", "audio_source", "inertial_frame", "surface")


class Links:
    """Converts links; `materials` collects the named materials.

    `ignored_moments` has the place of each link without mass that has moments of inertia.
    """

    def __init__(self, read: Reader, find: MeshResolver, materials: dict[str, Element]) -> None:
        self.read = read
        self.find = find
        self.materials = materials
        self.ignored_moments: dict[str, FilePlace] = {}

    def link(self, e: Element) -> Link:
        """Return a link with all its shapes; an equal visual and collision are one shape."""
        self.read.known(e, ("name", "type"), ("inertial", "visual", "collision", "contact", *_OTHERS))
        drawn = [s for v in e.all("visual") if (s := self._visual(v)) is not None]
        touched = [s for c in e.all("collision") if (s := self._shape(c)) is not None]
        shapes = []
        for s in drawn:
            same = next((t for t in touched if _same_geometry(s, t)), None)
            touched = [t for t in touched if t is not same]
            shapes.append(replace(s, solid=same is not None))
        shapes += [replace(t, drawn=not drawn) for t in touched]
        mass, massless = self._mass(e)
        name = e.attributes.get("name", "")
        return Link(name, e.where, tuple(shapes), mass, self._contact(e), massless=massless and bool(shapes))

    def _contact(self, link: Element) -> dict[str, float]:
        """Return friction and restitution of Bullet's extension `contact` (PyBullet Quickstart Guide, "URDF")."""
        e = self.read.only(link, "contact")
        if e is None:
            return {}
        self.read.known(e, (), (*_CONTACT, *_SOLVER))
        given: dict[str, float] = {}
        for tag, name in _CONTACT.items():
            child = self.read.only(e, tag)
            if child is not None:
                given[name] = self._coefficient(child, highest=1.0 if name == "restitution" else _MAX_FRICTION)
        return given

    def _coefficient(self, e: Element, highest: float) -> float:
        self.read.known(e, ("value",))
        value = self.read.number(e, "value")
        if value < 0 or (value > highest and e.tag == "restitution"):
            bounds = f"from 0 to {highest:g}" if e.tag == "restitution" else "0 or more"
            self.read.faults.add(e.where, f"`{e.tag}` is {value:g}", f"make it {bounds}")
        elif value > highest:
            self.read.faults.approximate(e.where, f"a friction of {value:g} is not supported", f"it is {highest:g}", "")
        return min(value, highest)

    def _mass(self, link: Element) -> tuple[Inertia | None, bool]:
        """Return the `inertial`, or None, and whether it has a mass of 0. Without `inertia` the moments are 0."""
        e = self.read.only(link, "inertial")
        if e is None:
            return None, False
        self.read.known(e, (), ("origin", "mass", "inertia"))
        mass, inertia = self.read.only(e, "mass"), self.read.only(e, "inertia")
        if mass is None:
            self.read.faults.approximate(e.where, "an `inertial` without a `mass`", "that of the density", "add it")
            return None, False
        self.read.known(mass, ("value",))
        if inertia is not None:
            self.read.known(inertia, _INERTIA)
        kg = self.read.number(mass, "value")
        if kg < 0:
            self.read.faults.add(mass.where, f"a mass of {kg:g} kg", "make it 0 or more")
        values = [0.0] * 6 if inertia is None else [self.read.number(inertia, name, 0.0) for name in _INERTIA]
        if kg <= 0:
            if any(values):
                self.ignored_moments[link.attributes.get("name", "")] = link.where
            return None, True
        xx, yy, zz, xy, xz, yz = values
        here, tensor = origin(self.read, e), np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
        axes, moments = principal(tensor)
        return Inertia(kg, here.position, multiply(here.orientation, axes), moments), False

    def _visual(self, e: Element) -> Shape | None:
        """Return a `visual`, or None, with a warning if it cannot be read: motion does not depend on it."""
        with self.read.faults.separately() as faults:
            made = self._shape(e)
        for fault in faults:
            help, text = fault.help, fault.message.removesuffix(": left out")
            where = fault.place if isinstance(fault.place, FilePlace) else e.where
            if fault.severity == "error":
                self.read.faults.approximate(where, text, "left out of pictures", help)
            else:
                self.read.faults.warnings.append(fault)
        return None if any(fault.severity == "error" for fault in faults) else made

    def _shape(self, e: Element) -> Shape | None:
        """Return a `visual` or `collision`."""
        drawn = e.tag == "visual"
        self.read.known(e, ("name", "group", "concave"), ("origin", "geometry", "material", *_OTHERS))
        for material in e.all("material"):
            check_material(self.read, material)
        geometry = self.read.only(e, "geometry")
        if geometry is None or len(geometry.children) != 1:
            self.read.faults.add(e.where, "it needs one `geometry` with one shape in it", "add it")
            return None
        self.read.known(geometry, ("name",), [geometry.children[0].tag])  # `_form` reports an unknown shape
        here = origin(self.read, e)
        form = self._form(geometry.children[0])
        if form is None:
            return None
        look, opaque = self._look(e) if drawn else (Appearance(), True)
        return Shape(form, here, look, drawn=opaque)

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
            case "plane":
                self.read.faults.approximate(
                    e.where, "planes are not supported", "left out", "the ground is the spec's"
                )
                return None
        self.read.faults.add(e.where, f"geometries of type `{e.tag}` are not supported", "make it a mesh")
        return None

    def _mesh(self, e: Element) -> MeshFile | None:
        self.read.known(e, ("filename", "scale"))
        scale = self.read.scale(e)
        file = self.find(e, self.read.text(e, "filename"))
        return MeshFile(file, scale) if file else None

    def _look(self, e: Element) -> tuple[Appearance, bool]:
        """Return the colour of a `visual`, with what is approximated, and whether it can be seen."""
        with self.read.faults.separately() as faults:
            material = next(iter(e.all("material")), None)
            color, alpha = self._color(self._definition(material)) if material is not None else (None, 1.0)
        return Appearance(color, conditional=conditional(faults, OVERRIDING_PROPERTIES)), alpha > 0

    def _definition(self, material: Element) -> Element:
        """Return the definition of a `material`: itself, or the first one of its name in the file."""
        if material.children:
            return material
        name = material.attributes.get("name", "")
        if name and name not in self.materials:
            what, help = "there is no material of this name", 'give it `<color rgba="..."/>`'
            self.read.faults.approximate(material.where, what, "a plain colour is drawn", help)
        return self.materials.get(name, material)

    def _color(self, e: Element) -> tuple[Color | None, float]:
        """Return the colour of a material, and its opacity."""
        for texture in e.all("texture"):
            what, help = "textures of an asset are not supported", "remove it"
            self.read.faults.approximate(texture.where, what, "its plain colour is drawn", help)
        color = self.read.only(e, "color")
        if color is None:
            return None, 1.0
        r, g, b, a = self.read.numbers(color, "rgba", 4)
        if not all(0 <= x <= 1 for x in (r, g, b, a)):
            what = "its colour is not four numbers from 0 to 1"
            self.read.faults.approximate(e.where, what, "the nearest colour is drawn", "correct it")
            r, g, b = (min(1.0, max(0.0, x)) for x in (r, g, b))
        if 0 < a < 1:
            what, help = "what is transparent is not supported", "make the last number of its colour 1"
            self.read.faults.approximate(e.where, what, "it is drawn opaque", help)
        return (r, g, b), a


def named_materials(robot: Element) -> dict[str, Element]:
    """Return the definitions of materials by name, those of the robot before those of links."""
    links = (m for link in robot.all("link") for v in link.all("visual") for m in v.all("material"))
    made: dict[str, Element] = {}
    for material in (*robot.all("material"), *links):
        if material.children:
            made.setdefault(material.attributes.get("name", ""), material)
    return made


def check_material(read: Reader, material: Element) -> None:
    """Report the unknown attributes and children of a material."""
    read.known(material, ("name",), ("color", "texture"))
    for color in material.all("color"):
        read.known(color, ("rgba",))
    for texture in material.all("texture"):
        read.known(texture, ("filename",))


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
