"""MJCF geoms as shapes, and masses of bodies by MuJoCo's rules."""

from __future__ import annotations

import posixpath

import numpy as np

from wmspec.lang.importers.markup import Element
from wmspec.lang.importers.mjcf_defaults import Defaults
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
from wmspec.sim.scene.model import Inertia, Pose
from wmspec.sim.scene.model.transform import multiply, quaternion
from wmspec.sim.scene.physics.inertia import inertia, principal
from wmspec.sim.shapes import Box, Capsule, Cylinder, Sphere
from wmspec.sim.shapes import Shape as Solid

_GEOM = (
    "name", "type", "size", "pos", "quat", "euler", "axisangle", "fromto", "mass", "density", "friction", "rgba",
    "material", "mesh", "contype", "conaffinity", "group", "condim",
)  # fmt: skip
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3}
#: Highest geom group that MuJoCo's viewer draws by default.
_DRAWN = 2


class Geoms:
    """Converts geoms and `inertial`s of bodies to links."""

    def __init__(self, read: Defaults) -> None:
        self.read = read
        self.faults = read.faults

    def link(self, body: Element, inherited: str, name: str) -> Link:
        """Return a body with its geoms, mass and friction."""
        geoms = [self.read.full(e, inherited) for e in body.all("geom")]
        made = [(e, shape) for e in geoms if (shape := self._shape(e)) is not None]
        frictions = {self._friction(e) for e, shape in made if shape.solid}
        if len(frictions) > 1:
            self.faults.add(body.where, "its geoms have several frictions", "give them one")
        inertial = self.read.only(body, "inertial")
        mass = self._inertial(inertial) if inertial is not None else self._summed(made)
        friction = {"friction": next(iter(frictions))} if frictions else {}
        return Link(name, body.where, tuple(shape for _, shape in made), mass, friction)

    # ------------------------------------------------------------ shapes

    def _shape(self, e: Element) -> Shape | None:
        self.read.known(e, _GEOM)
        kind = e.attributes.get("type", "sphere")
        if kind != "mesh" and "mesh" in e.attributes:
            what = f"MuJoCo fits a {kind[:30]} to the mesh, which is not supported"
            self.faults.add(e.where, what, 'write type="mesh", or remove `mesh` and write the size')
            return None
        here = self.read.place(e)
        solid, drawn = self._touched(e), self.read.number(e, "group", 0.0) <= _DRAWN
        look = self._look(e) if drawn else Appearance()
        if kind == "mesh":
            file = self._mesh(e)
            return Shape(file, here, look, solid, drawn) if file else None
        if kind not in _SIZES:
            known = ", ".join((*_SIZES, "mesh"))
            help = f"make it one of {known}" + ("; the ground is the spec's" if kind == "plane" else "")
            self.faults.add(e.where, f"geoms of type `{kind[:30]}` are not supported", help)
            return None
        here, sizes = self._sized(e, kind, here)
        return Shape(_form(kind, sizes), here, look, solid, drawn)

    def _sized(self, e: Element, kind: str, here: Pose) -> tuple[Pose, tuple[float, ...]]:
        """Return pose and half sizes, possibly from the end points of its axis."""
        given = len(e.attributes.get("size", "").split())
        if "fromto" in e.attributes:
            if kind not in ("capsule", "cylinder"):
                self.faults.add(e.where, f"`fromto` of a {kind} is not supported", "say its `pos`, turn and `size`")
                return here, (1.0,) * _SIZES[kind]
            here, half = self._between(e)
            radius = self.read.numbers(e, "size", max(1, given), above=0.0)[0]
            return here, (radius, half)
        # MuJoCo ignores surplus numbers
        sizes = self.read.numbers(e, "size", max(_SIZES[kind], given))[: _SIZES[kind]]
        if any(x <= 0 for x in sizes):
            self.faults.add(e.where, "its size must be more than 0", "correct it")
        return here, sizes

    def _between(self, e: Element) -> tuple[Pose, float]:
        """Return the frame midway between two points, z axis from the second to the first, and half their distance."""
        ends = np.array(self.read.numbers(e, "fromto", 6)).reshape(2, 3)
        way = ends[0] - ends[1]
        size = float(np.linalg.norm(way))
        middle = ends.mean(axis=0)
        if size < 1e-9:
            self.faults.add(e.where, "the two ends of its `fromto` are the same", "correct them")
            return Pose(middle, quaternion(np.eye(3))), 1.0
        z = way / size
        x = np.cross((0.0, 1.0, 0.0) if abs(z[1]) < 0.9 else (1.0, 0.0, 0.0), z)
        x /= np.linalg.norm(x)
        return Pose(middle, quaternion(np.stack([x, np.cross(z, x), z], axis=1))), size / 2

    def _mesh(self, e: Element) -> MeshFile | None:
        mesh = self.read.named("mesh", self.read.text(e, "mesh"))
        if mesh is None:
            self.faults.add(e.where, f"there is no mesh `{e.attributes.get('mesh', '')[:60]}`", "add it to `asset`")
            return None
        self.read.known(mesh, ("name", "file", "scale", "inertia"))
        scale = self.read.scale(mesh)
        named = self.read.text(mesh, "file")
        file = self.read.find(mesh, posixpath.join(self.read.meshes, named)) if named else ""
        return MeshFile(file, scale) if file else None

    def _touched(self, e: Element) -> bool:
        """Whether it collides with geoms that have MuJoCo's defaults."""
        bits = [int(self.read.number(e, name, 1.0)) for name in ("contype", "conaffinity")]
        if 0 < (bits[0] & 1) + (bits[1] & 1) < 2 or (any(bits) and not bits[0] & 1):
            what = "what collides with some things and not with others is not supported"
            self.faults.add(e.where, what, "make contype and conaffinity both 0, or both 1")
        if self.read.number(e, "condim", 3.0) != 3:
            self.faults.add(e.where, "other contacts than those of condim 3 are not supported", "remove `condim`")
        return any(bits)

    def _friction(self, e: Element) -> float:
        """Return the sliding friction; explicit torsional and rolling friction is rejected."""
        given = e.attributes.get("friction", "1").split()
        return self.read.numbers(e, "friction", max(1, len(given)), (1.0,))[0]

    def _look(self, e: Element) -> Appearance:
        """Return the colour of a geom, with errors."""
        with self.faults.separately() as faults:
            color = self._color(e)
        return Appearance(color, conditional=conditional(faults, OVERRIDING_PROPERTIES))

    def _color(self, e: Element) -> Color | None:
        """Return the colour of a geom or of its material, or None."""
        source = e if "rgba" in e.attributes else self._material(e)
        if source is None:
            return None
        r, g, b, a = self.read.numbers(source, "rgba", 4, (1.0, 1.0, 1.0, 1.0))
        if a != 1:
            self.faults.add(source.where, "what is transparent is not supported", "make the last number of rgba 1")
        if not all(0 <= x <= 1 for x in (r, g, b)):
            self.faults.add(source.where, "its rgba is not four numbers from 0 to 1", "correct it")
        return r, g, b

    def _material(self, e: Element) -> Element | None:
        """Return the material of a geom, or None."""
        name = e.attributes.get("material")
        material = self.read.named("material", name) if name is not None else None
        if name is not None and material is None:
            self.faults.add(e.where, f"there is no material `{name[:60]}`", "add it to `asset`")
        if material is not None and "texture" in material.attributes:
            what = "textures of an asset are not supported"
            self.faults.add(material.where, what, "remove it")
        return material

    # ------------------------------------------------------------ masses

    def _inertial(self, e: Element) -> Inertia:
        self.read.known(e, ("pos", "quat", "euler", "axisangle", "mass", "diaginertia", "fullinertia"))
        here = self.read.place(e)
        mass = self.read.number(e, "mass", above=0.0)
        if "fullinertia" in e.attributes:
            xx, yy, zz, xy, xz, yz = self.read.numbers(e, "fullinertia", 6)
            tensor = np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
        else:
            tensor = np.diag(self.read.numbers(e, "diaginertia", 3, above=0.0))
        axes, moments = principal(tensor)
        return Inertia(mass, here.position, multiply(here.orientation, axes), moments)

    def _summed(self, made: list[tuple[Element, Shape]]) -> Inertia | None:
        """Return the mass of all geoms of a body, visual and collision, from their masses or densities."""
        if not made:
            return None
        parts: list[tuple[Solid, Pose, float]] = []
        for e, shape in made:
            mass = self.read.number(e, "mass", -1.0)
            if isinstance(shape.form, MeshFile):
                if mass == 0:
                    continue
                what, help = "the mass of a mesh is not computed", 'give its body an `inertial`, or the mesh mass="0"'
                self.faults.add(e.where, what, help)
                return None
            if mass < 0:
                mass = self.read.number(e, "density", 1000.0) * shape.form.volume
            if mass > 0:
                parts.append((shape.form, shape.pose, mass))
        return inertia(parts) if parts else None


def _form(kind: str, sizes: tuple[float, ...]) -> Form:
    """Return a shape by its half sizes."""
    match kind:
        case "box":
            return Box((sizes[0], sizes[1], sizes[2]))
        case "sphere":
            return Sphere(sizes[0])
    return (Capsule if kind == "capsule" else Cylinder)(sizes[0], 2 * sizes[1])
