"""Arrangements of a design: factorial, balanced sample, Latin hypercube, or one factor at a time.

An arrangement maps each position 0 .. size - 1 to the rank of a combination in each column, and back.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import gcd, prod

from wmspec.compile.design.columns import Column, Spread
from wmspec.core.rng import Permutation

Ranks = tuple[int, ...]


class Factorial:
    """All combinations, the last column fastest."""

    def __init__(self, columns: Sequence[Column]) -> None:
        self._sizes = tuple(c.size for c in columns)
        self.size = prod(self._sizes)

    def ranks(self, position: int) -> Ranks:
        """Return the mixed-radix digits of the position."""
        ranks = []
        for size in reversed(self._sizes):
            position, rank = divmod(position, size)
            ranks.append(rank)
        return tuple(ranks[::-1])

    def position(self, ranks: Ranks) -> int | None:
        """Return the position that has these digits."""
        position = 0
        for size, rank in zip(self._sizes, ranks, strict=True):
            position = position * size + rank
        return position


class Listed:
    """Explicitly listed combinations."""

    def __init__(self, rows: Sequence[Ranks]) -> None:
        self._rows = tuple(rows)
        self._positions = {row: i for i, row in enumerate(self._rows)}
        self.size = len(self._rows)

    def ranks(self, position: int) -> Ranks:
        """Return row `position`."""
        return self._rows[position]

    def position(self, ranks: Ranks) -> int | None:
        """Return the number of the row with this combination, or None."""
        return self._positions.get(ranks)


class Sample:
    """`count` distinct combinations, in which each value of a column occurs equally often, to within one.

    Columns are the digits of the position, in the order of their names, so that the order of declarations does not
    matter; see `_Digit`.
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
        """Return the ranks at a position."""
        ranks = [0] * len(self._digits)
        for at, spread, digit in self._digits:
            ranks[at] = spread.rank(digit(position))
        return tuple(ranks)

    def position(self, ranks: Ranks) -> int | None:
        """Return the position of a combination, or None if it was not sampled."""
        position = 0
        for at, spread, digit in self._digits:
            value = spread.number(ranks[at])
            if value is None:
                return None
            position = digit.extended(position, value)
        return position if position < self.size else None


_MAX_CACHED_ROW = 64  # rows up to this length cache their shuffle; most digits of a sample have shorter rows


class _Digit:
    """One digit (0 .. `base` - 1) of positions 0 .. `count` - 1.

    It is a function of the position with these properties:

    - `position % below` and the digit determine `position % (below * base)`, so no two positions share all digits;
    - each value occurs equally often, to within one;
    - given the digits before it, it looks random.

    A row is `below` consecutive positions. With the digit `(row + position) % base`, a row would have each value
    equally often except for `below % base` extra values. Each row therefore starts where the extra values of the
    previous row ended. The positions of a row are shuffled; those in the unfinished last row are shuffled among
    themselves.
    """

    def __init__(self, below: int, base: int, count: int, key: tuple[object, ...]) -> None:
        self.below = below
        self.base = base
        self._extra = below % base
        self._common = gcd(self._extra, base)
        self._cut = count % below  # number of positions of a row that also occur in the unfinished last row
        self._first = Permutation(self._cut, *key, "first")
        self._second = Permutation(below - self._cut, *key, "second") if below <= count else None
        self._known = tuple(map(self._shuffled, range(below))) if below <= _MAX_CACHED_ROW else ()

    def __call__(self, position: int) -> int:
        row, column = divmod(position, self.below)
        return (self._row_start(row) + (self._known[column] if self._known else self._shuffled(column))) % self.base

    def extended(self, column: int, digit: int) -> int:
        """Return the position modulo `below * base`, given its remainder `column` modulo `below` and the digit."""
        begun = (digit - self._shuffled(column)) % self.base
        cycle, step = begun % self._common, self.base // self._common
        row = (begun - cycle) // self._common * pow(self._extra // self._common, -1, step) % step
        return column + self.below * (row + cycle * step)

    def _row_start(self, row: int) -> int:
        """Return the start of a row: after the extra values of earlier rows; one further per full round."""
        return row * self._extra + row % self.base * self._common // self.base

    def _shuffled(self, column: int) -> int:
        """Return the shuffled position of a column within a row."""
        if column < self._cut:
            return self._first(column)
        return self._cut + self._second(column - self._cut) if self._second else column


class Latin:
    """A Latin hypercube: each of `count` equal shares of a column occurs once, in random order.

    In a column with fewer combinations, each occurs equally often, to within one. (McKay, Beckman & Conover, "A
    comparison of three methods for selecting values of input variables", 1979.)
    """

    def __init__(self, columns: Sequence[Column], count: int, key: tuple[object, ...]) -> None:
        self.size = count
        self._spreads = tuple(Spread(c, count, key) for c in columns)
        self._orders = tuple(Permutation(count, *key, *sorted(c.names), "latin") for c in columns)

    def ranks(self, position: int) -> Ranks:
        """Return the ranks at a position."""
        return tuple(s.rank(o(position) % s.count) for s, o in zip(self._spreads, self._orders, strict=True))

    @cached_property
    def _positions(self) -> dict[Ranks, int]:
        return {self.ranks(position): position for position in reversed(range(self.size))}

    def position(self, ranks: Ranks) -> int | None:
        """Return the first position of a combination, or None; builds an index of all positions."""
        return self._positions.get(ranks)


#: The combinations of a design by position, as one rank for each column.
Arrangement = Factorial | Listed | Sample | Latin
