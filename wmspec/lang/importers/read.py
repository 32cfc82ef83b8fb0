"""Reads asset files of any supported format, with their meshes."""

from __future__ import annotations

import posixpath
from contextlib import suppress
from dataclasses import replace
from pathlib import Path, PurePosixPath

from wmspec.core.diagnostics import Diagnostic, WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import is_within
from wmspec.lang.check.tables.vocabulary import FILES, PROPERTIES
from wmspec.lang.importers.blocks import to_identifier
from wmspec.lang.importers.markup import Element, read_xml
from wmspec.lang.importers.massless import with_massless_frames
from wmspec.lang.importers.model import ASSET, Asset, Faults, RejectedAsset, UnreadableAsset
from wmspec.lang.importers.plausible import checked
from wmspec.lang.importers.tree import LinkTree, PlacedLink, link_tree
from wmspec.lang.importers.urdf import urdf


def read(folder: Path, name: str) -> LinkTree | RejectedAsset:
    """Return the links and joints of the asset `name` below the spec's folder, or its errors."""
    faults = Faults()
    asset = Asset({}, {})
    with suppress(UnreadableAsset):
        asset = checked(_asset(folder, name, faults), folder, faults)
        if not faults.diagnostics:
            asset = with_massless_frames(asset, faults)
            made = with_unique_names(link_tree(asset, FilePlace(name), faults), faults)
    said = (*faults.diagnostics, *faults.warnings)
    return RejectedAsset(said, tuple(asset.links.values())) if faults.diagnostics else replace(made, warnings=said)


class _Lenient(Faults):
    """Faults that stop at unreadable files only."""

    def add(self, where: FilePlace, message: str, help: str) -> None:
        """Add an error, without a maximum number."""
        self.diagnostics.append(Diagnostic(message, where, help, ASSET))


def structure(folder: Path, name: str) -> tuple[Asset, tuple[Diagnostic, ...]]:
    """Return links, joints and appearance of an asset, and the features that a spec does not support.

    Raises WmsError if the file cannot be read.
    """
    faults = _Lenient()
    try:
        return _asset(folder, name, faults), (*faults.diagnostics, *faults.warnings)
    except UnreadableAsset:
        raise WmsError.of(faults.diagnostics) from None


def _asset(folder: Path, name: str, faults: Faults) -> Asset:
    """Return the asset by file format. Raises Broken if it is invalid."""
    if PurePosixPath(name).suffix.lower() in (".urdf", ".xml"):
        root, find = read_xml(folder / name, name, faults), _Files(folder, name, faults).find
        if root.tag != "mujoco":
            return urdf(root, find, faults)
        from wmspec.lang.importers.mjcf import mjcf

        return mjcf(root, folder, name, find, faults)
    from wmspec.lang.importers.usd import usd

    return usd(folder / name, folder, name, faults)


class _Files:
    """Resolves files relative to the asset's folder, or `package://NAME/...` in a folder above."""

    def __init__(self, folder: Path, name: str, faults: Faults) -> None:
        self._folder = folder
        self._home = PurePosixPath(name).parent
        self._faults = faults

    def find(self, e: Element, named: str, mesh: bool = True) -> str:
        """Return the path of a mesh or another file relative to the spec's folder, or '' after reporting an error."""
        what = "mesh" if mesh else "file"
        if mesh and PurePosixPath(named).suffix.lower() not in FILES["file"]:
            can = ", ".join(FILES["file"])
            self._faults.add(e.where, f"`{named[:80]}` is no mesh that can be read", f"convert it to one of: {can}")
            return ""
        for path in self._places(e, named):
            if not path.startswith(("..", "/")) and is_within(self._folder, self._folder / path):
                return path
        message = f"there is no {what} `{named[:80]}` below the spec's folder"
        self._faults.add(e.where, message, "put it beside the asset")
        return ""

    def _places(self, e: Element, named: str) -> list[str]:
        """Return the candidates: relative to the asset, then to the file that names it."""
        if "\\" in named or (":" in named and not named.startswith("package://")):
            return []
        if not named.startswith("package://"):
            homes = dict.fromkeys((self._home, PurePosixPath(e.file).parent))
            return [posixpath.normpath(posixpath.join(home.as_posix(), named)) for home in homes]
        whole = posixpath.normpath(named.removeprefix("package://"))
        inner = whole.partition("/")[2]
        homes = dict.fromkeys((self._home, *self._home.parents))
        return [posixpath.normpath((home / path).as_posix()) for home in homes for path in (whole, inner) if path]


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
