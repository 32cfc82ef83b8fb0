"""Counts the prims of a stage from its layers before USD composes them.

A few lines can expand to billions of prims by nested references.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from pxr import Sdf, Tf

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import COMPOSED_PRIMS, FILE_BYTES, XML_DEPTH
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import NotARegularFile, regular_file
from wmspec.sim.usd.crate import require_readable

#: A layer and a path in it.
Site = tuple[Sdf.Layer, Sdf.Path]

#: The list edits of composition arcs.
_EDITS = ("explicitItems", "prependedItems", "appendedItems", "addedItems")


def require_bounded(path: Path) -> None:
    """Raise TooLarge if a file or a referenced file is too large, or if the stage would have too many prims."""
    _small(path)
    require_readable(path)
    try:
        layer = Sdf.Layer.FindOrOpen(str(path))
    except Tf.ErrorException:
        return  # USD reports it when it opens the stage
    if layer is not None:
        _Counter().count((layer, Sdf.Path.absoluteRootPath), 0)


class _Counter:
    """Counts prims bottom-up, each site once."""

    def __init__(self) -> None:
        self._counts: dict[tuple[str, Sdf.Path], int] = {}

    def count(self, site: Site, depth: int) -> int:
        """Return the number of prims at and below a site, references included."""
        layer, path = site
        key = (layer.identifier, path)
        if key not in self._counts:
            if depth > XML_DEPTH.most:
                raise XML_DEPTH.exceeded()
            self._counts[key] = 0  # cyclic references, which USD reports
            total = 1 + sum(self.count(inner, depth + 1) for inner in _children(site))
            if total > COMPOSED_PRIMS.most:
                raise COMPOSED_PRIMS.exceeded()
            self._counts[key] = total
        return self._counts[key]


def _children(site: Site) -> Iterator[Site]:
    """Yield children and references of a site."""
    layer, path = site
    if path == Sdf.Path.absoluteRootPath:
        for name in layer.subLayerPaths:
            yield from _at(layer, name, path)
    spec = layer.GetPrimAtPath(path)
    if spec is None:
        return
    yield from ((layer, child.path) for child in spec.nameChildren if child)  # None in damaged files
    for variants in spec.variantSets:
        yield from ((layer, variant.path) for variant in variants.variants)
    for arcs in (spec.referenceList, spec.payloadList):
        for arc in _items(arcs):
            yield from _at(layer, arc.assetPath, arc.primPath)
    for inherited in (spec.inheritPathList, spec.specializesList):
        yield from ((layer, to) for to in _items(inherited))


def _items(edited: Any) -> Iterable[Any]:
    return [item for edit in _EDITS for item in getattr(edited, edit)]


def _at(layer: Sdf.Layer, asset: str, path: Sdf.Path) -> Iterator[Site]:
    """Yield a prim of another layer, or of this one if none is named; the default prim if no path is given."""
    other = layer
    if asset:
        name = layer.ComputeAbsolutePath(asset)
        _small(Path(name))
        require_readable(Path(name))
        try:
            other = Sdf.Layer.FindOrOpen(name)
        except Tf.ErrorException:
            other = None  # USD reports it
    if other is not None:
        named = path or (Sdf.Path(f"/{other.defaultPrim}") if other.defaultPrim else Sdf.Path.absoluteRootPath)
        yield other, named


def _small(path: Path) -> None:
    try:
        if regular_file(path).stat().st_size > FILE_BYTES.most:
            raise FILE_BYTES.exceeded()
    except NotARegularFile as error:
        raise WmsError(str(error.strerror), FilePlace(path.name)) from None
    except (OSError, ValueError):  # USD reports it
        return
