"""The design of a task: all its instances, each built from its index alone."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest
from typing import overload

from wmspec.compile.design.arrange import blocks
from wmspec.compile.design.constrain import constraints
from wmspec.compile.design.levels import Level, quantile
from wmspec.core.diagnostics import SpecError
from wmspec.core.rng import Permutation, uniform
from wmspec.lang.check.ir.ir import Choices, Items, TaskSpec


@dataclass(frozen=True)
class Instance:
    """One instance: its index, the control group (block) it belongs to, and the value of every factor and nuisance.

    `crossed` are the factors that vary within its group. `key` is what every draw for this instance begins with: the
    seed, the task and its control group, within which nothing varies but these factors. `redrawn` is how often before
    this the nuisances of the group were drawn otherwise.
    """

    index: int
    block: int
    factors: dict[str, Level]
    nuisances: dict[str, Level]
    key: tuple[object, ...] = ()
    crossed: tuple[str, ...] = ()
    redrawn: int = 0

    @property
    def values(self) -> dict[str, Level]:
        """Factors and nuisances together."""
        return self.factors | self.nuisances


class Design:
    """The combinations of a task's factors that its plan picks and its `require`s allow, in control groups (blocks).

    A block is all that the plan picks, made again as often as `repeat` says, or one of many small groups. Nuisances are
    drawn once per block, so that instances of a block differ in factors alone; in a Latin hypercube, whose instances
    differ in everything, once per instance. Indices count blocks first, then the combinations; in a factorial design
    those follow the order of the spec, the last factor fastest, and factors that `require`s tie together count where
    the first of them stands.

    Raises SpecError if there is no such design.
    """

    def __init__(self, spec: TaskSpec, seed: int = 0) -> None:
        self.spec = spec
        self.seed = seed
        self.factors = tuple(f for f in spec.factors if not f.nuisance)
        self.nuisances = tuple(f for f in spec.factors if f.nuisance)
        self.conditions = constraints(spec)
        self.blocks = blocks(spec, self.conditions, seed)
        self._alone = spec.plan.kind == "latin"
        self._redrawn = 0
        self._drawn: tuple[object, dict[str, Level]] = (None, {})
        if self.blocks.size > sys.maxsize:
            place = spec.plan.place or (spec.factors or spec.things)[0].place
            what = f"this design has {self.blocks.size:.2g} instances, more than can be numbered"
            raise SpecError(what, place, "draw some of them: `design sample of 1000`", code="WMS408")

    def __len__(self) -> int:
        return self.blocks.size

    @property
    def draws(self) -> int:
        """How many times everything that is drawn is drawn: the number of independent control groups."""
        return len(self) if self._alone else self.blocks.count

    @property
    def sample_sizes(self) -> dict[str, int]:
        """Of every factor and nuisance, from how many independent control groups one learns something about it.

        Of a factor that is crossed these are the groups in which it is, since there alone nothing else differs; of what
        has one value in a group, all groups.
        """
        turns = self.spec.plan.turn
        rounds, rest = divmod(self.draws, max(1, len(turns)))
        crossed = {name: rounds + (number < rest) for number, name in enumerate(turns)}
        return {f.name: crossed.get(f.name, self.draws) for f in (*self.factors, *self.nuisances)}

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
        block, place = self.blocks.locate(index)
        picked = self.blocks.values(block, place)
        key = (self.seed, self.spec.name, self._key(block, place))
        factors = {f.name: picked[f.name] for f in self.factors}
        return Instance(index, block, factors, self._draw(key), key, self.blocks.crossed(block), self._redrawn)

    def __iter__(self) -> Iterator[Instance]:
        return (self[i] for i in range(len(self)))

    def redrawn(self, times: int) -> Design:
        """The same design with everything drawn anew that is drawn for a group, for the so-manieth time; 0 is itself.

        Factors keep their values. Where answers are balanced, one of these is kept of each group.
        """
        if times and self._alone:
            raise IndexError(f"what {self.spec.name} draws is spread over all its instances, and drawn once")
        other = copy(self)
        other._redrawn, other._drawn = times, (None, {})
        return other

    def index(self, factors: Mapping[str, Level], block: int = 0) -> int | None:
        """The index of a combination; None if the design leaves it out."""
        return self.blocks.index(factors, block)

    def neighbours(self, index: int, factor: str) -> tuple[int, ...]:
        """The indices of the instances that differ from this one in one factor alone."""
        here = self[index]
        if self._alone or factor not in here.crossed:
            return ()
        domain = next(f.domain for f in self.factors if f.name == factor)
        assert isinstance(domain, Choices)
        others = (self.index(here.factors | {factor: value}, here.block) for value in domain.values)
        return tuple(other for other in others if other is not None and other != index)

    def lap(self, block: int) -> tuple[int, ...]:
        """The blocks that are made together with this one: itself, or those among which answers are balanced.

        These are as many as there are answers, in all of which the same factors are crossed.
        """
        if not self.spec.plan.balance:
            return (block,)
        turns = max(1, len(self.spec.plan.turn))
        round_, turn = divmod(block, turns)
        first = round_ - round_ % self.answers
        every = (number * turns + turn for number in range(first, first + self.answers))
        return tuple(other for other in every if other < self.blocks.count)

    @cached_property
    def answers(self) -> int:
        """How many answers there are to balance."""
        options = next(q.options for q in self.spec.questions if q.name == self.spec.plan.balance)
        assert isinstance(options, Items)
        return len(options.items)

    def sample(self, count: int) -> tuple[int, ...]:
        """`count` different indices in a random order that depends on the seed alone; all if there are fewer.

        Of a design in groups, as many groups as can be: of each in turn the instances that differ in what every group
        crosses, with one of the values of what takes turns, then with another; whole parts, at least one.
        Where answers are balanced, whole laps.
        """
        if self.spec.plan.kind != "groups":
            order = Permutation(len(self), self.seed, self.spec.name, "sample")
            return tuple(order(i) for i in range(min(count, len(self))))
        sampled: list[int] = []
        for part in self._laps() if self.spec.plan.balance else self._parts():
            if sampled and len(sampled) + len(part) > count:
                break
            sampled += part
        return tuple(sampled)

    @property
    def _order(self) -> Permutation:
        """The order in which groups are sampled."""
        return Permutation(self.blocks.count, self.seed, self.spec.name, "sample")

    def _laps(self) -> Iterator[list[int]]:
        """The members of all laps."""
        laps = dict.fromkeys(map(self.lap, map(self._order, range(self.blocks.count))))
        return ([index for block in lap for index in self.blocks.members(block)] for lap in laps)

    def _parts(self) -> Iterator[tuple[int, ...]]:
        """The parts of all groups, a first one of each, then a second: each has one value of what takes turns."""
        groups: list[Iterator[tuple[int, ...]]] = []
        for block in map(self._order, range(self.blocks.count)):
            parts = self._parted(block)
            order = map(Permutation(len(parts), self.seed, self.spec.name, "part", block), range(len(parts)))
            groups.append(map(parts.__getitem__, order))
            yield next(groups[-1])
        yield from (part for turn in zip_longest(*groups) for part in turn if part is not None)

    def drawn_with(self, index: int) -> tuple[int, int, int]:
        """Of what `sample` draws together with an instance: its turn, the instance's place in it, and how many it is.

        Whatever follows the turns comes equally often in every sample.
        """
        if self.spec.plan.kind != "groups":
            return Permutation(len(self), self.seed, self.spec.name, "sample").inverse(index), 0, 1
        block, place = self.blocks.locate(index)
        turn = self._order.inverse(block)
        if self.spec.plan.balance:
            return turn, place, len(self.blocks.members(block))
        parts = self._parted(block)
        number = next(number for number, part in enumerate(parts) if index in part)
        lap = Permutation(len(parts), self.seed, self.spec.name, "part", block).inverse(number)
        return lap * self.blocks.count + turn, parts[number].index(index), len(parts[number])

    def _parted(self, block: int) -> list[tuple[int, ...]]:
        """The members of a group, together those that differ in nothing but what every group crosses."""
        turning = [name for name in self.blocks.crossed(block) if name not in self.spec.plan.cross]
        parts: dict[tuple[Level, ...], list[int]] = {}
        for place, index in enumerate(self.blocks.members(block)):
            values = self.blocks.values(block, place)
            parts.setdefault(tuple(values[name] for name in turning), []).append(index)
        return [tuple(part) for part in parts.values()]

    def shard(self, number: int, count: int) -> Part:
        """Shard `number`, 1 .. `count`: equal shares of the design, to within one, which in order make up the whole."""
        return self[share(len(self), number, count)]

    def _key(self, block: int, place: int) -> object:
        """What tells a control group's draws from those of others."""
        if self._alone:
            return f"{block}.{place}"
        return f"{block}/{self._redrawn}" if self._redrawn else block

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
