"""Counts the prims of a stage from its layers before USD composes them.

A few lines can expand to billions of prims by nested references. The count is an upper bound: it includes all variants,
and every inherited class in the layers of the stage and of the asset.

Variable expressions in asset paths are bounded too: a few nested variables can expand to gigabytes. So are the files of
value clips, which USD opens when a value at a time is first read.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pxr import Sdf

from wmspec.core.limits import COMPOSED_PRIMS, EXPRESSION_LENGTH, LAYERS, XML_DEPTH
from wmspec.sim.usd.layer_files import LayerFiles
from wmspec.sim.usd.probe import require_readable

Variables = tuple[tuple[str, object], ...]

_REFERENCE = re.compile(r"\$\{([^}]*)\}")
#: Nesting from which variables are cyclic or made to expand.
_DEPTH = 20

#: The list edits of composition arcs.
_EDITS = ("explicitItems", "prependedItems", "appendedItems", "addedItems")


def require_bounded(path: Path) -> None:
    """Check all files of a stage before USD composes it.

    Raises WmsError if one of them is a pipe or device, damaged or too large, or if the stage would have too many layers
    or prims, or takes too long.
    """
    files = LayerFiles()
    root = files.open(str(path))
    if root is None:
        return  # USD reports it when it opens the stage
    require_bounded_layer(root, files)
    if len(files.layers) > 1:
        require_readable(path, "stage")


def require_bounded_layer(root: Sdf.Layer, files: LayerFiles | None = None) -> None:
    """Check an opened layer and the layers that it names, before USD composes it. Raises as `require_bounded`."""
    stack = LayerStack(root, variables_of(root, ()))
    _Counter(files or LayerFiles(), stack).entry(stack, Sdf.Path.absoluteRootPath, 0)


@dataclass(frozen=True)
class LayerStack:
    """A layer with its sublayers, and the variables of expressions in them."""

    root: Sdf.Layer
    variables: Variables

    @property
    def key(self) -> tuple[str, Variables]:
        """What distinguishes it."""
        return self.root.identifier, self.variables


class _Counter:
    """Counts prims bottom-up, each site once."""

    def __init__(self, files: LayerFiles, stage: LayerStack) -> None:
        self._files, self._stage = files, stage
        self._counts: dict[object, int] = {}
        self._specs: dict[object, list[Any]] = {}
        self._stacked: dict[object, list[Sdf.Layer]] = {}

    def entry(self, stack: LayerStack, path: Sdf.Path, depth: int) -> int:
        """Return the number of prims at and below a site that an arc targets.

        It has what its ancestors bring by their own arcs too.
        """
        key = ("entry", *stack.key, path)
        if key in self._counts:
            return self._counts[key]
        self._counts[key] = 0  # cyclic references, which USD reports
        total = self._node(stack, path, depth)
        for ancestor in path.GetAncestorsRange():
            if ancestor != path:
                for other, target in self._targets(stack, ancestor):
                    total += self.entry(other, path.ReplacePrefix(ancestor, target), self._deeper(depth))
        return self._kept(key, total)

    def _node(self, stack: LayerStack, path: Sdf.Path, depth: int) -> int:
        """Return the number of prims at and below a site of a layer stack, with the targets of its arcs."""
        key = (*stack.key, path)
        if key in self._counts:
            return self._counts[key]
        self._counts[key] = 0
        total = 1
        names = {str(name) for spec in self._at(stack, path) for name in _info(spec, "primChildren")}
        for name in sorted(names):
            total += self._node(stack, path.AppendChild(name), self._deeper(depth))
        for other, target in self._targets(stack, path):
            total += self.entry(other, target, self._deeper(depth))
        return self._kept(key, total)

    def _kept(self, key: object, total: int) -> int:
        if total > COMPOSED_PRIMS.most:
            raise COMPOSED_PRIMS.exceeded()
        self._counts[key] = total
        return total

    def _deeper(self, depth: int) -> int:
        if depth >= XML_DEPTH.most:
            raise XML_DEPTH.exceeded()
        return depth + 1

    def _targets(self, stack: LayerStack, path: Sdf.Path) -> Iterator[tuple[LayerStack, Sdf.Path]]:
        """Yield the targets of the arcs of a site; check its value clips."""
        for spec in self._at(stack, path):
            for name in clip_files(spec):
                self._files.check(spec.layer.ComputeAbsolutePath(evaluated(name, stack.variables)))
            for kind in ("references", "payload"):
                for arc in _items(spec, kind):
                    yield from self._target(stack, spec.layer, arc.assetPath, arc.primPath)
            for kind in ("inheritPaths", "specializes"):
                for to in _items(spec, kind):
                    yield stack, to
                    if stack.key != self._stage.key and self._at(self._stage, to):
                        yield self._stage, to

    def _target(
        self, stack: LayerStack, layer: Sdf.Layer, asset: str, path: Sdf.Path
    ) -> Iterator[tuple[LayerStack, Sdf.Path]]:
        """Yield a prim of another layer, or of this stack if none is named; the default prim if no path is given."""
        other = stack
        if asset:
            name = evaluated(asset, stack.variables)
            root = self._files.open(layer.ComputeAbsolutePath(name)) if name else None
            if root is None:
                return
            other = LayerStack(root, variables_of(root, stack.variables))
        default = other.root.defaultPrim
        yield other, path or (Sdf.Path(f"/{default}") if default else Sdf.Path.absoluteRootPath)

    def _at(self, stack: LayerStack, path: Sdf.Path) -> list[Any]:
        """Return the prim specs at a path in all layers of a stack and in all variants."""
        key = (*stack.key, path)
        if key not in self._specs:
            if path == Sdf.Path.absoluteRootPath:
                found = [layer.pseudoRoot for layer in self._layers(stack)]
            else:
                above = self._at(stack, path.GetParentPath())
                found = [spec.layer.GetPrimAtPath(spec.path.AppendChild(path.name)) for spec in above]
            self._specs[key] = [variant for spec in found if spec for variant in _with_variants(spec)]
        return self._specs[key]

    def _layers(self, stack: LayerStack) -> list[Sdf.Layer]:
        """Return the layers of a stack, each once."""
        if stack.key not in self._stacked:
            found: dict[str, Sdf.Layer] = {}
            left = [stack.root]
            while left:
                layer = left.pop()
                if layer.identifier in found:
                    continue
                found[layer.identifier] = layer
                names = (evaluated(name, stack.variables) for name in layer.subLayerPaths)
                opened = [self._files.open(layer.ComputeAbsolutePath(name)) for name in names if name]
                left += [other for other in opened if other is not None]
            self._stacked[stack.key] = list(found.values())
        return self._stacked[stack.key]


def _with_variants(spec: Any) -> Iterator[Any]:
    """Yield a prim spec and those of its variants, nested ones included."""
    yield spec
    for variants in spec.variantSets if spec.HasInfo("variantSetChildren") else ():
        for variant in variants.variants:
            yield from _with_variants(variant.primSpec)


def _items(spec: Any, kind: str) -> Iterable[Any]:
    return [item for edit in _EDITS if spec.HasInfo(kind) for item in getattr(spec.GetInfo(kind), edit)]


def _info(spec: Any, key: str) -> Iterable[Any]:
    """Return a list of a spec; unlike the views of pxr on children and arcs, its time is linear in their number."""
    return spec.GetInfo(key) if spec.HasInfo(key) else ()


def clip_files(spec: Any) -> Iterator[str]:
    """Yield the asset paths of a prim's clips as written, and those in its folder that match a template.

    Raises TooLarge if a template matches too many files.
    """
    if not spec.HasInfo("clips"):
        return
    clips = spec.GetInfo("clips")
    for one in clips.values() if isinstance(clips, dict) else ():
        if not isinstance(one, dict):
            continue
        for path in [*(one.get("assetPaths") or ()), one.get("manifestAssetPath")]:
            if path:
                yield str(getattr(path, "path", path))
        if template := one.get("templateAssetPath"):
            yield from _matching(spec.layer.ComputeAbsolutePath(str(template)))


def _matching(template: str) -> Iterator[str]:
    """Yield the existing files of a template such as `clip.###.usd`, where `#` is a digit."""
    place = Path(template)
    if "#" not in place.name or not place.parent.is_dir():
        return
    pattern = re.compile(re.sub(r"(\\#)+", r"-?\\d+", re.escape(place.name)))
    for number, path in enumerate(sorted(place.parent.iterdir())):
        if number > LAYERS.most:
            raise LAYERS.exceeded()
        if pattern.fullmatch(path.name):
            yield str(path)


def variables_of(layer: Sdf.Layer, outer: Variables) -> Variables:
    """Return the variables of a layer stack with this root, of which those of the referencing stack are stronger."""
    return tuple(sorted({**dict(layer.expressionVariables), **dict(outer)}.items(), key=lambda pair: pair[0]))


def evaluated(path: str, variables: Variables) -> str:
    """Return an asset path with its expression evaluated; '' if that is invalid, which USD reports.

    Raises TooLarge if the expression, with its variables expanded, is too long.
    """
    if not Sdf.VariableExpression.IsExpression(path):
        return path
    known = dict(variables)
    if _expanded_length(path, known, 0) > EXPRESSION_LENGTH.most:
        raise EXPRESSION_LENGTH.exceeded()
    result = Sdf.VariableExpression(path).Evaluate(known)
    return result.value if isinstance(result.value, str) and not result.errors else ""


def _expanded_length(text: str, known: Mapping[str, object], depth: int) -> int:
    """Return an upper bound on the length of a text after its variables are expanded."""
    length = len(text)
    if depth > _DEPTH or length > EXPRESSION_LENGTH.most:
        raise EXPRESSION_LENGTH.exceeded()
    for name in _REFERENCE.findall(text):
        value = known.get(name)
        length += _expanded_length(value, known, depth + 1) if isinstance(value, str) else 0
        if length > EXPRESSION_LENGTH.most:
            raise EXPRESSION_LENGTH.exceeded()
    return length
