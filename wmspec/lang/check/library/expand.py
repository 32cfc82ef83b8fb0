"""Expands assets: an object that names an asset file is replaced by its links and joints before checks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from wmspec.core.diagnostics import Diagnostic, Note, suggestion
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import Failed
from wmspec.lang.check.library.files import check_file, is_asset
from wmspec.lang.check.library.substitute import Substitute, TooLarge
from wmspec.lang.check.tables.vocabulary import ASSETS, PROPERTIES
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.files import resolve_display_path

if TYPE_CHECKING:  # most specs have no assets and do without the importers
    from wmspec.lang.importers.blocks import Blocks
    from wmspec.lang.importers.model import RejectedAsset
    from wmspec.lang.importers.tree import LinkTree

#: Code of warnings about approximations of asset files.
APPROXIMATION = "WMS211"
#: Properties that an asset has per link.
_OF_LINKS = ("shape", "size", "radius", "height", "scale", "mass", "centre", "moments", "axes", "solid")


class Assets:
    """Replaces assets by their links and joints, and declares these."""

    def __init__(self, check: Expressions, substitute: Substitute) -> None:
        self.check = check
        self.scope = check.scope
        self._substitute = substitute
        self._known: dict[tuple[Path, str], LinkTree | RejectedAsset] = {}
        self._warned: set[tuple[tuple[Path, str], Diagnostic]] = set()

    def expanded(self, block: s.Block) -> tuple[s.Block, ...]:
        """Return the links and joints of an asset, its base first; other blocks are unchanged. Raises Failed."""
        named = next((p.value for p in block.properties if p.name.id == "file"), None)
        if block.kind != "object" or not isinstance(named, s.Text) or not is_asset(named):
            return (block,)
        self.scope.broken.add(block.name.id)
        self._fits(block)
        check_file(self.check, "file", named, ASSETS)
        blocks = self._blocks(block, named)
        names = {plain: blocks.name(of) for plain, of in self._names(blocks.tree, named).items()}
        try:
            made = blocks.all()
            for _ in made:
                self._substitute.count_entity()
        except TooLarge:
            self.check.fail("WMS105", "the assets of this task are too large together", named.span, "use fewer")
        self.scope.broken.discard(block.name.id)
        self.scope.asset(block.name.id, names, made)
        return made

    def _fits(self, block: s.Block) -> None:
        """Report properties that belong to the links of an asset."""
        for p in block.properties:
            if p.name.id in _OF_LINKS:
                help = "set it on a link: `part NAME { mass: ... }`" if p.name.id == "mass" else "remove it"
                message = f"an object that is an asset from a file has no `{p.name.id}` of its own"
                self.check.report.add("WMS203", message, p.name.span, help)

    def _blocks(self, block: s.Block, named: s.Text) -> Blocks:
        from wmspec.lang.importers.blocks import Blocks, relevant_faults
        from wmspec.lang.importers.model import RejectedAsset
        from wmspec.lang.importers.read import read
        from wmspec.lang.importers.write import Writer

        key = (resolve_display_path(named.span.source.name).parent, named.value)
        tree = self._known[key] = self._known.get(key) or read(*key)
        whole = {p.name.id for p in block.properties}
        if isinstance(tree, RejectedAsset):
            faults = relevant_faults(tree, {p.name.id: p.properties for p in block.parts}, whole)
            # Where there is an error, it may be about the very feature that a warning says has a stand-in.
            wrong = {fault.place for fault in faults if fault.severity == "error"}
            self._report(tuple(f for f in faults if f.severity == "error" or f.place not in wrong), named)
            raise Failed
        overrides = self._overrides(block, tree, named)
        faults = relevant_faults(tree, overrides, whole)
        if self._is_strict(block):
            faults = tuple(replace(fault, severity="error") for fault in faults)
        self._report(faults, named)
        if any(fault.severity == "error" for fault in faults):
            raise Failed
        own = tuple(p for p in block.properties if p.name.id not in _OF_LINKS)
        bare = s.Block("object", block.name, own, block.span)
        return Blocks(bare, tree, overrides, Writer(named.span), self._keeps_inertia(block))

    def _keeps_inertia(self, block: s.Block) -> bool:
        """Whether the object keeps impossible inertias of its file. Raises Failed for another word than `file`."""
        value = next((p.value for p in block.properties if p.name.id == "inertia"), None)
        if value is not None and not (isinstance(value, s.Name) and value.id == "file"):
            self.check.fail("WMS302", "`inertia` must be `file`", value.span, "or leave it out")
        return value is not None

    def _is_strict(self, block: s.Block) -> bool:
        """Whether the object refuses approximations of its file. Raises Failed if that is no constant."""
        value = next((p.value for p in block.properties if p.name.id == "strict"), None)
        if value is None or isinstance(value, s.Truth):
            return value is not None and value.value
        self.check.fail("WMS302", "`strict` must be true or false, the same in all instances", value.span)

    def _report(self, faults: tuple[Diagnostic, ...], named: s.Text) -> None:
        """Report faults of a file where the spec names it, warnings once for all objects of the file."""
        key = resolve_display_path(named.span.source.name).parent, named.value
        fresh = [f for f in faults if f.severity == "error" or (key, f) not in self._warned]
        self._warned |= {(key, f) for f in fresh}
        self.check.report.include(fault.named_at(named.span) for fault in fresh)

    # ------------------------------------------------------------ what the spec says of links and joints

    def _names(self, tree: LinkTree, named: s.Text) -> dict[str, str]:
        """Return the identifiers of the links and joints, each with its name in the file."""
        from wmspec.lang.importers.blocks import to_identifier
        from wmspec.lang.importers.tree import named_elements

        by_plain: dict[str, str] = {}
        for name, where in named_elements(tree):
            taken = by_plain.get(to_identifier(name))
            if taken is not None or to_identifier(name) in PROPERTIES["object"]:
                whose = f"`{taken}`" if taken is not None else "a property of objects"
                message = f"its name conflicts with {whose} in a spec"
                self._report((Diagnostic(message, where, "rename one of them in the file", "WMS210"),), named)
                raise Failed
            by_plain[to_identifier(name)] = name
        return by_plain

    def _overrides(self, block: s.Block, tree: LinkTree, named: s.Text) -> dict[str, tuple[s.Property, ...]]:
        """Return the properties that `part NAME { ... }` sets on links and joints."""
        from wmspec.lang.importers.blocks import OF_JOINT, OF_LINK, to_identifier
        from wmspec.lang.importers.model import MeshFile

        links = {to_identifier(placed.link.name): placed.link for placed in tree.links}
        known = self._names(tree, named)
        overrides: dict[str, tuple[s.Property, ...]] = {}
        for part in block.parts:
            name = part.name.id
            if name not in known:
                message = f"`{named.value}` has no link or joint `{name}`"
                self.check.report.add("WMS201", message, part.name.span, suggestion(name, known))
            elif name in overrides:
                notes = (Note("first set here", block.parts[0].name.span),)
                self.check.report.add("WMS202", f"`{name}` is set twice", part.name.span, "make it one", notes)
            what, allowed = ("link", OF_LINK) if name in links else ("joint", OF_JOINT)
            overrides[name] = tuple(p for p in part.properties if p.name.id in allowed)
            for p in part.properties if name in known else ():
                if p.name.id not in allowed:
                    message = f"on a {what} of an asset, a spec cannot set `{p.name.id}`"
                    self.check.report.add("WMS203", message, p.name.span, f"it can set {', '.join(allowed)}")
                elif p.name.id == "collision" and not any(
                    isinstance(shape.form, MeshFile) and shape.solid for shape in links[name].shapes
                ):
                    message = f"`collision` is for a mesh, and nothing that is touched of `{name}` is one"
                    self.check.report.add("WMS203", message, p.name.span, "remove it")
        return overrides
