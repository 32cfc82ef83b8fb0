"""Kinematic tree of an asset: every link once, in the asset's frame, without empty frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import FilePlace
from wmspec.lang.importers.model import Asset, Faults, Joint, Link
from wmspec.sim.scene.model import Inertia, Pose
from wmspec.sim.scene.model.transform import apply, compose, identity, multiply, rotate

#: Name of a root link that is the world itself.
WORLD = "world"


@dataclass(frozen=True)
class PlacedLink:
    """A link with its pose in the asset's frame, all joints at 0."""

    link: Link
    pose: Pose


@dataclass(frozen=True)
class LinkTree:
    """Links with shapes, base first, and joints between them or to the world (`parent` is '').

    The base's frame is the asset's. `held` is whether the base is fixed to the world. `warnings` are approximations.
    """

    links: tuple[PlacedLink, ...]
    joints: tuple[Joint, ...]
    held: bool
    warnings: tuple[Diagnostic, ...] = ()


def link_tree(asset: Asset, where: FilePlace, faults: Faults) -> LinkTree:
    """Return the kinematic tree. Raises Broken if the links form none; other errors are added to the faults."""
    root = _root(asset, where, faults)
    below: dict[str, list[Joint]] = {}
    for joint in asset.joints.values():
        below.setdefault(joint.parent, []).append(joint)
    walk = _Walk(asset, below, faults)
    walk.from_root(root)
    return LinkTree(tuple(walk.links), tuple(walk.joints), walk.held)


def _root(asset: Asset, where: FilePlace, faults: Faults) -> str:
    """Return the one link without a parent."""
    if not asset.links:
        raise faults.stop(where, "has no links", "is this the right file?")
    held = _child_links(asset, faults)
    roots = [name for name in asset.links if name not in held]
    if not roots:
        raise faults.stop(where, "every link is held by another, in a circle", "let one of them be the base")
    if len(roots) > 1:
        what = f"`{roots[0]}` and `{roots[1]}` are not joined to one another"
        raise faults.stop(where, what, "join them, or make an asset of each")
    _check_reachable(asset, roots[0], faults)
    return roots[0]


def _child_links(asset: Asset, faults: Faults) -> set[str]:
    """Return the child links, each of which has one joint."""
    holders: dict[str, str] = {}
    for joint in asset.joints.values():
        for end in (joint.parent, joint.child):
            if end not in asset.links:
                raise faults.stop(joint.where, f"there is no link `{end[:60]}`", "correct the name, or add the link")
        if joint.child in holders:
            what = f"`{joint.child}` is held by `{holders[joint.child]}` already: joints that close a loop"
            raise faults.stop(joint.where, f"{what} are not supported", "remove one of the two joints")
        holders[joint.child] = joint.name
    return set(holders)


def _check_reachable(asset: Asset, root: str, faults: Faults) -> None:
    """Report cycles of links that the root does not reach."""
    reached, grown = set[str](), {root}
    while grown != reached:
        reached, grown = grown, grown | {j.child for j in asset.joints.values() if j.parent in grown}
    for name, link in asset.links.items():
        if name not in reached:
            raise faults.stop(link.where, "it is held in a circle of links", "let the base hold one of them")


class _Walk:
    """Traverses the tree from the root and collects links with shapes or mass."""

    def __init__(self, asset: Asset, below: dict[str, list[Joint]], faults: Faults) -> None:
        self._asset = asset
        self._below = below
        self._faults = faults
        self.links: list[PlacedLink] = []
        self.joints: list[Joint] = []
        self.held = False

    def from_root(self, name: str) -> None:
        """Start with the base: the root, or its first descendant with a shape."""
        here, link = identity(), self._asset.links[name]
        others: list[Joint] = []
        while not link.shapes:
            joints = [joint for joint in self._below.get(name, ()) if not self._is_empty(joint.child)]
            if not joints or link.mass is not None or (len(joints) > 1 and name != WORLD):
                raise self._faults.stop(link.where, "the base of the asset has no shape", "give it a `visual`")
            joint, *more = joints
            others += more
            if joint.kind in ("hinge", "slider", "ball"):
                self._from_world(name, joint, here, others)
                return
            self.held = self.held or (joint.kind == "fixed" and name == WORLD)
            here, name = compose(here, joint.place), joint.child
            link = self._asset.links[name]
        self._base(link, here, others)

    def _is_empty(self, name: str) -> bool:
        """Whether a link and all below it have neither shape nor mass."""
        link = self._asset.links[name]
        below = self._below.get(name, ())
        return not link.shapes and link.mass is None and all(self._is_empty(joint.child) for joint in below)

    def _from_world(self, name: str, joint: Joint, here: Pose, others: list[Joint]) -> None:
        """Add a base with a joint to the world."""
        if name != WORLD and not self.held:
            what = f"`{name}` has neither shape nor mass, so nothing can be joined to it"
            raise self._faults.stop(joint.where, what, "give it a `visual`; or call it `world`, if it is that")
        here = compose(here, joint.place)
        link = self._asset.links[joint.child]
        if not link.shapes:
            raise self._faults.stop(link.where, "it has no shape", "give it a `visual`")
        self._base(link, here, others)
        at, axis = apply(here, joint.at), rotate(here.orientation, joint.axis)
        self.joints.insert(0, replace(joint, parent="", child=link.name, at=at, axis=axis))

    def _base(self, link: Link, here: Pose, others: list[Joint]) -> None:
        """Add the base, all its descendants, and the `others` that the world holds."""
        self.links.append(PlacedLink(_in_frame(link, here), identity()))
        waiting = [(j, "", identity()) for j in reversed(others)]
        waiting += [(j, link.name, here) for j in reversed(self._below.get(link.name, ()))]
        while waiting:
            joint, holder, frame = waiting.pop()
            here = compose(frame, joint.place)
            child = self._asset.links[joint.child]
            name = child.name if child.shapes else holder
            if child.shapes:
                self._take(joint, holder, child, here)
            waiting += [(j, name, here) for j in reversed(self._below.get(joint.child, ()))]

    def _take(self, joint: Joint, holder: str, child: Link, here: Pose) -> None:
        self.links.append(PlacedLink(child, here))
        stands = child.fixed and joint.kind == "fixed" and not holder
        if joint.kind != "free" and not stands:
            at, axis = apply(here, joint.at), rotate(here.orientation, joint.axis)
            self.joints.append(replace(joint, parent=holder, at=at, axis=axis))


def _in_frame(link: Link, here: Pose) -> Link:
    """Return a link expressed in the frame in which its own frame has the pose `here`."""
    if not here.position.any() and here.orientation[0] == 1:
        return link
    shapes = tuple(replace(s, pose=compose(here, s.pose)) for s in link.shapes)
    mass = link.mass
    if mass is not None:
        mass = Inertia(mass.mass, apply(here, mass.center), multiply(here.orientation, mass.axes), mass.moments)
    return replace(link, shapes=shapes, mass=mass)


def named_elements(tree: LinkTree) -> Iterator[tuple[str, FilePlace]]:
    """Yield the links and joints by name, with their locations."""
    yield from ((placed.link.name, placed.link.where) for placed in tree.links)
    yield from ((joint.name, joint.where) for joint in tree.joints)
