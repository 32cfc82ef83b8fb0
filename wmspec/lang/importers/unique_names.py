"""Names of links and joints in a spec: identifiers, each once, that are no properties of objects."""

from __future__ import annotations

from dataclasses import replace

from wmspec.core.places import FilePlace
from wmspec.lang.check.tables.vocabulary import PROPERTIES
from wmspec.lang.importers.blocks import to_identifier
from wmspec.lang.importers.model import Faults
from wmspec.lang.importers.tree import LinkTree, PlacedLink


def with_unique_names(tree: LinkTree, faults: Faults) -> LinkTree:
    """Return the tree with other names for links and joints whose names conflict; changes are reported."""
    taken = set(PROPERTIES["object"])
    links = {placed.link.name: _free(placed.link.name, "link", taken) for placed in tree.links}
    joints = {joint.name: _free(joint.name, "joint", taken) for joint in tree.joints}
    if all(old == new for names in (links, joints) for old, new in names.items()):
        return tree
    for placed in tree.links:
        _report(placed.link.name, links[placed.link.name], placed.link.where, faults)
    for joint in tree.joints:
        _report(joint.name, joints[joint.name], joint.where, faults)
    return replace(
        tree,
        links=tuple(
            PlacedLink(
                replace(p.link, name=links[p.link.name], passes=tuple(links.get(n, n) for n in p.link.passes)), p.pose
            )
            for p in tree.links
        ),
        joints=tuple(
            replace(j, name=joints[j.name], parent=links.get(j.parent, j.parent), child=links.get(j.child, j.child))
            for j in tree.joints
        ),
    )


def _free(name: str, kind: str, taken: set[str]) -> str:
    """Return the name, or one whose identifier is not taken, which is taken then."""
    made, count = name, 1
    while to_identifier(made) in taken:
        made = f"{name}_{kind}" if count == 1 else f"{name}_{kind}_{count}"
        count += 1
    taken.add(to_identifier(made))
    return made


def _report(old: str, new: str, where: FilePlace, faults: Faults) -> None:
    if old != new:
        what = "its name is that of another link or joint, or of a property"
        faults.approximate(where, what, "a spec adds `_link` or `_joint` to it", "rename it in the file")
