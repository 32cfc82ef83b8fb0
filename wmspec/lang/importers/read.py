"""Reads asset files of any supported format, with their meshes."""

from __future__ import annotations

import posixpath
from contextlib import suppress
from pathlib import Path, PurePosixPath

from wmspec.core.diagnostics import Diagnostic, WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import is_within
from wmspec.lang.check.tables.vocabulary import FILES
from wmspec.lang.importers.markup import Element, read_xml
from wmspec.lang.importers.mjcf import mjcf
from wmspec.lang.importers.model import ASSET, Asset, Faults, RejectedAsset, UnreadableAsset
from wmspec.lang.importers.tree import LinkTree, link_tree
from wmspec.lang.importers.urdf import urdf


def read(folder: Path, name: str) -> LinkTree | RejectedAsset:
    """Return the links and joints of the asset `name` below the spec's folder, or its errors."""
    faults = Faults()
    asset = Asset({}, {})
    with suppress(UnreadableAsset):
        asset = _asset(folder, name, faults)
        if not faults.diagnostics:
            made = link_tree(asset, FilePlace(name), faults)
    return RejectedAsset(tuple(faults.diagnostics), tuple(asset.links.values())) if faults.diagnostics else made


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
        return _asset(folder, name, faults), tuple(faults.diagnostics)
    except UnreadableAsset:
        raise WmsError.of(faults.diagnostics) from None


def _asset(folder: Path, name: str, faults: Faults) -> Asset:
    """Return the asset by file format. Raises Broken if it is invalid."""
    if PurePosixPath(name).suffix.lower() in (".urdf", ".xml"):
        root, find = read_xml(folder / name, name, faults), _Meshes(folder, name, faults).find
        return mjcf(root, find, faults) if root.tag == "mujoco" else urdf(root, find, faults)
    from wmspec.lang.importers.usd import usd

    return usd(folder / name, folder, name, faults)


class _Meshes:
    """Resolves meshes relative to the asset's folder, or `package://NAME/...` in a folder above."""

    def __init__(self, folder: Path, name: str, faults: Faults) -> None:
        self._folder = folder
        self._home = PurePosixPath(name).parent
        self._faults = faults

    def find(self, e: Element, named: str) -> str:
        """Return the mesh path relative to the spec's folder, or '' after reporting an error."""
        if PurePosixPath(named).suffix.lower() not in FILES["file"]:
            can = ", ".join(FILES["file"])
            self._faults.add(e.where, f"`{named[:80]}` is no mesh that can be read", f"convert it to one of: {can}")
            return ""
        for path in self._places(named):
            if not path.startswith(("..", "/")) and is_within(self._folder, self._folder / path):
                return path
        if named:
            what = f"there is no mesh `{named[:80]}` below the spec's folder"
            self._faults.add(e.where, what, "put it beside the asset")
        return ""

    def _places(self, named: str) -> list[str]:
        if "\\" in named or (":" in named and not named.startswith("package://")):
            return []
        if not named.startswith("package://"):
            return [posixpath.normpath(posixpath.join(self._home.as_posix(), named))]
        whole = posixpath.normpath(named.removeprefix("package://"))
        inner = whole.partition("/")[2]
        homes = (self._home, *self._home.parents)
        return [posixpath.normpath((home / path).as_posix()) for home in homes for path in (whole, inner) if path]
