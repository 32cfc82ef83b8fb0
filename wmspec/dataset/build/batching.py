"""Batching: groups instances that share episodes and pictures, so that one worker makes them together.

A counterfactual of an instance is the episode of a neighbour. Instances that differ only in what counterfactuals change
share episodes; those that also differ in appearance share physics. Other members of a control group share the place,
its light and most objects. All this follows from the spec alone. An error here would cost repeated episodes but change
no result.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from wmspec.compile.design.depend import changed_by, dependencies
from wmspec.compile.design.design import Design, Instance
from wmspec.compile.design.what_ifs import possible_what_ifs
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import build_document
from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import MAX_DRAWS
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.runtime.questions.closed_sets import has_closed_set

#: Maximum number of instances in a unit; closed sets are never split.
MAX_BATCH = 32

#: Instances made together: one, those of a closed set, or those among which answers are balanced.
Piece = tuple[int, ...]


def batches(spec: TaskSpec, seed: int, indices: Sequence[int]) -> Iterator[list[Piece]]:
    """Yield the pieces of every unit, ordered by how much they share; every index occurs once."""
    design = Design(spec, seed)
    if spec.plan.balance:
        laps: dict[tuple[int, ...], list[int]] = {}
        for index in indices:
            laps.setdefault(design.balance_batch(design.blocks.locate(index)[0]), []).append(index)
        yield from ([tuple(lap)] for lap in laps.values())
        return
    batch_key = _BatchKey(design)
    shared: dict[object, dict[object, dict[object, list[Piece]]]] = {}
    for piece in _pieces(design, indices):
        first = design[piece[0]]
        alike = shared.setdefault(batch_key.unit(first), {}).setdefault(batch_key.physics(first), {})
        alike.setdefault(batch_key.looks(first), []).append(piece)
    for physics in shared.values():
        unit: list[Piece] = []
        for piece in (piece for looks in physics.values() for pieces in looks.values() for piece in pieces):
            if unit and sum(map(len, unit)) + len(piece) > MAX_BATCH:
                yield unit
                unit = []
            unit.append(piece)
        yield unit


def _pieces(design: Design, indices: Sequence[int]) -> Iterable[Piece]:
    """Return the pieces: single instances, or the requested members of a group that is made as a whole."""
    if not has_closed_set(design.spec):
        return ((index,) for index in indices)
    groups: dict[int, list[int]] = {}
    for index in indices:
        groups.setdefault(design.blocks.locate(index)[0], []).append(index)
    return map(tuple, groups.values())


def weight(spec: TaskSpec, piece: Piece) -> int:
    """Return the number of instances that a piece may require."""
    return len(piece) * (MAX_DRAWS if spec.plan.balance else 1)


class _BatchKey:
    """Keys of the instances of a task that share episodes."""

    def __init__(self, design: Design) -> None:
        spec, depend = design.spec, dependencies(design.spec)
        changes = [change for question in spec.questions for change in question.counterfactuals]
        changes += [change for question in spec.questions for change in possible_what_ifs(question, depend)]
        changed = {source for change in changes for name in changed_by(change) for source in depend.source(name)}
        relevant = {source for name in _physics_variables(design) for source in depend.source(name)}
        self._looks = [factor.name for factor in design.factors if factor.name not in changed]
        self._physics = [name for name in self._looks if name in relevant]
        self._drawn = bool({factor.name for factor in design.nuisances} & relevant)

    def unit(self, instance: Instance) -> object:
        """Return the key of instances that belong to one unit: their draws if physics depends on draws, else their
        physics.
        """
        return instance.key if self._drawn else self.physics(instance)

    def physics(self, instance: Instance) -> object:
        """Return the key of instances of a unit that may share physics."""
        return tuple(instance.factors[name] for name in self._physics)

    def looks(self, instance: Instance) -> object:
        """Return the key of instances that may share pictures as well."""
        return (instance.key, *(instance.factors[name] for name in self._looks))


def _physics_variables(design: Design) -> set[str]:
    """Return the variables that physics depends on; all variables if the first instance cannot be staged."""
    instance = design[0]
    try:
        document = build_document(Evaluator(design.spec, instance.values, None, instance.key))
    except WmsError:
        return {factor.name for factor in design.spec.factors}
    return set(_sources(document))


def _sources(document: Document) -> Iterator[str]:
    """Yield the variables that determine physics properties of a stage."""
    for path, prim in document.prims.items():
        seen_only = path.startswith(("/World/Cameras", "/World/Lights", "/World/Episode/Observations"))
        if seen_only:
            continue
        yield from prim.sources
        for name, attribute in prim.attributes.items():
            if name.startswith("physics:") or not path.startswith("/World/Materials"):
                yield from attribute.sources
