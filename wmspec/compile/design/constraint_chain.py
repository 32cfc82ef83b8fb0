"""Factors tied by conditions: allowed combinations, counted and numbered without listing them."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, product
from math import prod

from wmspec.compile.design.constrain import Constraint
from wmspec.compile.design.levels import Level

#: Maximum number of combinations of a factor's values with its tied factors, summed over a group of factors.
MAX_COUNTED = 300_000


class TooManyCombinations(Exception):
    """Counting needs `combinations` combinations of the factors `names`, more than MAX_COUNTED."""

    def __init__(self, names: tuple[str, ...], combinations: int) -> None:
        super().__init__(combinations)
        self.names = names
        self.combinations = combinations


@dataclass(frozen=True)
class _Link:
    """One factor of a chain: the earlier factors that it depends on, and the values allowed for each context.

    `choices[context]` holds the indices of the allowed values, and cumulative counts of completions up to each one.
    """

    context: tuple[int, ...]
    choices: dict[tuple[int, ...], tuple[Sequence[int], Sequence[int]]]

    def completions(self, at: Sequence[int]) -> int:
        """Return the number of choices of this factor and its dependents, given the earlier values `at`."""
        reached = self.choices[tuple([at[v] for v in self.context])][1]
        return reached[-1] if reached else 0


class Chain:
    """The allowed combinations of some factors, in the order of their domains, the last factor fastest.

    Factors are eliminated from the last to the first. Each elimination leaves a table of counts over the earlier
    factors tied to it (bucket elimination: Dechter, "Bucket elimination: a unifying framework for reasoning", 1999).
    The cost grows with the number of factors tied at once, not with the number of combinations. If the order of the
    spec is too costly, factors with few ties come last, and combinations are numbered in that order.
    """

    def __init__(self, domains: dict[str, tuple[Level, ...]], constraints: Sequence[Constraint]) -> None:
        self.names = tuple(domains)
        self._values = tuple(domains.values())
        self._levels = tuple({value: i for i, value in enumerate(values)} for values in self._values)
        order = _order(tuple(map(len, self._values)), [_scope(c, self.names) for c in constraints], self.names)
        self._order = order
        self._links = _links([len(self._values[v]) for v in order], self._placed(constraints))
        self.size = prod(link.completions(()) for link in self._links if not link.context)

    def _placed(self, constraints: Sequence[Constraint]) -> list[tuple[tuple[int, ...], frozenset[tuple[int, ...]]]]:
        """Return constraints as positions of their factors in the counting order, with their allowed combinations."""
        where = {self.names[v]: position for position, v in enumerate(self._order)}
        return [(tuple(where[name] for name in c.scope), c.allowed) for c in constraints]

    def levels(self, rank: int) -> tuple[int, ...]:
        """Return combination number `rank` (0 to `size` - 1) as indices of the factors' values."""
        at: list[int] = []
        total = self.size
        for link in self._links:
            levels, reached = link.choices[tuple([at[v] for v in link.context])]
            rest = total // reached[-1]
            k = bisect_right(reached, rank // rest)
            before = reached[k - 1] if k else 0
            rank -= before * rest
            total = (reached[k] - before) * rest
            at.append(levels[k])
        by_factor = [0] * len(at)
        for v, level in zip(self._order, at, strict=True):
            by_factor[v] = level
        return tuple(by_factor)

    def values(self, rank: int) -> tuple[Level, ...]:
        """Return combination number `rank`."""
        return tuple([values[level] for values, level in zip(self._values, self.levels(rank), strict=True)])

    def rank(self, values: Sequence[Level]) -> int | None:
        """Return the number of a combination, or None if it is not allowed."""
        known = [levels.get(value) for levels, value in zip(self._levels, values, strict=True)]
        at: list[int] = []
        rank, total = 0, self.size
        for v, link in zip(self._order, self._links, strict=True):
            levels, reached = link.choices[tuple([at[u] for u in link.context])]
            level = known[v]
            k = bisect_left(levels, level) if level is not None else len(levels)
            if k == len(levels) or levels[k] != level:
                return None
            before = reached[k - 1] if k else 0
            rest = total // reached[-1]
            rank += before * rest
            total = (reached[k] - before) * rest
            at.append(levels[k])
        return rank


def _scope(constraint: Constraint, names: tuple[str, ...]) -> frozenset[int]:
    """Return the positions of the factors in a constraint's scope."""
    return frozenset(names.index(name) for name in constraint.scope)


# ---------------------------------------------------------------- the order


def _order(sizes: tuple[int, ...], scopes: Sequence[frozenset[int]], names: tuple[str, ...]) -> tuple[int, ...]:
    """Return the numbering order of factors: that of the spec, else a cheaper one. Raises TooManyCombinations."""
    written = tuple(range(len(sizes)))
    if max(_costs(written, sizes, scopes), default=0) <= MAX_COUNTED:
        return written
    cheap = _cheapest(sizes, scopes)
    costs = _costs(cheap, sizes, scopes)
    if (most := max(costs)) > MAX_COUNTED:
        raise TooManyCombinations(names, most)
    return cheap


def _costs(order: Sequence[int], sizes: Sequence[int], scopes: Sequence[frozenset[int]]) -> list[int]:
    """Return the number of combinations visited when each factor is eliminated, from the last to the first."""
    left, costs = list(scopes), []
    for v in reversed(order):
        touched = [s for s in left if v in s]
        together = frozenset({v}).union(*touched)
        costs.append(prod(sizes[u] for u in together))
        left = [s for s in left if v not in s] + [together - {v}]
    return costs


def _cheapest(sizes: Sequence[int], scopes: Sequence[frozenset[int]]) -> tuple[int, ...]:
    """Return a greedy order: eliminate the factor that is tied to the fewest combinations of others."""
    left, order = list(scopes), list[int]()
    while len(order) < len(sizes):
        reach = {v: frozenset({v}).union(*(s for s in left if v in s)) for v in range(len(sizes)) if v not in order}
        v = min(reach, key=lambda u: (prod(sizes[w] for w in reach[u]), -u))
        left = [s for s in left if v not in s] + [reach[v] - {v}]
        order.append(v)
    return tuple(reversed(order))


# ---------------------------------------------------------------- counting


def _links(sizes: Sequence[int], allowed: list[tuple[tuple[int, ...], frozenset[tuple[int, ...]]]]) -> list[_Link]:
    """Return the chain, built from its last factor to its first."""
    links: list[_Link] = []
    waiting: list[tuple[int, _Link]] = []  # links, each with the latest factor in its context
    for v in reversed(range(len(sizes))):
        conditions = [(scope, table) for scope, table in allowed if scope and max(scope) == v]
        hanging = [link for latest, link in waiting if latest == v]
        tied = {u for scope, _ in conditions for u in scope} | {u for link in hanging for u in link.context}
        context = tuple(sorted(tied - {v}))
        contexts = product(*(range(sizes[u]) for u in context))
        link = _Link(context, {at: _choices(v, at, context, sizes, conditions, hanging) for at in contexts})
        links.append(link)
        if context:
            waiting.append((context[-1], link))
    return links[::-1]


def _choices(
    v: int,
    at: tuple[int, ...],
    context: tuple[int, ...],
    sizes: Sequence[int],
    conditions: list[tuple[tuple[int, ...], frozenset[tuple[int, ...]]]],
    hanging: list[_Link],
) -> tuple[Sequence[int], Sequence[int]]:
    """Return the allowed values of factor `v` in a context, and cumulative counts of completions."""
    if not conditions and not hanging:
        return range(sizes[v]), range(1, sizes[v] + 1)
    known = [0] * (v + 1)
    for u, level in zip(context, at, strict=True):
        known[u] = level
    levels, ways = list[int](), list[int]()
    for level in range(sizes[v]):
        known[v] = level
        if all(tuple([known[u] for u in scope]) in table for scope, table in conditions):
            count = prod(link.completions(known) for link in hanging)
            if count:
                levels.append(level)
                ways.append(count)
    return levels, list(accumulate(ways))
