"""Which instances go to a worker together: those that share episodes and pictures.

What would have happened is what happens in a neighbour: instances that differ only in what counterfactuals change have
the same episodes, and those that differ in looks besides have the same physics. Whatever else differs in a control
group, it shares a place, its light and most of its things. This is worked out from the spec alone; were it wrong, some
episode would be executed twice, and nothing else would come of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from wmspec.compile.design.depend import Dependencies
from wmspec.compile.design.design import Design, Instance
from wmspec.compile.layout.values import Values
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import built
from wmspec.compile.stage.one_factor import changed_by
from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import MOST_DRAWS
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.runtime.questions.closed_sets import has_closed

#: A unit has so many instances at most (but a closed set is never parted): what a worker gets at a time.
MOST = 32

#: Instances that are made together: one, those of a closed set, or those among which answers are balanced.
Piece = tuple[int, ...]


def units(spec: TaskSpec, seed: int, indices: Sequence[int]) -> Iterator[list[Piece]]:
    """The pieces of every unit, in the order in which they share most; every index comes once."""
    design = Design(spec, seed)
    if spec.plan.balance:
        laps: dict[tuple[int, ...], list[int]] = {}
        for index in indices:
            laps.setdefault(design.lap(design.blocks.locate(index)[0]), []).append(index)
        yield from ([tuple(lap)] for lap in laps.values())
        return
    kin = _Kin(design)
    shared: dict[object, dict[object, dict[object, list[Piece]]]] = {}
    for piece in _pieces(design, indices):
        first = design[piece[0]]
        alike = shared.setdefault(kin.unit(first), {}).setdefault(kin.physics(first), {})
        alike.setdefault(kin.looks(first), []).append(piece)
    for physics in shared.values():
        unit: list[Piece] = []
        for piece in (piece for looks in physics.values() for pieces in looks.values() for piece in pieces):
            if unit and sum(map(len, unit)) + len(piece) > MOST:
                yield unit
                unit = []
            unit.append(piece)
        yield unit


def _pieces(design: Design, indices: Sequence[int]) -> Iterable[Piece]:
    """What is asked at a time: an instance, or what is wanted of a group that is asked as a whole."""
    if not has_closed(design.spec):
        return ((index,) for index in indices)
    groups: dict[int, list[int]] = {}
    for index in indices:
        groups.setdefault(design.blocks.locate(index)[0], []).append(index)
    return map(tuple, groups.values())


def weight(spec: TaskSpec, piece: Piece) -> int:
    """How many instances may have to be made for a piece."""
    return len(piece) * (MOST_DRAWS if spec.plan.balance else 1)


class _Kin:
    """What the instances of a task have in common that share episodes."""

    def __init__(self, design: Design) -> None:
        spec, depend = design.spec, Dependencies(design.spec)
        changes = (change for question in spec.questions for change in question.counterfactuals)
        changed = {source for change in changes for name in changed_by(change) for source in depend.source(name)}
        felt = {source for name in _felt(design) for source in depend.source(name)}
        self._looks = [factor.name for factor in design.factors if factor.name not in changed]
        self._physics = [name for name in self._looks if name in felt]
        self._drawn = bool({factor.name for factor in design.nuisances} & felt)

    def unit(self, instance: Instance) -> object:
        """Alike where instances belong together: by what they draw, if physics reads that, or else by their physics."""
        return instance.key if self._drawn else self.physics(instance)

    def physics(self, instance: Instance) -> object:
        """Alike where instances that belong together may share physics."""
        return tuple(instance.factors[name] for name in self._physics)

    def looks(self, instance: Instance) -> object:
        """Alike where they may share pictures as well."""
        return (instance.key, *(instance.factors[name] for name in self._looks))


def _felt(design: Design) -> set[str]:
    """The sources of what physics reads; those of everything if the first instance cannot be staged."""
    instance = design[0]
    try:
        document = built(Values(design.spec, instance.values, None, instance.key))
    except WmsError:
        return {factor.name for factor in design.spec.factors}
    return set(_sources(document))


def _sources(document: Document) -> Iterator[str]:
    """What decides the properties of a stage that physics reads."""
    for path, prim in document.prims.items():
        seen_only = path.startswith(("/World/Cameras", "/World/Lights", "/World/Episode/Observations"))
        if seen_only:
            continue
        yield from prim.sources
        for name, attribute in prim.attributes.items():
            if name.startswith("physics:") or not path.startswith("/World/Materials"):
                yield from attribute.sources
