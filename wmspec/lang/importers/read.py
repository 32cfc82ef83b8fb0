"""The asset in a file, by its format, with the meshes that it names."""

from __future__ import annotations

import posixpath
from contextlib import suppress
from pathlib import Path, PurePosixPath

from wmspec.core.diagnostics import Diagnostic, WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import inside
from wmspec.lang.check.tables.vocabulary import FILES
from wmspec.lang.importers.markup import Element
from wmspec.lang.importers.markup import read as read_xml
from wmspec.lang.importers.mjcf import mjcf
from wmspec.lang.importers.model import ASSET, Asset, Broken, Faults, Refused
from wmspec.lang.importers.tree import Tree, tree
from wmspec.lang.importers.urdf import urdf


def read(folder: Path, name: str) -> Tree | Refused:
    """The links and joints of the asset in the file `name` below the spec's folder, or all that is wrong with it."""
    faults = Faults()
    asset = Asset({}, {})
    with suppress(Broken):
        asset = _asset(folder, name, faults)
        if not faults.diagnostics:
            made = tree(asset, FilePlace(name), faults)
    return Refused(tuple(faults.diagnostics), tuple(asset.links.values())) if faults.diagnostics else made


class _Lenient(Faults):
    """Faults that stop nothing but what cannot be read at all."""

    def add(self, where: FilePlace, message: str, help: str) -> None:
        """Take note of a fault, however many there are."""
        self.diagnostics.append(Diagnostic(message, where, help, ASSET))


def structure(folder: Path, name: str) -> tuple[Asset, tuple[Diagnostic, ...]]:
    """The links, joints and looks in the file `name` below a folder, and what in it a spec could not have.

    Raises WmsError if it cannot be read.
    """
    faults = _Lenient()
    try:
        return _asset(folder, name, faults), tuple(faults.diagnostics)
    except Broken:
        raise WmsError.of(faults.diagnostics) from None


def _asset(folder: Path, name: str, faults: Faults) -> Asset:
    """What the file says, by its format. Raises Broken if that is nothing."""
    if PurePosixPath(name).suffix.lower() in (".urdf", ".xml"):
        root, find = read_xml(folder / name, name, faults), _Meshes(folder, name, faults).find
        return mjcf(root, find, faults) if root.tag == "mujoco" else urdf(root, find, faults)
    from wmspec.lang.importers.usd import usd

    return usd(folder / name, folder, name, faults)


class _Meshes:
    """Finds the meshes that an asset names: from its own folder, or `package://NAME/...` in a folder above them."""

    def __init__(self, folder: Path, name: str, faults: Faults) -> None:
        self._folder = folder
        self._home = PurePosixPath(name).parent
        self._faults = faults

    def find(self, e: Element, named: str) -> str:
        """The mesh, seen from the spec's folder; empty, after a complaint, if it cannot be used."""
        if PurePosixPath(named).suffix.lower() not in FILES["file"]:
            can = ", ".join(FILES["file"])
            self._faults.add(e.where, f"`{named[:80]}` is no mesh that can be read", f"convert it to one of: {can}")
            return ""
        for path in self._places(named):
            if not path.startswith(("..", "/")) and inside(self._folder, self._folder / path):
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
