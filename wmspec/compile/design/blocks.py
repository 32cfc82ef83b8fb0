"""Control groups ("blocks"): the instances that share every draw, and differ in the factors that are crossed in them.

Either the whole plan is one block, made again as often as `repeat` says; or there are many small groups, in each of
which a few factors are crossed, while all others are drawn anew for each group.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from math import prod
from typing import Protocol

from wmspec.compile.design.columns import MOST_LISTED, Column, balanced
from wmspec.compile.design.levels import Level
from wmspec.compile.design.plans import Arrangement
from wmspec.core.rng import Permutation

#: More groups of unequal sizes are not counted up.
MOST_UNEQUAL = 100_000


class Blocks(Protocol):
    """Where each instance stands: its block, and its place there."""

    @property
    def count(self) -> int:
        """How many blocks there are."""

    @property
    def size(self) -> int:
        """How many instances they hold together."""

    def locate(self, index: int) -> tuple[int, int]:
        """The block of an instance, and its place in the block."""

    def values(self, block: int, place: int) -> dict[str, Level]:
        """The values of all factors."""

    def index(self, values: Mapping[str, Level], block: int) -> int | None:
        """The instance with these values in a block; None if there is none."""

    def members(self, block: int) -> range:
        """The instances of a block."""

    def crossed(self, block: int) -> tuple[str, ...]:
        """The factors that vary within a block."""


@dataclass(frozen=True)
class Repeated:
    """One plan, made `count` times."""

    columns: tuple[Column, ...]
    plan: Arrangement
    count: int

    @property
    def size(self) -> int:
        """All instances of all repetitions."""
        return self.plan.size * self.count

    def locate(self, index: int) -> tuple[int, int]:
        """One repetition after the other."""
        return divmod(index, self.plan.size)

    def values(self, block: int, place: int) -> dict[str, Level]:  # noqa: ARG002  the same in every repetition
        """What the plan has at this place."""
        picked: dict[str, Level] = {}
        for column, rank in zip(self.columns, self.plan.ranks(place), strict=True):
            picked.update(zip(column.names, column.values(rank), strict=True))
        return picked

    def index(self, values: Mapping[str, Level], block: int) -> int | None:
        """Where the plan has this combination."""
        ranks = []
        for column in self.columns:
            rank = column.rank([values[n] for n in column.names])
            if rank is None:
                return None
            ranks.append(rank)
        place = self.plan.position(tuple(ranks))
        return None if place is None else block * self.plan.size + place

    def members(self, block: int) -> range:
        """The instances of a repetition."""
        return range(block * self.plan.size, (block + 1) * self.plan.size)

    def crossed(self, block: int) -> tuple[str, ...]:  # noqa: ARG002
        """All factors."""
        return tuple(sorted(name for column in self.columns for name in column.names))


class Groups:
    """`count` groups. In each, the factors `cross` are crossed, and one of `turns`, each in its turn.

    Every other factor has one value in a group. Over the groups of a turn, each of its values comes equally often, to
    within one (of factors that conditions tie together: each combination that is allowed). What a group draws depends
    on its number, the turn and the factor, so that neither more groups nor more factors move it.

    Raises TooManyTied if conditions tie what is crossed to too much else.
    """

    def __init__(
        self, columns: Sequence[Column], cross: Sequence[str], turns: Sequence[str], count: int, key: tuple[object, ...]
    ) -> None:
        self.count = count
        self._turns = tuple(
            _Turn(columns, (*cross, *([turn] if turn else [])), (*key, turn)) for turn in turns or ("",)
        )
        if count > MOST_UNEQUAL and any(turn.even is None for turn in self._turns):
            raise TooManyTied(max((c for c in columns if len(c.names) > 1), key=lambda c: c.size).names)

    @property
    def even(self) -> bool:
        """Whether all groups in which the same factors are crossed are of one size."""
        return all(turn.even is not None for turn in self._turns)

    @property
    def size(self) -> int:
        """All members of all groups."""
        return self._before(self.count)

    def locate(self, index: int) -> tuple[int, int]:
        """The group of an instance, and its place in the group."""
        if self._starts is not None:
            block = bisect_right(self._starts, index) - 1
            return block, index - self._starts[block]
        whole, rest = divmod(index, self._round[-1])
        turn = bisect_right(self._round, rest) - 1
        return whole * len(self._turns) + turn, rest - self._round[turn]

    def values(self, block: int, place: int) -> dict[str, Level]:
        """What the group has everywhere, and what it has at this place."""
        turn, number = self._turn(block)
        return turn.values(number, place)

    def index(self, values: Mapping[str, Level], block: int) -> int | None:
        """Which member of a group has these values."""
        turn, number = self._turn(block)
        place = turn.place(values, number)
        return None if place is None else self._before(block) + place

    def members(self, block: int) -> range:
        """The instances of a group."""
        turn, number = self._turn(block)
        first = self._before(block)
        return range(first, first + turn.size(number))

    def crossed(self, block: int) -> tuple[str, ...]:
        """The factors that vary in a group."""
        return self._turn(block)[0].crossed

    def _turn(self, block: int) -> tuple[_Turn, int]:
        """Whose turn it is in a group, and how many groups before it had the same."""
        number, turn = divmod(block, len(self._turns))
        return self._turns[turn], number

    def _before(self, block: int) -> int:
        """How many instances the groups before this one hold."""
        if self._starts is not None:
            return self._starts[block]
        whole, rest = divmod(block, len(self._turns))
        return whole * self._round[-1] + self._round[rest]

    @cached_property
    def _round(self) -> tuple[int, ...]:
        """Where each turn begins within a round of all turns, and where the round ends; only if sizes are even."""
        return (0, *accumulate(turn.even or 0 for turn in self._turns))

    @cached_property
    def _starts(self) -> tuple[int, ...] | None:
        """Where each group begins, and the last ends; None where that follows from the turn alone."""
        if all(turn.even is not None for turn in self._turns):
            return None
        sizes = (turn.size(number) for turn, number in map(self._turn, range(self.count)))
        return (0, *accumulate(sizes))


class TooManyTied(Exception):
    """Conditions tie factors that are crossed to so many combinations of others that these cannot be listed."""

    def __init__(self, names: tuple[str, ...]) -> None:
        super().__init__(", ".join(names))
        self.names = names


class _Turn:
    """Groups in which the same factors are crossed, numbered from 0."""

    def __init__(self, columns: Sequence[Column], crossed: Sequence[str], key: tuple[object, ...]) -> None:
        self.crossed = tuple(sorted(crossed))
        self._parts = tuple(_Part(column, frozenset(crossed), (*key, *sorted(column.names))) for column in columns)
        sizes = [part.even for part in self._parts]
        #: The size of each group, if that is the same for all.
        self.even = None if None in sizes else prod(size for size in sizes if size is not None)

    def size(self, number: int) -> int:
        """How many members group `number` has."""
        return prod(len(part.choices(number)) for part in self._parts) if self.even is None else self.even

    def values(self, number: int, place: int) -> dict[str, Level]:
        """The values of all factors; the factors of the last part change fastest."""
        picked: dict[str, Level] = {}
        for part in reversed(self._parts):
            choices = part.choices(number)
            place, at = divmod(place, len(choices))
            picked.update(zip(part.column.names, part.column.values(choices[at]), strict=True))
        return picked

    def place(self, values: Mapping[str, Level], number: int) -> int | None:
        """Where a combination stands in group `number`; None if it does not."""
        place = 0
        for part in self._parts:
            choices = part.choices(number)
            rank = part.column.rank([values[name] for name in part.column.names])
            if rank is None or rank not in choices:
                return None
            place = place * len(choices) + choices.index(rank)
        return place


class _Part:
    """A column as groups see it: contexts, which are its factors that are not crossed, and what is crossed in each."""

    def __init__(self, column: Column, crossed: frozenset[str], key: tuple[object, ...]) -> None:
        self.column = column
        self._key = key
        self._whole = range(column.size) if crossed.issuperset(column.names) else None
        self._single = crossed.isdisjoint(column.names)
        self._contexts: tuple[tuple[int, ...], ...] = ()
        if self._whole is None and not self._single:
            if column.size > MOST_LISTED:
                raise TooManyTied(column.names)
            self._contexts = _contexts(column, crossed)

    @property
    def even(self) -> int | None:
        """How many combinations there are to cross, if they are equally many in all contexts."""
        if self._whole is not None:
            return len(self._whole)
        counts = {1} if self._single else {len(ranks) for ranks in self._contexts}
        return counts.pop() if len(counts) == 1 else None

    def choices(self, number: int) -> Sequence[int]:
        """The ranks of the combinations that group `number` has."""
        if self._whole is not None:
            return self._whole
        size = self.column.size if self._single else len(self._contexts)
        lap, at = divmod(number, size)
        drawn = self._order(lap)[at] if size <= MOST_LISTED else Permutation(size, *self._key, lap)(at)
        return (drawn,) if self._single else self._contexts[drawn]

    def _order(self, lap: int) -> Sequence[int]:
        """The contexts in the order in which the groups of a lap have them; kept until another lap is asked for."""
        known, order = self._known
        if known != lap:
            key = (*self._key, lap)
            if self._single:
                order = balanced(self.column, key)
            else:
                order = list(map(Permutation(len(self._contexts), *key), range(len(self._contexts))))
            self._known = (lap, order)
        return order

    _known: tuple[int, Sequence[int]] = (-1, ())


def _contexts(column: Column, crossed: frozenset[str]) -> tuple[tuple[int, ...], ...]:
    """The ranks of a column, put together where its factors that are not crossed have the same values."""
    ranks: dict[tuple[Level, ...], list[int]] = {}
    for rank in range(column.size):
        values = zip(column.names, column.values(rank), strict=True)
        ranks.setdefault(tuple(value for name, value in values if name not in crossed), []).append(rank)
    return tuple(map(tuple, ranks.values()))
