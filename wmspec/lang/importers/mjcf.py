"""Imports MJCF (https://mujoco.readthedocs.io/en/stable/XMLreference.html): bodies, geoms, joints, position actuators.

Ignored, since the spec sets them or they have no effect: options, visuals, sites, lights, cameras, sensors, keyframes,
control ranges. Everything else is rejected by name.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wmspec.lang.importers.markup import Element
from wmspec.lang.importers.mjcf_defaults import Defaults, MeshResolver
from wmspec.lang.importers.mjcf_geoms import Geoms
from wmspec.lang.importers.mjcf_joints import Joints
from wmspec.lang.importers.model import MAX_LINKS, MAX_SHAPES, Asset, Faults, Joint, Link
from wmspec.lang.importers.tree import WORLD
from wmspec.lang.importers.turns import X
from wmspec.sim.scene.model.transform import identity

_READ = ("compiler", "default", "asset", "worldbody", "actuator")
_LEFT_OUT = ("option", "size", "visual", "statistic", "sensor", "keyframe", "custom")
_BODY = ("name", "childclass", "pos", "quat", "euler", "axisangle")


def mjcf(root: Element, find: MeshResolver, faults: Faults) -> Asset:
    """Return the asset of an MJCF root element. Raises Broken if it is invalid."""
    return _Mjcf(root, find, faults).asset()


class _Mjcf:
    def __init__(self, root: Element, find: MeshResolver, faults: Faults) -> None:
        self.root = root
        self.faults = faults
        self.read = Defaults(root, find, faults)
        self.geoms = Geoms(self.read)
        self.joints = Joints(self.read)
        self.links: dict[str, Link] = {}
        self.by_name: dict[str, Joint] = {}
        self.shapes = 0

    def asset(self) -> Asset:
        """Return the bodies as links; geoms of the world become a base that stands on it."""
        self.read.known(self.root, ("model",), (*_READ, *_LEFT_OUT))
        worlds = self.root.all("worldbody")
        if not worlds:
            raise self.faults.stop(self.root.where, "has no `worldbody`", "is this the right file?")
        if len(worlds) > 1:
            self.faults.add(worlds[1].where, "occurs twice", "merge them")
        base = self._base(worlds[0])
        for body, parent, inherited in self._bodies(worlds[0], base):
            self._body(body, parent, inherited)
        self.joints.drive(self.root, self.by_name)
        return Asset(self.links, self.by_name)

    def _base(self, world: Element) -> str:
        """Return the link that holds the bodies of the world."""
        self.read.known(world, (), ("geom", "body", "light", "camera", "site"))
        self.links[WORLD] = Link(WORLD, world.where)
        link = self.geoms.link(world, "", "base")
        if not link.shapes:
            return WORLD
        self.links["base"] = replace(link, mass=None)
        held = Joint("", world.where, "fixed", WORLD, "base", identity(), np.zeros(3), X)
        self.by_name[""] = held
        return "base"

    def _bodies(self, world: Element, base: str) -> Iterator[tuple[Element, str, str]]:
        """Yield all bodies, parents first, with the parent's name and the active defaults class."""
        waiting = [(body, base, "") for body in reversed(world.all("body"))]
        count = 0
        while waiting:
            body, parent, inherited = waiting.pop()
            count += 1
            if not body.attributes.get("name"):
                body.attributes["name"] = f"body_{count}"
            inherited = body.attributes.get("childclass", inherited)
            yield body, parent, inherited
            waiting += [(child, body.attributes["name"], inherited) for child in reversed(body.all("body"))]

    def _body(self, body: Element, parent: str, inherited: str) -> None:
        """Add one body and its joint."""
        left_out = ("light", "camera", "site")
        self.read.known(body, _BODY, ("geom", "joint", "freejoint", "inertial", "body", *left_out))
        name = body.attributes["name"]
        if name in self.links:
            self.faults.add(body.where, "there is another body of this name", "rename one of them")
            return
        link = self.geoms.link(body, inherited, name)
        self.shapes += len(link.shapes)
        if len(self.links) > MAX_LINKS or self.shapes > MAX_SHAPES:
            what = f"has more than {MAX_LINKS} bodies or {MAX_SHAPES} geoms"
            raise self.faults.stop(self.root.where, what, "make it simpler")
        if link.shapes and link.mass is None:
            what = "it has no mass"
            self.faults.add(body.where, what, "give it an `inertial`, or one of its geoms a mass")
        self.links[name] = link
        joint = self.joints.of(body, parent, inherited)
        if joint.name in self.by_name:
            self.faults.add(joint.where, "there is another joint of this name", "rename one of them")
        self.by_name[joint.name] = joint
