"""Which combinations make up a design: all, a balanced sample, a Latin hypercube, or one factor at a time.

A plan says for each position 0 .. size - 1 which combination each column has there, and where a combination stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import gcd, prod
from typing import Protocol

from wmspec.compile.design.columns import Column, Spread
from wmspec.core.rng import Permutation

Ranks = tuple[int, ...]


class Arrangement(Protocol):
    """The combinations of a design by position: of each column, in order, the number of its combination."""

    size: int

    def ranks(self, position: int) -> Ranks:
        """What stands at a position."""

    def position(self, ranks: Ranks) -> int | None:
        """Where a combination stands; None if it is not in the design."""


class Factorial:
    """All combinations, the last column fastest."""

    def __init__(self, columns: Sequence[Column]) -> None:
        self._sizes = tuple(c.size for c in columns)
        self.size = prod(self._sizes)

    def ranks(self, position: int) -> Ranks:
        """The digits of the position."""
        ranks = []
        for size in reversed(self._sizes):
            position, rank = divmod(position, size)
            ranks.append(rank)
        return tuple(ranks[::-1])

    def position(self, ranks: Ranks) -> int | None:
        """The number of these digits."""
        position = 0
        for size, rank in zip(self._sizes, ranks, strict=True):
            position = position * size + rank
        return position


class Listed:
    """Combinations that are written out."""

    def __init__(self, rows: Sequence[Ranks]) -> None:
        self._rows = tuple(rows)
        self._where = {row: i for i, row in enumerate(self._rows)}
        self.size = len(self._rows)

    def ranks(self, position: int) -> Ranks:
        """Row `position`."""
        return self._rows[position]

    def position(self, ranks: Ranks) -> int | None:
        """The row with this combination."""
        return self._where.get(ranks)


class Sample:
    """`count` different combinations, each value of a column as often as any other, to within one.

    Columns are the digits of the position, in the order of their names, so that the order of a spec's statements does
    not matter; see `_Digit`.
    """

    def __init__(self, columns: Sequence[Column], count: int, key: tuple[object, ...]) -> None:
        self.size = min(count, prod(c.size for c in columns))
        self._digits: list[tuple[int, Spread, _Digit]] = []
        below = 1
        for at in sorted(range(len(columns)), key=lambda c: min(columns[c].names)):
            spread = Spread(columns[at], self.size, key)
            digit = _Digit(below, spread.count, self.size, (*key, *sorted(columns[at].names)))
            self._digits.append((at, spread, digit))
            below *= spread.count

    def ranks(self, position: int) -> Ranks:
        """What stands at a position."""
        ranks = [0] * len(self._digits)
        for at, spread, digit in self._digits:
            ranks[at] = spread.rank(digit(position))
        return tuple(ranks)

    def position(self, ranks: Ranks) -> int | None:
        """Where a combination was sampled; None if it was not."""
        position = 0
        for at, spread, digit in self._digits:
            value = spread.number(ranks[at])
            if value is None:
                return None
            position = digit.extended(position, value)
        return position if position < self.size else None


_KNOWN = 64  # up to this length, rows are shuffled once: most digits of a sample have no longer ones


class _Digit:
    """One digit, 0 .. `base` - 1, of positions 0 .. `count` - 1.

    It is a function of the position such that

    - together with `position % below`, which the digits before it tell, it tells `position % (below * base)`: therefore
      no two positions have the same digits;
    - each of its values occurs as often as any other, to within one;
    - given the digits before it, it looks random.

    A row is `below` positions in succession. Were the digit `(row + position) % base`, a row would have each value
    equally often but for `below % base` extra ones. So each row is begun where the extra values of the last one ended,
    and its positions are shuffled; those of the unfinished last row among themselves.
    """

    def __init__(self, below: int, base: int, count: int, key: tuple[object, ...]) -> None:
        self.below = below
        self.base = base
        self._extra = below % base
        self._common = gcd(self._extra, base)
        self._cut = count % below  # this many positions of a row also occur in the unfinished last one
        self._first = Permutation(self._cut, *key, "first")
        self._second = Permutation(below - self._cut, *key, "second") if below <= count else None
        self._known = tuple(map(self._shuffled, range(below))) if below <= _KNOWN else ()

    def __call__(self, position: int) -> int:
        row, column = divmod(position, self.below)
        return (self._begun(row) + (self._known[column] if self._known else self._shuffled(column))) % self.base

    def extended(self, column: int, digit: int) -> int:
        """The position, modulo `below * base`, of which `column` is the remainder modulo `below`."""
        begun = (digit - self._shuffled(column)) % self.base
        cycle, step = begun % self._common, self.base // self._common
        row = (begun - cycle) // self._common * pow(self._extra // self._common, -1, step) % step
        return column + self.below * (row + cycle * step)

    def _begun(self, row: int) -> int:
        """Where a row begins: after the extra values of the rows before; a round later once those meet their start."""
        return row * self._extra + row % self.base * self._common // self.base

    def _shuffled(self, column: int) -> int:
        if column < self._cut:
            return self._first(column)
        return self._cut + self._second(column - self._cut) if self._second else column


class Latin:
    """A Latin hypercube: of each column, each of `count` equal shares once, in random order.

    A column with fewer combinations than that has each as often as any other, to within one.
    (McKay, Beckman & Conover, "A comparison of three methods for selecting values of input variables", 1979.)
    """

    def __init__(self, columns: Sequence[Column], count: int, key: tuple[object, ...]) -> None:
        self.size = count
        self._spreads = tuple(Spread(c, count, key) for c in columns)
        self._orders = tuple(Permutation(count, *key, *sorted(c.names), "latin") for c in columns)

    def ranks(self, position: int) -> Ranks:
        """What stands at a position."""
        return tuple(s.rank(o(position) % s.count) for s, o in zip(self._spreads, self._orders, strict=True))

    @cached_property
    def _where(self) -> dict[Ranks, int]:
        return {self.ranks(position): position for position in reversed(range(self.size))}

    def position(self, ranks: Ranks) -> int | None:
        """Where a combination stands first; every one has to be looked at to tell."""
        return self._where.get(ranks)
