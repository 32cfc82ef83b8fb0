"""Columns of a design: numbered combinations of one factor, or of several factors tied by conditions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import chain

from wmspec.compile.design.constraint_chain import Chain
from wmspec.compile.design.levels import Level, quantile
from wmspec.core.rng import Permutation, bits, uniform
from wmspec.lang.check.ir.ir import Factor

#: Maximum number of allowed combinations for which an order with balanced prefixes is computed.
MAX_BALANCED = 128
#: Maximum number of combinations kept in a list; larger columns compute each one on demand.
MAX_LISTED = 4096


@dataclass(frozen=True)
class FreeFactor:
    """A factor that no condition ties to another, with all its values."""

    name: str
    domain: tuple[Level, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The name of the factor."""
        return (self.name,)

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.domain)

    def values(self, rank: int) -> tuple[Level, ...]:
        """Return value number `rank`."""
        return (self.domain[rank],)

    @cached_property
    def _ranks(self) -> dict[Level, int]:
        return {value: rank for rank, value in enumerate(self.domain)}

    def rank(self, values: Sequence[Level]) -> int | None:
        """Return the number of a value, or None if the factor lacks it."""
        return self._ranks.get(values[0])


@dataclass(frozen=True)
class Strata:
    """A continuous factor divided into `size` equally likely strata, with one value drawn from each."""

    factor: Factor
    size: int
    key: tuple[object, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The name of the factor."""
        return (self.factor.name,)

    def values(self, rank: int) -> tuple[Level, ...]:
        """Return the value drawn in stratum `rank`."""
        share = (rank + uniform(*self.key, self.factor.name, rank)) / self.size
        return (quantile(self.factor.domain, share),)

    @cached_property
    def _ranks(self) -> dict[tuple[Level, ...], int]:
        return {self.values(rank): rank for rank in range(self.size)}

    def rank(self, values: Sequence[Level]) -> int | None:
        """Return the stratum of a value, or None if it is not the value drawn there."""
        return self._ranks.get(tuple(values))


#: One or more factors with `size` numbered combinations of values.
Column = Chain | FreeFactor | Strata


class Spread:
    """Up to `count` combinations of a column in a random order, as evenly spread as possible.

    A column with more than `count` combinations is divided into `count` equal shares, and one combination is drawn from
    each. A smaller column is taken whole.
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
            if column.size <= MAX_LISTED:
                order = balanced_order(column, self._key)
                self.rank = order.__getitem__
                self.number = {rank: number for number, rank in enumerate(order)}.get

    def _drawn(self, number: int) -> int:
        first = number * self.column.size // self.count
        after = (number + 1) * self.column.size // self.count
        return first + bits(*self._key, number) % (after - first)

    def _share(self, rank: int) -> int | None:
        number = ((rank + 1) * self.count - 1) // self.column.size
        return number if self._drawn(number) == rank else None


def balanced_order(column: Column, key: tuple[object, ...]) -> list[int]:
    """Return all ranks of a column in random order; prefixes are balanced if several factors are tied."""
    if len(column.names) > 1 and column.size <= MAX_BALANCED:
        return _even_order(column, key)
    return list(map(Permutation(column.size, *key, "order"), range(column.size)))


def _even_order(column: Column, key: tuple[object, ...]) -> list[int]:
    """Return the ranks in an order that spaces each value of each factor evenly, otherwise random."""
    cells: dict[tuple[int, Level], int] = {}
    ranks = (enumerate(column.values(rank)) for rank in range(column.size))
    rows = tuple(tuple(cells.setdefault(cell, len(cells)) for cell in row) for row in ranks)
    return list(_spread_evenly(rows, key))


@lru_cache(maxsize=256)  # a dry run uses the same few orders dozens of times
def _spread_evenly(rows: tuple[tuple[int, ...], ...], key: tuple[object, ...]) -> tuple[int, ...]:
    """Return row numbers in an order that spaces each cell evenly; ties depend on the key."""
    total = Counter(chain.from_iterable(rows))
    due = [1 / total[cell] for cell in range(len(total))]
    taken = [0] * len(due)
    tied = {i: bits(*key, "tie", i) for i in range(len(rows))}
    left = sorted(tied, key=tied.__getitem__)  # min returns the first of equal items
    order: list[int] = []
    while left:
        chosen = min(left, key=lambda i: sum(map(due.__getitem__, rows[i])))
        left.remove(chosen)
        order.append(chosen)
        for cell in rows[chosen]:
            taken[cell] += 1
            due[cell] = (taken[cell] + 1) / total[cell]
    return tuple(order)
