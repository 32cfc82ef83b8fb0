"""Expands sets of objects, joints, actions and nuisances into the maximum number of members.

An object or joint is present, and an action happens, if its index is below `count`. All members draw nuisances.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from math import prod
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.evaluate import evaluate, subexpressions
from wmspec.lang.check.library.substitute import Substitute, TooLarge
from wmspec.lang.check.statements.factors import Factors
from wmspec.lang.check.tables.vocabulary import SETS
from wmspec.lang.check.types.types import A_NUMBER
from wmspec.lang.parse import syntax as s

#: A statement that may declare a set.
Whole = s.Block | s.Action | s.Factor
#: Maximum number of members, and of factor combinations tried to find the largest count.
MAX_MEMBERS, MAX_COMBINATIONS = 500, 10_000


class Sets:
    """Creates the members of sets and declares them."""

    def __init__(self, check: Expressions, factors: Factors, substitute: Substitute) -> None:
        self.check = check
        self.factors = factors
        self.substitute = substitute

    def members(self, whole: Whole) -> tuple[Whole, ...]:
        """Return the members of a set, none if its count is wrong; other statements are unchanged. Raises Failed."""
        if whole.count is None:
            return (whole,)
        count = self.check.value(whole.count, (A_NUMBER,), "the number of a set").expr
        largest = self._largest(whole.count, count)
        varies = constant(count) is None
        try:
            members = tuple(self._member(whole, whole.count, i, varies) for i in range(largest))
        except TooLarge:
            self.check.fail("WMS105", "this set is too large for what is in it", whole.name.span, "make it simpler")
        for member in members:
            self.check.scope.declare(member, whole.name.id)
        return members

    def _member(self, whole: Whole, count: s.Expr, i: int, varies: bool) -> Whole:
        self.substitute.count_entity()
        values = {"index": s.Number(float(i), None, whole.name.span)}
        name = s.Name(f"{whole.name.id}_{i}", whole.name.span)
        below = s.Operation("<", (values["index"], count), count.span) if varies else None
        match whole:
            case s.Factor():
                return replace(whole, name=name, domain=self.substitute.expression(whole.domain, values), count=None)
            case s.Action():
                call = self.substitute.expression(whole.call, values)
                timings = tuple(replace(t, value=self.substitute.expression(t.value, values)) for t in whole.timings)
                timings = _happens(timings, below) if below else timings
                return replace(whole, name=name, call=call, timings=timings, count=None)
        properties = tuple(self.substitute.property(p, values) for p in whole.properties)
        properties = _present(properties, below) if below else properties
        made = tuple(self.substitute.part(p, values) for p in whole.parts)
        return s.Block(SETS[whole.kind], name, properties, whole.span, whole.model, parts=made)

    def _largest(self, written: s.Expr, count: ir.Expr) -> int:
        """Return the largest count over all values of its factors."""
        numbers = list(self._numbers(written, count))
        if odd := [n for n in numbers if n != int(n)]:
            message = f"a set has a whole number of members, and this can be {odd[0]:g}"
            self.check.fail("WMS304", message, written.span, "make it whole numbers")
        if min(numbers) < 0:
            message = f"a set has no fewer than 0 members, and this can be {min(numbers):g}"
            self.check.fail("WMS304", message, written.span, "make it whole numbers from 0 on")
        if not 1 <= max(numbers) <= MAX_MEMBERS:
            message = f"this set can have {max(numbers):g} members"
            self.check.fail("WMS304", message, written.span, f"make that a number from 1 to {MAX_MEMBERS}")
        return int(max(numbers))

    def _numbers(self, written: s.Expr, count: ir.Expr) -> Iterator[float]:
        lets: dict[str, ir.Expr] = {}
        domains: dict[str, tuple[Any, ...]] = {}
        self._needs(written, count, lets, domains)
        if prod(len(d) for d in domains.values()) > MAX_COMBINATIONS:
            message = f"this number depends on too many factors; {MAX_COMBINATIONS:,} combinations is the maximum"
            self.check.fail("WMS304", message, written.span, "make it a factor of its own")
        for row in product(*domains.values()):
            try:
                yield float(evaluate(count, _Numbers(dict(zip(domains, row, strict=True)), lets)))
            except WmsError as error:
                self.check.fail("WMS304", str(error), written.span)

    def _needs(
        self, written: s.Expr, expr: ir.Expr, lets: dict[str, ir.Expr], domains: dict[str, tuple[Any, ...]]
    ) -> None:
        """Collect the `let`s and factors that a count depends on."""
        for part in subexpressions(expr):
            if isinstance(part, ir.Property | ir.Call) or part == ir.Ref(name="end"):
                message = "the number of a set can depend on factors, `let`s and numbers only"
                self.check.fail("WMS304", message, written.span)
            if not isinstance(part, ir.Ref) or part.name in lets or part.name in domains:
                continue
            declared = self.check.scope.names[part.name]
            if isinstance(declared, s.Let):
                lets[part.name] = self.factors.let(declared).value
                self._needs(written, lets[part.name], lets, domains)
            elif isinstance(declared, s.Factor):
                domain = self.factors.factor(declared).domain
                if not isinstance(domain, ir.Choices):
                    message = (
                        f"`{part.name}` can have any value between others, and a set has a whole number of members"
                    )
                    self.check.fail("WMS304", message, written.span, "make it a list or a range with steps")
                domains[part.name] = domain.values


class _Numbers:
    """Environment for `evaluate` with factors and `let`s only."""

    def __init__(self, factors: dict[str, Any], lets: dict[str, ir.Expr]) -> None:
        self._known = factors
        self._lets = lets

    def ref(self, name: str) -> Any:
        if name not in self._known:
            self._known[name] = evaluate(self._lets[name], self)
        return self._known[name]

    def property(self, *_: Any, **_options: Any) -> Any:
        raise AssertionError("a set's number has no properties in it")

    call = under = property


def _present(properties: tuple[s.Property, ...], below: s.Expr) -> tuple[s.Property, ...]:
    """Return the properties with `present` where `below` holds, combined with a written `present`."""
    present = next((p for p in properties if p.name.id == "present"), None)
    there = s.Operation("and", (below, present.value), present.value.span) if present is not None else below
    name = s.Name("present", below.span)
    return *(p for p in properties if p is not present), s.Property(name, there, None, below.span)


def _happens(timings: tuple[s.Timing, ...], below: s.Expr) -> tuple[s.Timing, ...]:
    """Return the timings with `when` limited to members where `below` holds."""
    when = next((t for t in timings if t.kind == "when"), None)
    if when is None:
        return *timings, s.Timing("when", below, below.span)
    both = s.Operation("and", (below, when.value), when.value.span)
    return tuple(replace(t, value=both) if t is when else t for t in timings)
