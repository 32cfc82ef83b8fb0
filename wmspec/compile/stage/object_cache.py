"""A cache of object prims: prims depend only on the levels that the object depends on.

These levels follow from the spec alone. Members of a control group share all prims that the crossed factor does not
affect.
"""

from __future__ import annotations

from typing import Any

from wmspec.compile.design.depend import changed_by, dependencies
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.objects import add_object
from wmspec.core.memoize import LRU
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.tables.vocabulary import PROPERTIES


class ObjectCache:
    """Builds the prims of objects, and caches the most recent ones of the most recent specs."""

    def __init__(self, remembered: int = 1024, specs: int = 8) -> None:
        self._deciding: LRU[int, _ObjectDependencies] = LRU(specs)
        self._made: LRU[tuple[Any, ...], tuple[TaskSpec, Document]] = LRU(remembered)

    def add(self, doc: Document, name: str, values: Evaluator, carriers: frozenset[str], carried: bool) -> None:
        """Add what `add_object` adds. Raises WmsError like `add_object`."""
        spec = values.spec  # cached with the document, which keeps its `id` unique
        levels = self._deciding.get(id(spec), lambda: _ObjectDependencies(spec)).levels(name, values)
        if levels is None:
            add_object(doc, name, values, carriers, carried)
            return

        def make() -> tuple[TaskSpec, Document]:
            own = Document({})
            add_object(own, name, values, carriers, carried)
            return spec, own

        doc.prims.update(self._made.get((id(spec), name, carried, *levels), make)[1].prims)


class _ObjectDependencies:
    """The dependencies of each object of a spec: sources, and the factors and nuisances among them."""

    def __init__(self, spec: TaskSpec) -> None:
        self.spec, self._depend = spec, dependencies(spec)
        self._known: dict[str, tuple[frozenset[str], tuple[str, ...], bool]] = {}

    def levels(self, name: str, values: Evaluator) -> tuple[Any, ...] | None:
        """Return the cache key of an object's prims, or None if they depend on more than levels and draws."""
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

    def _sources(self, name: str, values: Evaluator) -> frozenset[str]:
        """Return all sources that the prims of an object may depend on."""
        own = [f"{name}.{aspect}" for aspect in ("pose", *PROPERTIES["object"])]
        own += [f"{part}.{word}" for part in values.parts(name) for word in PROPERTIES["part"]]
        return self._depend.sources(own)
