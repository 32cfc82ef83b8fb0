"""Prims of objects that were made before: an object is the same wherever all has the same levels that it depends on.

What that is the spec alone tells. Those of a control group differ in what one factor decides, and share the rest.
"""

from __future__ import annotations

from typing import Any

from wmspec.compile.design.depend import dependencies
from wmspec.compile.layout.values import Values
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.objects import add_object
from wmspec.compile.stage.one_factor import changed_by
from wmspec.core.memoize import LRU
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.tables.vocabulary import PROPERTIES


class ObjectCache:
    """Makes the prims of objects, and remembers the latest of the latest specs."""

    def __init__(self, remembered: int = 1024, specs: int = 8) -> None:
        self._deciding: LRU[int, _Deciding] = LRU(specs)
        self._made: LRU[tuple[Any, ...], tuple[TaskSpec, Document]] = LRU(remembered)

    def add(self, doc: Document, name: str, values: Values, carriers: frozenset[str], carried: bool) -> None:
        """What `add_object` adds. Raises WmsError where that does."""
        spec = values.spec  # it stays with what is remembered, and so its `id`
        levels = self._deciding.get(id(spec), lambda: _Deciding(spec)).levels(name, values)
        if levels is None:
            add_object(doc, name, values, carriers, carried)
            return

        def make() -> tuple[TaskSpec, Document]:
            own = Document({})
            add_object(own, name, values, carriers, carried)
            return spec, own

        doc.prims.update(self._made.get((id(spec), name, carried, *levels), make)[1].prims)


class _Deciding:
    """What decides the prims of each object of a spec: sources, and of these the factors and nuisances."""

    def __init__(self, spec: TaskSpec) -> None:
        self.spec, self._depend = spec, dependencies(spec)
        self._known: dict[str, tuple[frozenset[str], tuple[str, ...], bool]] = {}

    def levels(self, name: str, values: Values) -> tuple[Any, ...] | None:
        """What the prims of an object depend on; None where they depend on more than levels and draws."""
        if values.assets or values.has(name, "passes"):
            return None
        if name not in self._known:
            sources = self._sources(name, values)
            factors = tuple(sorted(sources & values.assignment.keys()))
            scattering = {f"{thing.name}.scatter" for thing in values.spec.things if "scatter" in thing.properties}
            self._known[name] = sources, factors, not sources.isdisjoint(scattering)
        sources, factors, scattered = self._known[name]
        change = values.change
        if change is not None and change.change != "levels" and not sources.isdisjoint(changed_by(change)):
            return None
        return (*(values.assignment[factor] for factor in factors), *(values.key if scattered else ()))

    def _sources(self, name: str, values: Values) -> frozenset[str]:
        """All that the prims of an object may depend on, directly or not."""
        own = [f"{name}.{aspect}" for aspect in ("pose", *PROPERTIES["object"])]
        own += [f"{part}.{word}" for part in values.parts(name) for word in PROPERTIES["part"]]
        return self._depend.sources(own)
