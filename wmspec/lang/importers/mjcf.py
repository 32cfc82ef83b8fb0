"""Imports MJCF (https://mujoco.readthedocs.io/en/stable/XMLreference.html) as MuJoCo compiles it.

Bodies become links, geoms shapes, joints joints, and position and velocity actuators drives. A body with several joints
becomes a chain of links. The spec sets options, lights, cameras and sensors.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from wmspec.lang.importers.markup import Element
from wmspec.lang.importers.mjcf_contacts import Contacts
from wmspec.lang.importers.mjcf_geoms import Geoms
from wmspec.lang.importers.mjcf_joints import Joints
from wmspec.lang.importers.mjcf_model import Compiled, compiled
from wmspec.lang.importers.mjcf_source import FileResolver, Preparation
from wmspec.lang.importers.model import Asset, Faults, Joint, Link
from wmspec.lang.importers.tree import WORLD
from wmspec.lang.importers.turns import X
from wmspec.sim.scene.model import Array, Inertia, Pose
from wmspec.sim.scene.model.transform import identity

#: Names of the link of the world's geoms, the first free one.
_BASES = ("base", "stand", "ground", "surroundings")


def mjcf(root: Element, folder: Path, shown: str, find: FileResolver, faults: Faults) -> Asset:
    """Return the asset of an MJCF root element. Raises UnreadableAsset if it is invalid."""
    source = Preparation(folder, shown, find, faults).source(root)
    return _Mjcf(compiled(source, faults), faults).asset()


class _Mjcf:
    """Converts a compiled model."""

    def __init__(self, compiled: Compiled, faults: Faults) -> None:
        self._compiled, self._model, self._faults = compiled, compiled.model, faults
        self._geoms = Geoms(compiled, faults)
        self._joints = Joints(compiled, faults)
        self._contacts = Contacts(compiled, faults)
        names = [self._model.body(i).name or f"body_{i}" for i in range(self._model.nbody)]
        self._names = [WORLD, *names[1:]]

    def asset(self) -> Asset:
        """Return the bodies as links; geoms of the world become a base that stands on it."""
        world = self._compiled.bodies[0].where
        if self._model.nbody == 1 and not self._model.ngeom:
            raise self._faults.stop(self._compiled.source.root.where, "has no bodies", "is this the right file?")
        links, joints = {WORLD: Link(WORLD, world)}, dict[str, Joint]()
        shapes, properties = self._geoms.of(0)
        if shapes:
            base = next(name for name in (*_BASES, *(f"base_{i}" for i in range(1000))) if name not in self._names)
            self._names[0] = base
            links[base] = Link(base, world, shapes, None, properties)
            joints[""] = Joint("", world, "fixed", WORLD, base, identity(), np.zeros(3), X)
        for i in range(1, self._model.nbody):
            links[self._names[i]] = self._link(i)
            for joint, frame in self._held(i):
                joints[joint.name] = joint
                if frame is not None:
                    links[frame.name] = frame
        self._joints.drive(joints)
        for i, others in self._contacts.passing().items():
            passes = tuple(self._names[j] for j in others if self._names[j] in links)
            if self._names[i] in links:
                links[self._names[i]] = replace(links[self._names[i]], passes=passes)
        return Asset(links, joints)

    def _link(self, i: int) -> Link:
        where, m = self._compiled.bodies[i].where, self._model
        shapes, properties = self._geoms.of(i)
        mass = None
        if m.body_mass[i] > 0:
            mass = Inertia(
                float(m.body_mass[i]), _array(m.body_ipos[i]), _array(m.body_iquat[i]), _array(m.body_inertia[i])
            )
        if m.body_gravcomp[i]:
            what = "bodies that gravity does not act on are not supported"
            self._faults.approximate(where, what, "gravity acts on it", "hold it with a drive")
        fixed = bool(m.body_mocapid[i] >= 0)
        return Link(self._names[i], where, shapes, mass, properties, fixed, massless=mass is None and bool(shapes))

    def _held(self, i: int) -> Iterator[tuple[Joint, Link | None]]:
        """Yield the joints of a body, each but the last with the frame that it moves."""
        m, name, parent = self._model, self._names[i], self._names[int(self._model.body_parentid[i])]
        where = self._compiled.bodies[i].where
        here = Pose(_array(m.body_pos[i]), _array(m.body_quat[i]))
        count, first = int(m.body_jntnum[i]), int(m.body_jntadr[i])
        if count == 0:
            yield Joint(f"{name} fixed", where, "fixed", parent, name, here, np.zeros(3), X), None
            return
        touching = count == 1 and self._contacts.touches_parent(i)
        for number in range(count):
            last = number == count - 1
            child = name if last else f"{name} {self._joints.name(first + number, name)}"
            made = self._joints.joint(first + number, name, parent, child, here)
            yield replace(made, touching=touching), None if last else Link(child, where)
            parent, here = child, identity()


def _array(numbers: object) -> Array:
    return np.array(numbers, np.float64)
