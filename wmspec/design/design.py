"""The design of a task: all its instances, each built from its index alone."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import overload

from wmspec.check.ir import Choices, TaskSpec
from wmspec.design.arrange import arrange
from wmspec.design.constrain import constraints
from wmspec.design.fault import Fault
from wmspec.draws import Level, Permutation, quantile, uniform


@dataclass(frozen=True)
class Instance:
    """One instance: its index, the repetition (block) it belongs to, and the value of every factor and nuisance.

    `key` is what every draw for this instance begins with: the seed, the task and its control group, within which
    nothing varies but the factors.
    """

    index: int
    block: int
    factors: dict[str, Level]
    nuisances: dict[str, Level]
    key: tuple[object, ...] = ()

    @property
    def values(self) -> dict[str, Level]:
        """Factors and nuisances together."""
        return self.factors | self.nuisances


class Design:
    """The combinations of a task's factors that its plan picks and its `require`s allow, `repeat`ed as blocks.

    Nuisances are drawn once per block, so that instances of a block differ in factors alone; in a Latin hypercube,
    whose instances differ in everything, once per instance. Indices count blocks first, then the combinations; in a
    factorial design those follow the order of the spec, the last factor fastest, and factors that `require`s tie
    together count where the first of them stands.

    Raises Fault if there is no such design.
    """

    def __init__(self, spec: TaskSpec, seed: int = 0) -> None:
        self.spec = spec
        self.seed = seed
        self.factors = tuple(f for f in spec.factors if not f.nuisance)
        self.nuisances = tuple(f for f in spec.factors if f.nuisance)
        self.conditions = constraints(spec)
        self._columns, self._plan = arrange(spec, self.conditions, seed)
        self._alone = spec.plan.kind == "latin"
        self._drawn: tuple[object, dict[str, Level]] = (None, {})
        self.block_size = self._plan.size
        if self.block_size * spec.repeat > sys.maxsize:
            place = spec.plan.place or (spec.factors or spec.things)[0].place
            what = f"this design has {self.block_size * spec.repeat:.2g} instances, more than can be numbered"
            raise Fault("WMS408", what, place, "draw some of them: `design sample of 1000`")

    def __len__(self) -> int:
        return self.block_size * self.spec.repeat

    @overload
    def __getitem__(self, index: int) -> Instance: ...
    @overload
    def __getitem__(self, index: slice) -> Part: ...
    def __getitem__(self, index: int | slice) -> Instance | Part:
        """Instance `index`, at the same cost whatever the size of the design; for a slice, a lazy sequence.

        Raises IndexError outside 0..len-1.
        """
        if isinstance(index, slice):
            return Part(self, range(len(self))[index])
        if not 0 <= index < len(self):
            raise IndexError(f"{self.spec.name} has instances 0 to {len(self) - 1}, not {index}")
        block, position = divmod(index, self.block_size)
        picked: dict[str, Level] = {}
        for column, rank in zip(self._columns, self._plan.ranks(position), strict=True):
            picked.update(zip(column.names, column.values(rank), strict=True))
        key = (self.seed, self.spec.name, f"{block}.{position}" if self._alone else block)
        return Instance(index, block, {f.name: picked[f.name] for f in self.factors}, self._draw(key), key)

    def __iter__(self) -> Iterator[Instance]:
        return (self[i] for i in range(len(self)))

    def index(self, factors: Mapping[str, Level], block: int = 0) -> int | None:
        """The index of a combination; None if the design leaves it out."""
        ranks = []
        for column in self._columns:
            rank = column.rank([factors[n] for n in column.names])
            if rank is None:
                return None
            ranks.append(rank)
        position = self._plan.position(tuple(ranks))
        return None if position is None else block * self.block_size + position

    def neighbours(self, index: int, factor: str) -> tuple[int, ...]:
        """The indices of the instances that differ from this one in one factor alone."""
        if self._alone:
            return ()
        here = self[index]
        domain = next(f.domain for f in self.factors if f.name == factor)
        assert isinstance(domain, Choices)
        others = (self.index(here.factors | {factor: value}, here.block) for value in domain.values)
        return tuple(other for other in others if other is not None and other != index)

    def sample(self, count: int) -> tuple[int, ...]:
        """`count` different indices in a random order that depends on the seed alone; all if there are fewer."""
        order = Permutation(len(self), self.seed, self.spec.name, "sample")
        return tuple(order(i) for i in range(min(count, len(self))))

    def shard(self, number: int, count: int) -> Part:
        """Shard `number`, 1 .. `count`: equal shares of the design, to within one, which in order make up the whole."""
        return self[share(len(self), number, count)]

    def _draw(self, key: tuple[object, ...]) -> dict[str, Level]:
        """The nuisances of a control group, kept until another group is asked for."""
        known, drawn = self._drawn
        if known != key:
            drawn = {n.name: quantile(n.domain, uniform(*key, n.name)) for n in self.nuisances}
            self._drawn = (key, drawn)
        return dict(drawn)


def share(size: int, number: int, count: int) -> slice:
    """Share `number`, 1 .. `count`, of so many things. Raises IndexError if there is no such share."""
    if not 1 <= number <= count:
        raise IndexError(f"there are shards 1 to {count}, not {number}")
    return slice(size * (number - 1) // count, size * number // count)


class Part(Sequence[Instance]):
    """Some instances of a design, each built when it is asked for."""

    def __init__(self, design: Design, indices: range) -> None:
        self.design = design
        self.indices = indices

    def __len__(self) -> int:
        return len(self.indices)

    @overload
    def __getitem__(self, index: int) -> Instance: ...
    @overload
    def __getitem__(self, index: slice) -> Part: ...
    def __getitem__(self, index: int | slice) -> Instance | Part:
        """The instance at a place of this part, or a part of it."""
        picked = self.indices[index]
        return Part(self.design, picked) if isinstance(picked, range) else self.design[picked]
