"""The design of a task: all its instances, each computed from its index."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import islice, zip_longest
from typing import overload

from wmspec.compile.design.arrange import blocks
from wmspec.compile.design.constrain import constraints
from wmspec.compile.design.levels import Level, quantile
from wmspec.core.diagnostics import SpecError
from wmspec.core.rng import Permutation, uniform
from wmspec.lang.check.ir.ir import Choices, Items, TaskSpec

#: Whether an instance, by its index, may be selected.
Allowed = Callable[[int], bool]


@dataclass(frozen=True)
class Instance:
    """One instance: its index, its control group (block), and the value of every factor and nuisance.

    `crossed` are the factors that vary within its group. `key` is the prefix of every random draw: seed, task and
    control group. `redrawn` counts how often the nuisances of the group have been redrawn.
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
    """The combinations of factors that a plan selects and `require`s allow, in control groups (blocks).

    A block is either the whole selection, repeated `repeat` times, or one of many small groups. Nuisances are drawn
    once per block, so that instances of a block differ in factors only. In a Latin hypercube, whose instances differ in
    every factor, they are drawn once per instance. Indices count blocks first, then combinations. The order of the
    combinations in a block and of the turns of groups is a permutation of seed and task: without the seed, an index
    tells nothing about the level of a factor.

    Raises SpecError if the design is empty or infeasible.
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
        """Number of independent draws of the nuisances, one for each control group."""
        return len(self) if self._alone else self.blocks.count

    @property
    def sample_sizes(self) -> dict[str, int]:
        """The number of independent control groups that inform about each factor and nuisance.

        For a crossed factor, these are the groups that cross it. For a factor with one value per group, these are all
        groups.
        """
        turns = self.spec.plan.turn
        rounds, rest = divmod(self.draws, max(1, len(turns)))
        last = {self.blocks.locate_turn(self.draws - 1 - at)[0] for at in range(rest)}
        crossed = {name: rounds + (number in last) for number, name in enumerate(turns)}
        return {f.name: crossed.get(f.name, self.draws) for f in (*self.factors, *self.nuisances)}

    @overload
    def __getitem__(self, index: int) -> Instance: ...
    @overload
    def __getitem__(self, index: slice) -> InstanceSequence: ...
    def __getitem__(self, index: int | slice) -> Instance | InstanceSequence:
        """Return instance `index` in constant time; for a slice, a lazy sequence.

        Raises IndexError outside 0..len-1.
        """
        if isinstance(index, slice):
            return InstanceSequence(self, range(len(self))[index])
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
        """Return the same design with group-level draws re-sampled; `times` selects the re-sample (0 = original).

        Factors keep their values. Where answers are balanced, one re-sample of each group is kept.
        """
        if times and self._alone:
            raise IndexError(f"what {self.spec.name} draws is spread over all its instances, and drawn once")
        other = copy(self)
        other._redrawn, other._drawn = times, (None, {})
        return other

    def index(self, factors: Mapping[str, Level], block: int = 0) -> int | None:
        """Return the index of a combination, or None if the design omits it."""
        return self.blocks.index(factors, block)

    def neighbours(self, index: int, factor: str) -> tuple[int, ...]:
        """Return the indices of the instances that differ from this one in one factor only."""
        here = self[index]
        if self._alone or factor not in here.crossed:
            return ()
        domain = next(f.domain for f in self.factors if f.name == factor)
        assert isinstance(domain, Choices)
        others = (self.index(here.factors | {factor: value}, here.block) for value in domain.values)
        return tuple(other for other in others if other is not None and other != index)

    def balance_batch(self, block: int) -> tuple[int, ...]:
        """Return the blocks that are generated together with this one: itself, or its balance batch.

        A balance batch has one block per answer, all of which cross the same factors. They are in random order: the
        later ones compensate for the answers of the earlier ones, so that the order of indices would tell the answer.
        """
        if not self.spec.plan.balance:
            return (block,)
        turn, number = self.blocks.locate_turn(block)
        first = number - number % self.answers
        order = map(Permutation(self.answers, self.seed, self.spec.name, "batch", turn, first), range(self.answers))
        every = (self.blocks.in_turn(turn, first + other) for other in order)
        return tuple(other for other in every if other < self.blocks.count)

    def block_of(self, index: int) -> int:
        """Return the control group of an instance."""
        return self.blocks.locate(index)[0]

    @cached_property
    def answers(self) -> int:
        """Number of answers to balance."""
        options = next(q.options for q in self.spec.questions if q.name == self.spec.plan.balance)
        assert isinstance(options, Items)
        return len(options.items)

    def sample(self, count: int, allowed: Allowed | None = None) -> tuple[int, ...]:
        """Return `count` distinct indices in a random order that depends on the seed only; all if there are fewer.

        `allowed` says which indices may be taken; by default all.

        A design with groups covers as many groups as possible. From each group in turn it takes whole parts, at least
        one: the instances that differ in the factors crossed in every group and share the value of the rotating factor.
        Where answers are balanced, it takes whole balance batches.
        """
        if self.spec.plan.kind != "groups":
            order = map(Permutation(len(self), self.seed, self.spec.name, "sample"), range(len(self)))
            return tuple(islice(filter(allowed, order) if allowed else order, count))
        sampled: list[int] = []
        parts: Iterator[Sequence[int]] = self._laps() if self.spec.plan.balance else self._parts()
        for part in parts if allowed is None else filter(None, ([*filter(allowed, part)] for part in parts)):
            if sampled and len(sampled) + len(part) > count:
                break
            sampled += part
        return tuple(sampled)

    def selection(
        self, count: int | None, number: int = 1, of: int = 1, allowed: Allowed | None = None
    ) -> tuple[int, ...]:
        """Return share `number` (1 .. `of`) of a sample of `count` allowed indices, or of all, in ascending order.

        Raises IndexError if there is no such share.
        """
        chosen: Sequence[int] = range(len(self))
        if count is not None and count < len(self):
            chosen = sorted(self.sample(count, allowed))
        elif allowed is not None:
            chosen = [*filter(allowed, chosen)]
        return tuple(chosen[share(len(chosen), number, of)])

    @property
    def _order(self) -> Permutation:
        """The order in which groups are sampled."""
        return Permutation(self.blocks.count, self.seed, self.spec.name, "sample")

    def _laps(self) -> Iterator[list[int]]:
        """Yield the members of all balance batches."""
        laps = dict.fromkeys(map(self.balance_batch, map(self._order, range(self.blocks.count))))
        return ([index for block in lap for index in self.blocks.members(block)] for lap in laps)

    def _parts(self) -> Iterator[tuple[int, ...]]:
        """Yield the parts of all groups, first one of each group, then the second, and so on."""
        groups: list[Iterator[tuple[int, ...]]] = []
        for block in map(self._order, range(self.blocks.count)):
            parts = self._parted(block)
            order = map(Permutation(len(parts), self.seed, self.spec.name, "part", block), range(len(parts)))
            groups.append(map(parts.__getitem__, order))
            yield next(groups[-1])
        yield from (part for turn in zip_longest(*groups) for part in turn if part is not None)

    def sample_part(self, index: int) -> tuple[int, int, int]:
        """Return the part that `sample` takes together with an instance: number, position in it and size.

        A balance that follows the parts occurs equally often in every sample.
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
        """Return the members of a group, divided into parts that differ in the always-crossed factors only."""
        turning = [name for name in self.blocks.crossed(block) if name not in self.spec.plan.cross]
        parts: dict[tuple[Level, ...], list[int]] = {}
        for place, index in enumerate(self.blocks.members(block)):
            values = self.blocks.values(block, place)
            parts.setdefault(tuple(values[name] for name in turning), []).append(index)
        return [tuple(part) for part in parts.values()]

    def shard(self, number: int, count: int) -> InstanceSequence:
        """Return shard `number` (1 .. `count`): contiguous equal shares of the design, to within one."""
        return self[share(len(self), number, count)]

    def _key(self, block: int, place: int) -> object:
        """Return the key that distinguishes the draws of a control group."""
        if self._alone:
            return f"{block}.{place}"
        return f"{block}/{self._redrawn}" if self._redrawn else block

    def _draw(self, key: tuple[object, ...]) -> dict[str, Level]:
        """Return the nuisances of a control group; the latest group is cached."""
        known, drawn = self._drawn
        if known != key:
            drawn = {n.name: quantile(n.domain, uniform(*key, n.name)) for n in self.nuisances}
            self._drawn = (key, drawn)
        return dict(drawn)


def share(size: int, number: int, count: int) -> slice:
    """Return share `number` (1 .. `count`) of `size` items as a slice. Raises IndexError if there is no such share."""
    if not 1 <= number <= count:
        raise IndexError(f"there are shards 1 to {count}, not {number}")
    return slice(size * (number - 1) // count, size * number // count)


class InstanceSequence(Sequence[Instance]):
    """Some instances of a design, each built on access."""

    def __init__(self, design: Design, indices: range) -> None:
        self.design = design
        self.indices = indices

    def __len__(self) -> int:
        return len(self.indices)

    @overload
    def __getitem__(self, index: int) -> Instance: ...
    @overload
    def __getitem__(self, index: slice) -> InstanceSequence: ...
    def __getitem__(self, index: int | slice) -> Instance | InstanceSequence:
        """Return the instance at a position of this part, or a slice as a part."""
        picked = self.indices[index]
        return InstanceSequence(self.design, picked) if isinstance(picked, range) else self.design[picked]
