"""MJCF elements with the defaults of their classes; poses and angles."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from wmspec.lang.importers.markup import Element, Reader
from wmspec.lang.importers.model import Faults
from wmspec.sim.scene.model import Array, Pose
from wmspec.sim.scene.model.transform import from_rotation_vector, multiply

#: Resolves a mesh reference to a path relative to the spec; '' if it is missing, which is reported.
MeshResolver = Callable[[Element, str], str]

#: Elements of actuators whose defaults MuJoCo keeps in one set.
_ACTUATORS = ("general", "motor", "position", "velocity")
_TURNS = ("quat", "euler", "axisangle")
_COMPILER = ("angle", "eulerseq", "autolimits", "meshdir", "texturedir", "assetdir", "inertiafromgeom", "coordinate")


class Defaults(Reader):
    """Reads the elements of one file."""

    def __init__(self, root: Element, find: MeshResolver, faults: Faults) -> None:
        super().__init__(faults)
        self.find = find
        self.root = root
        self._classes: dict[str, dict[str, dict[str, str]]] = {"": {}}
        self._compile(root)
        for top in root.all("default"):  # all top-level sections are parts of one class
            self._class(top, "", self._classes[""], depth=0)
        self._classes.setdefault("main", self._classes[""])

    def _compile(self, root: Element) -> None:
        settings: dict[str, str] = {}
        for compiler in root.all("compiler"):
            self.known(compiler, _COMPILER)
            settings |= compiler.attributes
            for name, only in (("inertiafromgeom", "auto"), ("coordinate", "local")):
                if settings.get(name, only) != only:
                    self.faults.add(
                        compiler.where, f'{name}="{settings[name][:20]}" is not supported', f'make it "{only}"'
                    )
        self.angle = 1.0 if settings.get("angle", "degree") == "radian" else math.pi / 180
        self.sequence = settings.get("eulerseq", "xyz")
        self.limited = settings.get("autolimits", "true") == "true"
        self.meshes = settings.get("meshdir", settings.get("assetdir", ""))
        if len(self.sequence) != 3 or set(self.sequence.lower()) - set("xyz"):
            self.faults.add(root.where, f'eulerseq="{self.sequence[:20]}" makes no sense', "make it three of xyzXYZ")
            self.sequence = "xyz"

    def _class(self, e: Element, name: str, above: dict[str, dict[str, str]], depth: int) -> None:
        """Add a class of defaults, which inherits those of the enclosing class."""
        own = {tag: dict(values) for tag, values in above.items()}
        for child in e.children:
            if child.tag in _ACTUATORS:
                own["position"] = own.get("position", {}) | self._drive_defaults(child)
            elif child.tag != "default":
                own[child.tag] = own.get(child.tag, {}) | child.attributes
        self._classes[name] = own
        if depth == 0 and e.attributes.get("class"):
            self._classes[e.attributes["class"]] = own
        for child in e.all("default"):
            self._class(child, child.attributes.get("class", ""), own, depth + 1)

    def _drive_defaults(self, e: Element) -> dict[str, str]:
        """Return the defaults for `position` actuators that an actuator of a default class sets.

        MuJoCo stores gain and bias. A `position` has gain kp and bias (0, -kp, -kv); `motor` and `velocity` reset both.
        """
        values = dict(e.attributes)
        if e.tag in ("motor", "velocity"):
            values |= {"kp": "1", "kv": "0"}
        elif e.tag == "general":
            values.pop("biastype", None)
            gain, bias = (values.pop(name, "").split() for name in ("gainprm", "biasprm"))
            if gain:
                values["kp"] = repr(self.numbers(e, "gainprm", len(gain))[0])
            if len(bias) > 2:
                values["kv"] = repr(-self.numbers(e, "biasprm", len(bias))[2])
        return values

    def full(self, e: Element, inherited: str) -> Element:
        """Return the element completed by the defaults of its class or of the active one."""
        name = e.attributes.get("class", inherited)
        if name not in self._classes:
            self.faults.add(e.where, f"there is no class `{name[:60]}`", "correct it, or add a `default` for it")
        own = {k: v for k, v in e.attributes.items() if k != "class"}
        above = self._classes.get(name, {}).get(e.tag, {})
        if {"fromto", *_TURNS} & own.keys():  # the element's own orientation replaces the default's
            above = {k: v for k, v in above.items() if k not in ("fromto", *_TURNS)}
        return Element(e.tag, {k: v for k, v in above.items() if k != "class"} | own, e.line, e.file, e.children)

    def named(self, tag: str, name: str) -> Element | None:
        """Return the mesh or material of a name."""
        candidates = (e for assets in self.root.all("asset") for e in assets.all(tag))
        for e in candidates:
            stem = e.attributes.get("file", "").rpartition("/")[2].rpartition(".")[0]
            if e.attributes.get("name", stem) == name:
                return self.full(e, "")
        return None

    def place(self, e: Element) -> Pose:
        """Return the pose of an element relative to its parent."""
        position = np.array(self.numbers(e, "pos", 3, (0.0, 0.0, 0.0)))
        turns = [name for name in _TURNS if name in e.attributes]
        if len(turns) > 1:
            self.faults.add(e.where, f"`{turns[0]}` and `{turns[1]}` are both said", "keep one")
        return Pose(position, getattr(self, f"_{turns[0]}")(e) if turns else from_rotation_vector(np.zeros(3)))

    def _quat(self, e: Element) -> Array:
        w, x, y, z = self.numbers(e, "quat", 4)
        return self._about(e, np.array((x, y, z)), 2 * math.atan2(math.hypot(x, y, z), w))

    def _axisangle(self, e: Element) -> Array:
        *axis, angle = self.numbers(e, "axisangle", 4)
        return self._about(e, np.array(axis), angle * self.angle)

    def _euler(self, e: Element) -> Array:
        """Return the quaternion of successive rotations about moving (xyz) or fixed (XYZ) axes."""
        made = from_rotation_vector(np.zeros(3))
        for letter, angle in zip(self.sequence, self.numbers(e, "euler", 3), strict=True):
            turn = self._about(e, np.eye(3)["xyz".index(letter.lower())], angle * self.angle)
            made = multiply(made, turn) if letter.islower() else multiply(turn, made)
        return made

    def _about(self, e: Element, axis: Array, angle: float) -> Array:
        """Return the quaternion of a rotation about an axis."""
        size = float(np.linalg.norm(axis))
        if size == 0:
            if angle != 0:
                self.faults.add(e.where, "it is turned about an axis that is 0", "correct it")
            return from_rotation_vector(np.zeros(3))
        return from_rotation_vector(angle / size * axis)
