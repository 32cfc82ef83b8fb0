"""The design of a task: all its instances, each built from its index alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from typing import Any

from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Choices, Factor, Interval, Require, TaskSpec
from wmspec.design.depend import Dependencies
from wmspec.design.draws import bits, permuted, uniform
from wmspec.design.values import Values
from wmspec.errors import WmsError

#: The most combinations of factors tied together by `require`s that are tried, for all of these: about a second.
MOST_TRIED = 200_000

Setting = bool | float | str


@dataclass(frozen=True)
class Instance:
    """One instance: its index, the repetition (block) it belongs to, and the value of every factor and nuisance."""

    index: int
    block: int
    factors: dict[str, Setting]
    nuisances: dict[str, Setting]

    @property
    def values(self) -> dict[str, Setting]:
        """Factors and nuisances together."""
        return self.factors | self.nuisances


@dataclass(frozen=True)
class _Group:
    """Factors tied together by `require`s, and their allowed combinations in the order of their domains."""

    names: tuple[str, ...]
    rows: tuple[tuple[Setting, ...], ...]

    @cached_property
    def index(self) -> dict[tuple[Setting, ...], int]:
        return {row: i for i, row in enumerate(self.rows)}


class Design:
    """The full factorial of a task's factors without what its `require`s exclude, `repeat`ed as blocks.

    Nuisances are drawn once per block, so that instances of a block differ in factors alone. Indices count blocks
    first, then factors in the order of the spec, the last one fastest.
    """

    def __init__(self, spec: TaskSpec, seed: int = 0) -> None:
        self.spec = spec
        self.seed = seed
        self.factors = tuple(f for f in spec.factors if not f.nuisance)
        self.nuisances = tuple(f for f in spec.factors if f.nuisance)
        self._groups = tuple(_groups(spec, self.factors))
        self.block_size = prod(len(g.rows) for g in self._groups)

    def __len__(self) -> int:
        return self.block_size * self.spec.repeat

    def __getitem__(self, index: int) -> Instance:
        """Instance `index`; O(1) in the size of the design. Raises IndexError outside 0..len-1."""
        if not 0 <= index < len(self):
            raise IndexError(f"{self.spec.name} has instances 0 to {len(self) - 1}, not {index}")
        block, rest = divmod(index, self.block_size)
        picked: dict[str, Setting] = {}
        for group in reversed(self._groups):
            rest, row = divmod(rest, len(group.rows))
            picked |= zip(group.names, group.rows[row], strict=True)
        factors = {f.name: picked[f.name] for f in self.factors}
        return Instance(index, block, factors, {n.name: self._draw(n, block) for n in self.nuisances})

    def __iter__(self) -> Iterator[Instance]:
        return (self[i] for i in range(len(self)))

    def index(self, factors: dict[str, Setting], block: int = 0) -> int | None:
        """The index of a combination; None if a `require` excludes it."""
        index = block
        for group in self._groups:
            row = group.index.get(tuple(factors[n] for n in group.names))
            if row is None:
                return None
            index = index * len(group.rows) + row
        return index

    def neighbours(self, index: int, factor: str) -> tuple[int, ...]:
        """The indices of the instances that differ from this one in one factor alone."""
        here = self[index]
        found = []
        for value in _choices(next(f for f in self.factors if f.name == factor)):
            other = self.index(here.factors | {factor: value}, here.block)
            if other is not None and other != index:
                found.append(other)
        return tuple(found)

    def sample(self, count: int) -> tuple[int, ...]:
        """`count` different indices in a random order that depends on the seed alone; all if there are fewer."""
        n = len(self)
        return tuple(permuted(i, n, self.seed, self.spec.name, "sample") for i in range(min(count, n)))

    def _draw(self, nuisance: Factor, block: int) -> Setting:
        key = (self.seed, self.spec.name, block, nuisance.name)
        match nuisance.domain:
            case Interval(low=low, high=high):
                return low + (high - low) * uniform(*key)
            case Choices(values=values):
                return values[bits(*key) % len(values)]


def _choices(factor: Factor) -> tuple[Setting, ...]:
    assert isinstance(factor.domain, Choices)
    return factor.domain.values


def _groups(spec: TaskSpec, factors: tuple[Factor, ...]) -> Iterator[_Group]:
    """The factors in groups that no `require` ties to another, each with its allowed rows."""
    names = {f.name for f in factors}
    depend = Dependencies(spec)
    ties = [(r, depend.expression(r.condition) & {f.name for f in spec.factors}) for r in spec.requires]
    for require, tied in ties:
        if tied - names:
            raise WmsError(
                f"{require.place}: `require` can depend on factors, not on the nuisance `{min(tied - names)}`"
            )
    placed: set[str] = set()
    for factor in factors:
        if factor.name in placed:
            continue
        members = _closure({factor.name}, [t for _, t in ties])
        placed |= members
        group = tuple(f for f in factors if f.name in members)
        yield _allowed(spec, group, [r for r, t in ties if t & members])
    constant = [r for r, tied in ties if not tied]
    if constant:
        _allowed(spec, (), constant)


def _closure(members: set[str], ties: list[frozenset[str]]) -> set[str]:
    while True:
        wider = members.union(*(t for t in ties if t & members))
        if wider == members:
            return members
        members = wider


def _allowed(spec: TaskSpec, group: tuple[Factor, ...], requires: list[Require]) -> _Group:
    names = tuple(f.name for f in group)
    size = prod(len(_choices(f)) for f in group)
    if (tries := size * len(requires)) > MOST_TRIED:
        raise WmsError(
            f"{requires[0].place}: this `require` ties {', '.join(names)} together, {tries:,} combinations to try, "
            f"and {MOST_TRIED:,} are the most; split it into conditions on fewer factors"
        )
    rows = tuple(row for row in product(*(_choices(f) for f in group)) if _holds(spec, names, row, requires))
    if not rows:
        places = "; ".join(f"{r.place}: {r.text}" for r in requires)
        raise WmsError(f"no combination of {', '.join(names) or 'values'} meets every `require`: {places}")
    return _Group(names, rows)


def _holds(spec: TaskSpec, names: tuple[str, ...], row: tuple[Any, ...], requires: list[Require]) -> bool:
    if not requires:
        return True
    values = Values(spec, dict(zip(names, row, strict=True)))
    return all(evaluate(r.condition, values) for r in requires)
