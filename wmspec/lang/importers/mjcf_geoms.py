"""Geoms of a compiled MJCF model as shapes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from wmspec.lang.importers.mjcf_model import Compiled
from wmspec.lang.importers.model import (
    OVERRIDING_PROPERTIES,
    Appearance,
    Color,
    Faults,
    Form,
    MeshFile,
    Shape,
    conditional,
)
from wmspec.sim.scene.model import Pose
from wmspec.sim.scene.model.transform import compose, inverse, multiply, quaternion, rotate, rotation
from wmspec.sim.shapes import Box, Capsule, Cylinder, Lathe, Sphere

#: Highest geom group that MuJoCo's viewer draws by default.
_DRAWN = 2
#: MuJoCo's colour of a geom without one.
_PLAIN = (0.5, 0.5, 0.5, 1.0)
#: Highest friction of a spec, and its restitution of an object without one.
_MAX_FRICTION, _RESTITUTION = 5.0, 0.1
#: Points of the outline of half an ellipse.
_OUTLINE = 13


class Geoms:
    """Converts the geoms of bodies."""

    def __init__(self, compiled: Compiled, faults: Faults) -> None:
        self._compiled, self._m, self._faults = compiled, compiled.model, faults
        self._kinds = compiled.mujoco.mjtGeom
        solid = (self._m.geom_contype | self._m.geom_conaffinity) != 0
        self._frictionless = bool(solid.any() and (self._m.geom_condim[solid] == 1).all())

    def of(self, body: int) -> tuple[tuple[Shape, ...], dict[str, float]]:
        """Return the shapes of a body, and their common friction; if it differs, each shape has its own."""
        first, count = int(self._m.body_geomadr[body]), int(self._m.body_geomnum[body])
        made = [(i, shape) for i in range(first, first + count) if (shape := self._shape(i)) is not None]
        frictions = {self._friction(i) for i, shape in made if shape.solid}
        if len(frictions) <= 1:
            return tuple(shape for _, shape in made), ({"friction": next(iter(frictions))} if frictions else {})
        own = ((shape, (self._friction(i), _RESTITUTION) if shape.solid else None) for i, shape in made)
        return tuple(replace(shape, friction_restitution=rubs) for shape, rubs in own), {}

    def _shape(self, i: int) -> Shape | None:
        m, kind = self._m, int(self._m.geom_type[i])
        where = self._compiled.geoms[i].where
        if kind in (self._kinds.mjGEOM_PLANE, self._kinds.mjGEOM_HFIELD):
            what = "planes" if kind == self._kinds.mjGEOM_PLANE else "height fields"
            self._faults.approximate(where, f"{what} are not supported", "left out", "the ground is the spec's")
            return None
        here = Pose(np.array(m.geom_pos[i], np.float64), np.array(m.geom_quat[i], np.float64))
        alpha = self._alpha(i)
        solid = self._compiled.has_contacts and bool(m.geom_contype[i] or m.geom_conaffinity[i])
        drawn = m.geom_group[i] <= _DRAWN and alpha > 0
        if not (solid or drawn):
            return None
        placed = self._form(i, here)
        if placed is None:
            return None
        self._contact(i, solid)
        look = self._look(i, alpha) if drawn else Appearance()
        return Shape(placed[0], placed[1], look, solid, drawn)

    def _form(self, i: int, here: Pose) -> tuple[Form, Pose] | None:
        sizes, kinds = [float(x) for x in self._m.geom_size[i]], self._kinds
        match int(self._m.geom_type[i]):
            case kinds.mjGEOM_SPHERE:
                return Sphere(sizes[0]), here
            case kinds.mjGEOM_CAPSULE:
                return Capsule(sizes[0], 2 * sizes[1]), here
            case kinds.mjGEOM_CYLINDER:
                return Cylinder(sizes[0], 2 * sizes[1]), here
            case kinds.mjGEOM_BOX:
                return Box((sizes[0], sizes[1], sizes[2])), here
            case kinds.mjGEOM_ELLIPSOID:
                return self._ellipsoid(i, sizes, here)
            case kinds.mjGEOM_MESH:
                return self._mesh(i, here)
        self._faults.add(self._compiled.geoms[i].where, "geoms of this type are not supported", "make it a mesh")
        return None

    def _ellipsoid(self, i: int, sizes: list[float], here: Pose) -> tuple[Form, Pose]:
        """Return an ellipsoid of revolution about the axis that leaves the other two semi-axes nearest."""
        axis = min(range(3), key=lambda k: abs(math.log(sizes[k - 1] / sizes[k - 2])))
        a, b = sizes[axis - 2], sizes[axis - 1]
        radius, half = math.sqrt(a * b), sizes[axis]
        off = max(a, b) / radius - 1
        size = f"a surface of {2 * _OUTLINE - 2} bands" + (
            f" with equal axes, {100 * off:.0f} % off" if off > 1e-6 else ""
        )
        where = self._compiled.geoms[i].where
        self._faults.approximate(where, "ellipsoids are not supported", size, "use a sphere or a capsule")
        turn = (np.eye(3)[:, [1, 2, 0]], np.eye(3)[:, [2, 0, 1]], np.eye(3))[axis]
        angles = [math.pi * (k / (_OUTLINE - 1) - 0.5) for k in range(_OUTLINE)]
        profile = tuple((max(0.0, radius * math.cos(t)), half * math.sin(t)) for t in angles)
        profile = ((0.0, -half), *profile[1:-1], (0.0, half))
        return Lathe(profile), Pose(here.position, multiply(here.orientation, quaternion(turn)))

    def _mesh(self, i: int, here: Pose) -> tuple[Form, Pose] | None:
        """Return a mesh with the pose of its file's frame: MuJoCo moves meshes to their centre and principal axes."""
        m, number = self._m, int(self._m.geom_dataid[i])
        mesh = self._compiled.meshes[m.mesh(number).name]
        own = Pose(np.array(m.mesh_pos[number], np.float64), np.array(m.mesh_quat[number], np.float64))
        pose = compose(here, inverse(own))
        scale = tuple(float(x) for x in mesh.scale)
        refpos, refquat = np.array(mesh.refpos, np.float64), np.array(mesh.refquat, np.float64)
        turned = not np.allclose(rotation(refquat), np.eye(3), atol=1e-12)
        if turned and len(set(scale)) > 1:
            where = self._compiled.geoms[i].where
            self._faults.add(where, "a mesh with `refquat` and unequal scales is not supported", "remove `refquat`")
            return None
        back = inverse(Pose(np.zeros(3), refquat)).orientation
        shift = np.array(scale) * rotate(back, -refpos)
        pose = compose(pose, Pose(shift, back if turned else np.array((1.0, 0.0, 0.0, 0.0))))
        return MeshFile(self._compiled.source.files[mesh.file], scale), pose

    # ------------------------------------------------------------ contact

    def _contact(self, i: int, solid: bool) -> None:
        """Report properties of contacts that are left out."""
        m, where = self._m, self._compiled.geoms[i].where
        if not solid:
            return
        if m.geom_condim[i] in (4, 6):
            what = "torsional and rolling friction are not supported"
            self._faults.approximate(where, what, "sliding friction only", "use condim 3")
        if tuple(m.geom_solref[i]) != (0.02, 1.0) or not np.allclose(m.geom_solimp[i], (0.9, 0.95, 0.001, 0.5, 2)):
            what = "the softness of contacts (`solref`, `solimp`) is not supported"
            self._faults.approximate(where, what, "contacts are as stiff as each engine has them", "")
        if m.geom_margin[i] or m.geom_gap[i]:
            what = f"contacts at a distance (margin {float(m.geom_margin[i]):g} m) are not supported"
            self._faults.approximate(where, what, "they begin at the surface", "")
        if m.geom_condim[i] == 1 and not self._frictionless:
            what = "frictionless contacts of some geoms (`condim` 1) are not supported"
            self._faults.approximate(where, what, "they have friction, as on a floor of `condim` 3", "")
        if m.geom_friction[i, 0] > _MAX_FRICTION and not self._frictionless:
            what = f"a friction of {float(m.geom_friction[i, 0]):g} is not supported"
            self._faults.approximate(where, what, f"it is {_MAX_FRICTION:g}", "")

    def _friction(self, i: int) -> float:
        """Return the sliding friction of a geom.

        MuJoCo takes the larger `condim` of two geoms: one of 1 is frictionless only where all are.
        """
        return 0.0 if self._frictionless else min(_MAX_FRICTION, float(self._m.geom_friction[i, 0]))

    # ------------------------------------------------------------ looks

    def _rgba(self, i: int) -> tuple[float, ...] | None:
        """Return the colour of a geom, or of its material, or None."""
        own = tuple(float(x) for x in self._m.geom_rgba[i])
        material = int(self._m.geom_matid[i])
        if material < 0 or not np.allclose(own, _PLAIN):
            return None if np.allclose(own, _PLAIN) else own
        return tuple(float(x) for x in self._m.mat_rgba[material])

    def _alpha(self, i: int) -> float:
        rgba = self._rgba(i)
        return 1.0 if rgba is None else rgba[3]

    def _look(self, i: int, alpha: float) -> Appearance:
        """Return the colour of a geom, with what is left out of its look."""
        where, material = self._compiled.geoms[i].where, int(self._m.geom_matid[i])
        with self._faults.separately() as faults:
            if alpha < 1:
                self._faults.approximate(
                    where, "what is transparent is not supported", "it is drawn opaque", "make it opaque"
                )
            if material >= 0 and self._m.mat(material).name in self._compiled.source.textured:
                textured = self._compiled.source.textured[self._m.mat(material).name]
                self._faults.approximate(
                    textured.where, "textures of an asset are not supported", "its plain colour is drawn", "remove it"
                )
        rgba = self._rgba(i)
        color: Color | None = None if rgba is None else (_unit(rgba[0]), _unit(rgba[1]), _unit(rgba[2]))
        return Appearance(color, conditional=conditional(faults, OVERRIDING_PROPERTIES))


def _unit(x: float) -> float:
    return min(1.0, max(0.0, x))
