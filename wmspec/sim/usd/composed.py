"""How many prims a stage would have, told from its layers before USD composes them.

A few lines can ask for billions: a prim that refers twice to another that refers twice to another, and so on.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from pxr import Sdf, Tf

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import BYTES, COMPOSED, DEPTH
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import Endless, plain
from wmspec.sim.usd.crate import trusted

#: Where a prim is: the layer and the path in it.
Site = tuple[Sdf.Layer, Sdf.Path]

#: The lists of arcs that a prim has, each of which may be edited in these ways.
_EDITS = ("explicitItems", "prependedItems", "appendedItems", "addedItems")


def bounded(path: Path) -> None:
    """Raise TooLarge if a file, or one that it uses, is too large, or if the stage would have too many prims."""
    _small(path)
    trusted(path)
    try:
        layer = Sdf.Layer.FindOrOpen(str(path))
    except Tf.ErrorException:
        return  # USD tells it when it opens the stage
    if layer is not None:
        _Counter().count((layer, Sdf.Path.absoluteRootPath), 0)


class _Counter:
    """Counts prims from below; each site once."""

    def __init__(self) -> None:
        self._counts: dict[tuple[str, Sdf.Path], int] = {}

    def count(self, site: Site, depth: int) -> int:
        """The prims at a site and below it, those of all that it refers to as well."""
        layer, path = site
        key = (layer.identifier, path)
        if key not in self._counts:
            if depth > DEPTH.most:
                raise DEPTH.exceeded()
            self._counts[key] = 0  # of what refers to itself, which USD complains of
            total = 1 + sum(self.count(inner, depth + 1) for inner in _parts(site))
            if total > COMPOSED.most:
                raise COMPOSED.exceeded()
            self._counts[key] = total
        return self._counts[key]


def _parts(site: Site) -> Iterator[Site]:
    """What stands below a site, and what it refers to."""
    layer, path = site
    if path == Sdf.Path.absoluteRootPath:
        for name in layer.subLayerPaths:
            yield from _at(layer, name, path)
    spec = layer.GetPrimAtPath(path)
    if spec is None:
        return
    yield from ((layer, child.path) for child in spec.nameChildren if child)  # in damaged files some are none
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
    """A prim of another layer, or of this one if none is named; the default one if no path is."""
    other = layer
    if asset:
        name = layer.ComputeAbsolutePath(asset)
        _small(Path(name))
        trusted(Path(name))
        try:
            other = Sdf.Layer.FindOrOpen(name)
        except Tf.ErrorException:
            other = None  # USD complains of it
    if other is not None:
        named = path or (Sdf.Path(f"/{other.defaultPrim}") if other.defaultPrim else Sdf.Path.absoluteRootPath)
        yield other, named


def _small(path: Path) -> None:
    try:
        if plain(path).stat().st_size > BYTES.most:
            raise BYTES.exceeded()
    except Endless as error:
        raise WmsError(str(error.strerror), FilePlace(path.name)) from None
    except (OSError, ValueError):  # USD tells it
        return
