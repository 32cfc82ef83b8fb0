"""Control groups ("blocks"): instances that share all draws and differ in the crossed factors only.

Either the whole plan is one block, repeated `repeat` times. Or there are many small groups: each crosses a few factors,
and all other factors are drawn once per group.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from math import prod

from wmspec.compile.design.columns import MAX_LISTED, Column, balanced_order
from wmspec.compile.design.levels import Level
from wmspec.compile.design.plans import Arrangement
from wmspec.core.rng import Permutation


class MemberOrder:
    """Permutes the members of every group in its own way, in constant memory.

    The position of a member in its group and its place in the arrangement of the group correspond one to one.
    """

    def __init__(self, *key: object) -> None:
        self._key = key
        self._latest: tuple[tuple[int, int], Permutation] = ((-1, 0), Permutation(0))

    def place(self, group: int, size: int, position: int) -> int:
        """Return the place in the arrangement of the member at a position of a group of `size` members."""
        return self._of(group, size)(position)

    def position(self, group: int, size: int, place: int) -> int:
        """Return the position of the member at a place in the arrangement."""
        return self._of(group, size).inverse(place)

    def _of(self, group: int, size: int) -> Permutation:
        """Return the permutation of a group; the latest one is cached."""
        known, permutation = self._latest
        if known != (group, size):
            permutation = Permutation(size, *self._key, group)
            self._latest = ((group, size), permutation)
        return permutation


#: Maximum number of groups of unequal size; their start indices are listed in memory.
MAX_UNEQUAL = 100_000


@dataclass(frozen=True)
class RepeatedPlan:
    """One plan, repeated `count` times, each time in its own order."""

    columns: tuple[Column, ...]
    plan: Arrangement
    count: int
    order: MemberOrder

    @property
    def size(self) -> int:
        """Number of instances in all repetitions."""
        return self.plan.size * self.count

    def locate(self, index: int) -> tuple[int, int]:
        """Return the repetition of an instance and its position in the plan."""
        return divmod(index, self.plan.size)

    def values(self, block: int, place: int) -> dict[str, Level]:
        """Return the values of all factors at a position of a repetition."""
        picked: dict[str, Level] = {}
        ranks = self.plan.ranks(self.order.place(block, self.plan.size, place))
        for column, rank in zip(self.columns, ranks, strict=True):
            picked.update(zip(column.names, column.values(rank), strict=True))
        return picked

    def index(self, values: Mapping[str, Level], block: int) -> int | None:
        """Return the index of a combination in a repetition, or None if the plan omits it."""
        ranks = []
        for column in self.columns:
            rank = column.rank([values[n] for n in column.names])
            if rank is None:
                return None
            ranks.append(rank)
        place = self.plan.position(tuple(ranks))
        if place is None:
            return None
        return block * self.plan.size + self.order.position(block, self.plan.size, place)

    def members(self, block: int) -> range:
        """Return the indices of the instances of a repetition."""
        return range(block * self.plan.size, (block + 1) * self.plan.size)

    def crossed(self, block: int) -> tuple[str, ...]:  # noqa: ARG002
        """Return all factors."""
        return tuple(sorted(name for column in self.columns for name in column.names))

    def locate_turn(self, block: int) -> tuple[int, int]:
        """Return turn 0, the only one, and the number of the repetition."""
        return 0, block

    def in_turn(self, turn: int, number: int) -> int:  # noqa: ARG002
        """Return the number of the repetition."""
        return number


class Groups:
    """`count` groups, each of which crosses the factors `cross` and one of `turns`.

    A round has one group of each turn, in random order. Every other factor has one value per group. Over the groups of
    a turn, its values occur equally often, to within one; for factors tied by conditions, this holds for their allowed
    combinations. A draw depends on the group's number, the turn and the factor only: adding groups or factors leaves
    existing draws unchanged. Members of a group are in random order.

    Raises TooManyTied if conditions tie the crossed factors to too many others.
    """

    def __init__(
        self, columns: Sequence[Column], cross: Sequence[str], turns: Sequence[str], count: int, key: tuple[object, ...]
    ) -> None:
        self.count = count
        self._order, self._rounds = MemberOrder(*key, "order"), MemberOrder(*key, "turns")
        self._turns = tuple(
            _Turn(columns, (*cross, *([turn] if turn else [])), (*key, turn)) for turn in turns or ("",)
        )
        if count > MAX_UNEQUAL and any(turn.even is None for turn in self._turns):
            raise TooManyTied(max((c for c in columns if len(c.names) > 1), key=lambda c: c.size).names)

    @property
    def even(self) -> bool:
        """Whether all groups that cross the same factors have the same size."""
        return all(turn.even is not None for turn in self._turns)

    @property
    def size(self) -> int:
        """Number of members of all groups."""
        return self._before(self.count)

    def locate(self, index: int) -> tuple[int, int]:
        """Return the group of an instance and its position in the group."""
        if self._starts is not None:
            block = bisect_right(self._starts, index) - 1
            return block, index - self._starts[block]
        whole, rest = divmod(index, self._round_size)
        starts = self._round_starts(whole, len(self._turns))
        at = bisect_right(starts, rest) - 1
        return whole * len(self._turns) + at, rest - starts[at]

    def values(self, block: int, place: int) -> dict[str, Level]:
        """Return the values of all factors at a position of a group."""
        turn, number = self._turn(block)
        return turn.values(number, self._order.place(block, turn.size(number), place))

    def index(self, values: Mapping[str, Level], block: int) -> int | None:
        """Return the index of the member of a group with these values, or None."""
        turn, number = self._turn(block)
        place = turn.place(values, number)
        return None if place is None else self._before(block) + self._order.position(block, turn.size(number), place)

    def members(self, block: int) -> range:
        """Return the indices of the instances of a group."""
        turn, number = self._turn(block)
        first = self._before(block)
        return range(first, first + turn.size(number))

    def crossed(self, block: int) -> tuple[str, ...]:
        """Return the factors that vary within a group."""
        return self._turn(block)[0].crossed

    def locate_turn(self, block: int) -> tuple[int, int]:
        """Return the turn of a group, and the number of earlier groups of this turn: one in each earlier round."""
        round_, at = divmod(block, len(self._turns))
        return self._rounds.place(round_, len(self._turns), at), round_

    def in_turn(self, turn: int, number: int) -> int:
        """Return the group of a turn in a round; it may lie beyond the last group."""
        return number * len(self._turns) + self._rounds.position(number, len(self._turns), turn)

    def _turn(self, block: int) -> tuple[_Turn, int]:
        """Return the turn of a group, and the number of earlier groups with the same turn."""
        turn, number = self.locate_turn(block)
        return self._turns[turn], number

    def _before(self, block: int) -> int:
        """Return the number of instances in the groups before this one."""
        if self._starts is not None:
            return self._starts[block]
        whole, rest = divmod(block, len(self._turns))
        return whole * self._round_size + self._round_starts(whole, rest)[rest]

    @cached_property
    def _round_size(self) -> int:
        """Number of instances in a round; only for even sizes."""
        return sum(turn.even or 0 for turn in self._turns)

    def _round_starts(self, round_: int, groups: int) -> tuple[int, ...]:
        """Start of each of the first groups within a round, and the end of the last; only for even sizes."""
        turns = (self._turns[self._rounds.place(round_, len(self._turns), at)] for at in range(groups))
        return (0, *accumulate(turn.even or 0 for turn in turns))

    @cached_property
    def _starts(self) -> tuple[int, ...] | None:
        """Start index of each group and the end of the last; None if sizes are even."""
        if all(turn.even is not None for turn in self._turns):
            return None
        sizes = (turn.size(number) for turn, number in map(self._turn, range(self.count)))
        return (0, *accumulate(sizes))


#: The partition of a design into blocks, and the position of each instance in its block.
Blocks = RepeatedPlan | Groups


class TooManyTied(Exception):
    """Conditions tie crossed factors to more combinations of others than can be listed."""

    def __init__(self, names: tuple[str, ...]) -> None:
        super().__init__(", ".join(names))
        self.names = names


class _Turn:
    """The groups that cross the same factors, numbered from 0."""

    def __init__(self, columns: Sequence[Column], crossed: Sequence[str], key: tuple[object, ...]) -> None:
        self.crossed = tuple(sorted(crossed))
        self._parts = tuple(
            _GroupColumn(column, frozenset(crossed), (*key, *sorted(column.names))) for column in columns
        )
        sizes = [part.even for part in self._parts]
        #: The size of each group, or None if sizes differ.
        self.even = None if None in sizes else prod(size for size in sizes if size is not None)

    def size(self, number: int) -> int:
        """Return the number of members of group `number`."""
        return prod(len(part.choices(number)) for part in self._parts) if self.even is None else self.even

    def values(self, number: int, place: int) -> dict[str, Level]:
        """Return the values of all factors; those of the last part change fastest."""
        picked: dict[str, Level] = {}
        for part in reversed(self._parts):
            choices = part.choices(number)
            place, at = divmod(place, len(choices))
            picked.update(zip(part.column.names, part.column.values(choices[at]), strict=True))
        return picked

    def place(self, values: Mapping[str, Level], number: int) -> int | None:
        """Return the position of a combination in group `number`, or None if the group omits it."""
        place = 0
        for part in self._parts:
            choices = part.choices(number)
            rank = part.column.rank([values[name] for name in part.column.names])
            if rank is None or rank not in choices:
                return None
            place = place * len(choices) + choices.index(rank)
        return place


class _GroupColumn:
    """A column split for groups: contexts of its uncrossed factors, and the crossed combinations in each context."""

    def __init__(self, column: Column, crossed: frozenset[str], key: tuple[object, ...]) -> None:
        self.column = column
        self._key = key
        self._whole = range(column.size) if crossed.issuperset(column.names) else None
        self._single = crossed.isdisjoint(column.names)
        self._contexts: tuple[tuple[int, ...], ...] = ()
        if self._whole is None and not self._single:
            if column.size > MAX_LISTED:
                raise TooManyTied(column.names)
            self._contexts = _contexts(column, crossed)

    @property
    def even(self) -> int | None:
        """The number of crossed combinations, if it is the same in all contexts; else None."""
        if self._whole is not None:
            return len(self._whole)
        counts = {1} if self._single else {len(ranks) for ranks in self._contexts}
        return counts.pop() if len(counts) == 1 else None

    def choices(self, number: int) -> Sequence[int]:
        """Return the ranks of the combinations in group `number`."""
        if self._whole is not None:
            return self._whole
        size = self.column.size if self._single else len(self._contexts)
        lap, at = divmod(number, size)
        drawn = self._order(lap)[at] if size <= MAX_LISTED else Permutation(size, *self._key, lap)(at)
        return (drawn,) if self._single else self._contexts[drawn]

    def _order(self, lap: int) -> Sequence[int]:
        """Return the order of contexts in a lap of groups; the latest lap is cached."""
        known, order = self._known
        if known != lap:
            key = (*self._key, lap)
            if self._single:
                order = balanced_order(self.column, key)
            else:
                order = list(map(Permutation(len(self._contexts), *key), range(len(self._contexts))))
            self._known = (lap, order)
        return order

    _known: tuple[int, Sequence[int]] = (-1, ())


def _contexts(column: Column, crossed: frozenset[str]) -> tuple[tuple[int, ...], ...]:
    """Return the ranks of a column, grouped by equal values of its uncrossed factors."""
    ranks: dict[tuple[Level, ...], list[int]] = {}
    for rank in range(column.size):
        values = zip(column.names, column.values(rank), strict=True)
        ranks.setdefault(tuple(value for name, value in values if name not in crossed), []).append(rank)
    return tuple(map(tuple, ranks.values()))
