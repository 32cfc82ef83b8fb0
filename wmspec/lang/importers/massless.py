"""Links without mass: frames, parts of the links that hold them, or light links of chains.

Engines need a mass for everything that moves. A link of mass 0 that a fixed joint holds is a part of its holder, and
one that nothing holds is fixed, as in PyBullet. Between two joints a light link stands in.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from wmspec.lang.importers.model import Asset, Faults, Joint, Link, Shape
from wmspec.lang.importers.tree import WORLD
from wmspec.sim.scene.model import Inertia, Pose
from wmspec.sim.scene.model.transform import compose, identity
from wmspec.sim.shapes import Sphere

#: Mass of a light link relative to the lightest link of the asset; kg of that if no link has a mass.
LIGHT, _LIGHTEST = 1e-5, 1.0
#: Least mass (kg) and moment (kg m²) that engines take.
_LEAST = 1e-12
#: Radius (m) of the placeholder ball of a link without geometry, invisible and without collisions.
_PLACEHOLDER_RADIUS = 1e-3
_DEFAULT_RESTITUTION = 0.1


def placeholder(mass: Inertia | None) -> Shape:
    """Return the shape of a link without geometry, at its centre of mass."""
    middle = identity() if mass is None else Pose(mass.center, identity().orientation)
    return Shape(Sphere(_PLACEHOLDER_RADIUS), middle, solid=False, drawn=False)


def with_massless_frames(asset: Asset, faults: Faults) -> Asset:
    """Return the asset in which each link that can move has a mass and a shape; substitutes are reported."""
    made = _Massless(asset, faults)
    made.convert()
    return Asset(made.links, made.joints)


class _Massless:
    def __init__(self, asset: Asset, faults: Faults) -> None:
        self.links, self.joints, self._faults = dict(asset.links), dict(asset.joints), faults
        self._below: dict[str, list[str]] = {}
        for joint in asset.joints.values():
            self._below.setdefault(joint.parent, []).append(joint.name)
        masses = [link.mass for link in asset.links.values() if link.mass is not None]
        kg = max(_LEAST, LIGHT * min((m.mass for m in masses), default=_LIGHTEST))
        moment = max(_LEAST, LIGHT * min((float(m.moments.min()) for m in masses), default=_LIGHTEST))
        self._light = Inertia(kg, np.zeros(3), identity().orientation, np.full(3, moment))

    def convert(self) -> None:
        """Convert all links, leaves first."""
        held = {joint.child: joint for joint in self.joints.values()}
        for name in reversed(self._order(held)):
            link = self.links[name]
            only_drawn = name in held and not any(s.solid for s in link.shapes)
            if link.mass is None and (link.massless or not link.shapes or only_drawn):
                self._massless(link, held.get(name))
        for name, link in self.links.items():
            if link.mass is not None and not link.shapes:
                self.links[name] = replace(link, shapes=(placeholder(link.mass),))

    def _order(self, held: Mapping[str, Joint]) -> list[str]:
        """Return the links, parents first; links in circles and of unknown parents are left out."""
        order = [name for name in self.links if name not in held]
        known = set(order)
        for name in order:
            for joint in self._below.get(name, ()):
                child = self.joints[joint].child
                if child in self.links and child not in known:
                    known.add(child)
                    order.append(child)
        return order

    def _massless(self, link: Link, joint: Joint | None) -> None:
        if joint is None:
            self._root(link)
        elif joint.kind == "fixed":
            if link.shapes:
                self._merge(link, joint)
        elif self._has_matter(self._subtree(link.name)[1:]) and not link.fixed:
            self._lighten(link, "it moves with")
        elif link.shapes:
            self._hold(link, joint)
        else:  # nothing depends on where it is
            self.joints.pop(joint.name, None)
            for name in self._subtree(link.name):
                self.links.pop(name, None)
                self.joints = {n: j for n, j in self.joints.items() if j.child != name}

    def _root(self, link: Link) -> None:
        """Convert a link that nothing holds."""
        if link.shapes:
            self._faults.approximate(link.where, "it has a mass of 0", "it is fixed", "give it an `inertial`")
            self.links[link.name] = replace(link, fixed=True)
            return
        if link.name == WORLD:
            for joint in self._joints_below(WORLD):
                if joint.kind == "fixed":
                    self._stand(self._last_frame(joint.child))
            return
        frame = self._last_frame(link.name)
        below = self._joints_below(frame.name)
        if frame.shapes or frame.mass is not None or not below:
            return
        if any(j.kind == "fixed" and self._has_matter(self._subtree(j.child)) for j in below):
            self._lighten(frame, "it is joined to its neighbours with")
        else:
            self._faults.approximate(
                link.where, "the root has neither shape nor mass", "it is fixed", "call it `world`"
            )
            self.links[frame.name] = replace(frame, shapes=(placeholder(None),), fixed=True)

    def _stand(self, frame: Link) -> None:
        """Give a frame that stands on the world and holds several links a body of its own."""
        if not frame.shapes and frame.mass is None and len(self._joints_below(frame.name)) > 1:
            self.links[frame.name] = replace(frame, shapes=(placeholder(None),), fixed=True)

    def _joints_below(self, name: str) -> list[Joint]:
        return [self.joints[j] for j in self._below.get(name, ()) if j in self.joints]

    def _last_frame(self, name: str) -> Link:
        """Return the link that a link leads to by frames of one fixed joint each."""
        link = self.links[name]
        while not link.shapes and link.mass is None:
            below = self._joints_below(link.name)
            if len(below) != 1 or below[0].kind != "fixed" or below[0].child not in self.links:
                break
            link = self.links[below[0].child]
        return link

    def _lighten(self, link: Link, how: str) -> None:
        what = f"{how} {self._light.mass:.1g} kg, {LIGHT:g} of the lightest link"
        self._faults.approximate(link.where, "a link between joints has no mass", what, "give it an `inertial`")
        shapes = link.shapes or (placeholder(None),)
        self.links[link.name] = replace(link, mass=self._light, massless=False, shapes=shapes)

    def _hold(self, link: Link, joint: Joint) -> None:
        """Fix a movable link of mass 0 that holds no matter."""
        what = "a link of mass 0 moves"
        self._faults.approximate(link.where, what, f"joint `{joint.name}` is fixed", "give it an `inertial`")
        kept = replace(joint, kind="fixed", low=None, high=None, damping=0.0, stiffness=0.0, target=None)
        self.joints[joint.name] = kept
        self._merge(link, kept)

    def _merge(self, link: Link, joint: Joint) -> None:
        """Make the shapes of a link parts of the link that holds it, which stays a frame."""
        holder = self.links.get(joint.parent)
        if holder is None:
            return
        if holder.name == WORLD:
            self.links[link.name] = replace(link, fixed=True)
            return
        moved = tuple(replace(s, pose=compose(joint.place, s.pose)) for s in _with_friction(link))
        massless = holder.massless or (holder.mass is None and not holder.shapes)
        self.links[holder.name] = replace(holder, shapes=(*holder.shapes, *moved), massless=massless)
        self.links[link.name] = replace(link, shapes=(), massless=False)

    # ------------------------------------------------------------ what is below

    def _subtree(self, name: str) -> list[str]:
        found, known = [name], {name}
        for one in found:
            for joint in self._below.get(one, ()):
                child = self.joints[joint].child if joint in self.joints else None
                if child is not None and child not in known:
                    known.add(child)
                    found.append(child)
        return found

    def _has_matter(self, names: list[str]) -> bool:
        """Whether one of the links has mass or shapes."""
        return any(self.links[n].mass is not None or bool(self.links[n].shapes) for n in names if n in self.links)


def _with_friction(link: Link) -> tuple[Shape, ...]:
    """Return the shapes of a link with its friction as their own."""
    if "friction" not in link.given:
        return link.shapes
    rubs = link.given["friction"], link.given.get("restitution", _DEFAULT_RESTITUTION)
    return tuple(replace(s, friction_restitution=s.friction_restitution or rubs) if s.solid else s for s in link.shapes)
