"""Constraints of `require`s and conditional domains: allowed combinations of the factors in each one's scope."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from typing import Any

from wmspec.compile.design.depend import dependencies
from wmspec.compile.design.levels import Level, format_levels
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import ImpossibleValue, SpecError, WmsError
from wmspec.core.places import Location
from wmspec.lang.check.ir.evaluate import Environment, evaluate
from wmspec.lang.check.ir.ir import Choices, Counterfactual, Expr, Factor, Operation, TaskSpec

#: Maximum number of combinations on which the conditions of a task are evaluated; takes about 0.5 s.
MAX_TRIED = 100_000


@dataclass(frozen=True, eq=False)
class Constraint:
    """A condition on the factors of its scope; `statement` is the index of its `require` or domain."""

    spec: TaskSpec
    statement: int
    text: str
    place: Location
    scope: tuple[str, ...]
    conditions: tuple[Expr, ...]
    domains: Mapping[str, tuple[Level, ...]]
    conditional: bool = False

    @property
    def tries(self) -> int:
        """Number of combinations to evaluate."""
        return prod(len(self.domains[name]) for name in self.scope)

    @cached_property
    def allowed(self) -> frozenset[tuple[int, ...]]:
        """The allowed combinations, as indices of the values of the factors in scope."""
        levels = product(*(range(len(self.domains[name])) for name in self.scope))
        return frozenset(at for at in levels if self._holds(at))

    def holds(self, values: Mapping[str, Level]) -> bool:
        """Whether a combination of factors is allowed."""
        return tuple([self.domains[name].index(values[name]) for name in self.scope]) in self.allowed

    def _holds(self, at: tuple[int, ...]) -> bool:
        known = {name: self.domains[name][level] for name, level in zip(self.scope, at, strict=True)}
        condition = self.conditions[at[0] if self.conditional else 0]
        try:
            return bool(evaluate(condition, _FactorEnvironment(self.spec, known)))
        except WmsError as error:
            where = format_levels(self.spec.factors, known)
            raise ImpossibleValue(f"{self.text} has no value where {where}: {error}", self.place) from None


class _FactorEnvironment:
    """An environment for conditions on factors; builds the scene only when a condition needs it."""

    def __init__(self, spec: TaskSpec, known: Mapping[str, Level]) -> None:
        self._spec = spec
        self._known = known

    @cached_property
    def _scene(self) -> Evaluator:
        return Evaluator(self._spec, self._known)

    def ref(self, name: str) -> Any:
        return self._known[name] if name in self._known else self._scene.ref(name)

    def property(self, owner: str, name: str) -> object:
        return self._scene.property(owner, name)

    def call(self, function: str, arguments: tuple[Any, ...], **options: Any) -> Any:
        return self._scene.call(function, arguments, **options)

    def under(self, change: Counterfactual) -> Environment:
        return self._scene.under(change)


def constraints(spec: TaskSpec) -> tuple[Constraint, ...]:
    """Return the constraints of a spec on its factors, one for each conjunct of an `and`.

    Raises SpecError if a condition depends on a continuous value, or if there are too many combinations to evaluate.
    """
    made = tuple(_constraints(spec))
    tries = 0
    for constraint in made:
        tries += constraint.tries
        if tries > MAX_TRIED:
            names = ", ".join(constraint.scope)
            raise SpecError(
                f"this condition ties {names} together, {constraint.tries:,} combinations to try, and {MAX_TRIED:,} "
                "are the most",
                constraint.place,
                "split it into conditions on fewer factors, joined by `and`",
                code="WMS404",
            )
    return made


def _constraints(spec: TaskSpec) -> Iterator[Constraint]:
    """Yield the constraints of `require`s, then those of conditional domains."""
    domains = {f.name: f.domain.values for f in spec.factors if not f.nuisance and isinstance(f.domain, Choices)}
    depend = dependencies(spec)
    order = [f.name for f in spec.factors]
    conditional = [f for f in spec.factors if isinstance(f.domain, Choices) and f.domain.when is not None]
    for number, require in enumerate(spec.requires):
        for condition in _conjuncts(require.condition):
            tied = depend.expression(condition) & set(order)
            scope = tuple(name for name in order if name in tied)
            _require_discrete(scope, domains, spec, require.place)
            yield Constraint(spec, number, f"`{require.text}`", require.place, scope, (condition,), domains)
    for number, factor in enumerate(conditional, start=len(spec.requires)):
        assert isinstance(factor.domain, Choices)
        when = factor.domain.when or ()
        tied = frozenset[str]().union(*(depend.expression(e) for e in when)) & set(order)
        scope = (factor.name, *(name for name in order if name in tied and name != factor.name))
        _require_discrete(scope, domains, spec, factor.place)
        text = f"the domain of `{factor.name}`"
        yield Constraint(spec, number, text, factor.place, scope, when, domains, conditional=True)


def _conjuncts(condition: Expr) -> Iterator[Expr]:
    """Yield the operands of nested `and`s."""
    if isinstance(condition, Operation) and condition.operator == "and":
        for operand in condition.operands:
            yield from _conjuncts(operand)
    else:
        yield condition


def _require_discrete(scope: tuple[str, ...], domains: Mapping[str, Any], spec: TaskSpec, place: Location) -> None:
    """Raise SpecError unless every factor in scope has discrete values."""
    for name in scope:
        if name not in domains:
            factor: Factor = next(f for f in spec.factors if f.name == name)
            what = "the nuisance" if factor.nuisance else "the interval"
            drawn = "write a condition on nuisances as an `ensure` of a question"
            remedy = drawn if factor.nuisance else "give that separate values, with `by STEP` or `in COUNT`"
            message = f"a condition on the design cannot depend on {what} `{name}`"
            raise SpecError(message, place, remedy, code="WMS407")
