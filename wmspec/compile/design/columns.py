"""What a design chooses from: columns of numbered values, for factors that are tied together or stand alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import chain
from typing import Protocol

from wmspec.compile.design.levels import Level, quantile
from wmspec.core.rng import Permutation, bits, uniform
from wmspec.lang.check.ir.ir import Factor

#: Up to so many allowed combinations of tied factors are put in an order in which every beginning is balanced.
MOST_BALANCED = 128
#: Up to so many combinations are kept in order; of more, each is worked out when it is asked for.
MOST_LISTED = 4096


class Column(Protocol):
    """One or more factors with `size` numbered combinations of values."""

    @property
    def names(self) -> tuple[str, ...]:
        """The factors."""

    @property
    def size(self) -> int:
        """How many combinations there are."""

    def values(self, rank: int) -> tuple[Level, ...]:
        """Combination number `rank`."""

    def rank(self, values: Sequence[Level]) -> int | None:
        """The number of a combination; None if it is not one of these."""


@dataclass(frozen=True)
class Free:
    """A factor that nothing ties to another: all its values."""

    name: str
    domain: tuple[Level, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The factor."""
        return (self.name,)

    @property
    def size(self) -> int:
        """How many values it has."""
        return len(self.domain)

    def values(self, rank: int) -> tuple[Level, ...]:
        """Value number `rank`."""
        return (self.domain[rank],)

    @cached_property
    def _ranks(self) -> dict[Level, int]:
        return {value: rank for rank, value in enumerate(self.domain)}

    def rank(self, values: Sequence[Level]) -> int | None:
        """The number of a value; None if the factor does not have it."""
        return self._ranks.get(values[0])


@dataclass(frozen=True)
class Strata:
    """A continuous factor cut into `size` equally likely strata, with one value drawn from each."""

    factor: Factor
    size: int
    key: tuple[object, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The factor."""
        return (self.factor.name,)

    def values(self, rank: int) -> tuple[Level, ...]:
        """The value in stratum `rank`."""
        share = (rank + uniform(*self.key, self.factor.name, rank)) / self.size
        return (quantile(self.factor.domain, share),)

    @cached_property
    def _ranks(self) -> dict[tuple[Level, ...], int]:
        return {self.values(rank): rank for rank in range(self.size)}

    def rank(self, values: Sequence[Level]) -> int | None:
        """The stratum of a value; None if it is not the one drawn there."""
        return self._ranks.get(tuple(values))


class Spread:
    """Some of a column's combinations in a random order: number 0, 1, ... up to `count`, as even as they can be.

    Of more than `count` combinations one is drawn from each of `count` equal shares of them; fewer are all taken.
    """

    def __init__(self, column: Column, count: int, key: tuple[object, ...]) -> None:
        self.column = column
        self.count = min(column.size, count)
        self._key = (*key, *sorted(column.names))
        if column.size > count:
            self.rank: Callable[[int], int] = self._drawn
            self.number: Callable[[int], int | None] = self._share
        else:
            permutation = Permutation(column.size, *self._key, "order")
            self.rank, self.number = permutation, permutation.inverse
            if column.size <= MOST_LISTED:
                order = balanced(column, self._key)
                self.rank = order.__getitem__
                self.number = {rank: number for number, rank in enumerate(order)}.get

    def _drawn(self, number: int) -> int:
        first = number * self.column.size // self.count
        after = (number + 1) * self.column.size // self.count
        return first + bits(*self._key, number) % (after - first)

    def _share(self, rank: int) -> int | None:
        number = ((rank + 1) * self.count - 1) // self.column.size
        return number if self._drawn(number) == rank else None


def balanced(column: Column, key: tuple[object, ...]) -> list[int]:
    """All ranks of a column in a random order; of factors that are tied, one in which every beginning is balanced."""
    if len(column.names) > 1 and column.size <= MOST_BALANCED:
        return _evened(column, key)
    return list(map(Permutation(column.size, *key, "order"), range(column.size)))


def _evened(column: Column, key: tuple[object, ...]) -> list[int]:
    """The ranks of a column in an order in which each value of each factor comes at even intervals, else at random."""
    cells: dict[tuple[int, Level], int] = {}
    ranks = (enumerate(column.values(rank)) for rank in range(column.size))
    rows = tuple(tuple(cells.setdefault(cell, len(cells)) for cell in row) for row in ranks)
    return list(_spread_evenly(rows, key))


@lru_cache(maxsize=256)  # a dry run needs the same few orders dozens of times
def _spread_evenly(rows: tuple[tuple[int, ...], ...], key: tuple[object, ...]) -> tuple[int, ...]:
    """The numbers of rows in an order in which each cell comes at even intervals; ties depend on the key."""
    total = Counter(chain.from_iterable(rows))
    due = [1 / total[cell] for cell in range(len(total))]
    taken = [0] * len(due)
    tied = {i: bits(*key, "tie", i) for i in range(len(rows))}
    left = sorted(tied, key=tied.__getitem__)  # of equals, min takes the first
    order: list[int] = []
    while left:
        chosen = min(left, key=lambda i: sum(map(due.__getitem__, rows[i])))
        left.remove(chosen)
        order.append(chosen)
        for cell in rows[chosen]:
            taken[cell] += 1
            due[cell] = (taken[cell] + 1) / total[cell]
    return tuple(order)
