"""Checks expressions: resolves names, converts units to SI and infers types.

`Expressions` holds the state of a task. Each sort of expression has its own module: names, members, calls, operators,
lists.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NoReturn

from wmspec.core.diagnostics import Note, Remedy, Report
from wmspec.core.places import Source, Span
from wmspec.lang.check.expressions import calls, foreign_values, lists, members, names, operators, what_ifs
from wmspec.lang.check.expressions.libraries import library_declaring
from wmspec.lang.check.expressions.scope import Scope
from wmspec.lang.check.expressions.typed import ZERO, Failed, Typed, constant, example, fits
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import PropertySpec
from wmspec.lang.check.types import units
from wmspec.lang.check.types.types import (
    A_NUMBER,
    DIRECTION,
    OBJECT,
    TEXT,
    TRUTH,
    Quantity,
    Type,
    Vector,
    article,
    either,
)
from wmspec.lang.check.types.units import NUMBER, Dimension
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.parser import parse_expression

__all__ = ["ZERO", "Expressions", "Failed", "Typed", "constant", "fits"]

#: Maximum nesting of expressions, including those behind names: evaluation is recursive.
MAX_DEPTH = 120


class Expressions:
    """Checks the expressions of one task. Declarations are checked lazily, in any order.

    `unknown` holds the undefined names that were reported; the variants of a task share it.
    """

    def __init__(self, scope: Scope, report: Report, unknown: set[str]) -> None:
        self.scope = scope
        self.report = report
        self.subject: ir.Expr | None = None  # the acting object, inside an action's arguments
        self._unknown = unknown
        self.tainted: set[str] = set()
        """Named values that may be wrong themselves: their type mismatches are not reported again."""
        self._reported: set[Span] = set()
        """Library arguments of a wrong type, each reported once."""
        self.measured = False  # whether measured functions are allowed
        self._known: dict[tuple[str, str], Typed | None] = {}
        self._open: list[tuple[tuple[str, str], Span]] = []
        self._depth = self._deepest = 0
        self._height: dict[tuple[str, str], int] = {}
        self.words: set[tuple[str, int]] = set()
        """Where declared names are words of the language: file and offset."""
        self.imagining = False  # whether this is inside a what-if
        self.domain_of: Callable[[s.Factor], Type]  # set by `Factors`, which checks domains
        self.change_of: Callable[[s.Change], ir.Counterfactual]  # set by `Counterfactuals`, which checks changes

    def value(self, e: s.Expr, expected: tuple[Type, ...], what: str) -> Typed:
        """Check an expression that must have one of the expected types. `what` names the place in messages."""
        typed = self.infer(e, expected)
        for kind in expected:
            if fits(typed.type, kind):
                return Typed(typed.expr, kind)
        self.type_mismatch(e, typed.type, expected, what)

    def infer(self, e: s.Expr, expected: tuple[Type, ...] = ()) -> Typed:
        """Check an expression of any type; the expected types resolve bare words and improve suggestions."""
        self._depth += 1
        try:
            self._deepen(0, e.span)
            return _CHECKS[type(e)](self, e, expected)
        finally:
            self._depth -= 1

    def all_of(self, e: s.Name, declared: s.Action | s.Factor) -> Typed:
        """Return all members of a set of actions or nuisances."""
        return members.all_of(self, e, declared)

    def measuring(self, e: s.Expr, expected: tuple[Type, ...] = (), what: str = "") -> Typed:
        """Check an expression that may contain measured functions; of any type if none is expected."""
        before, self.measured = self.measured, True
        try:
            return self.value(e, expected, what) if expected else self.infer(e)
        finally:
            self.measured = before

    def bounds(self, expr: ir.Expr, slot: PropertySpec, span: Span, what: str) -> None:
        """Report a constant, or a component of a point or size, outside the bounds of its slot."""
        for part in expr.items if isinstance(expr, ir.Items) else (expr,):
            value = constant(part)
            if value is not None and (reason := slot.violation(value)):
                self.fail("WMS304", f"{what} must be {reason}", span)
            if slot.among and isinstance(part, ir.Value) and part.value not in slot.among:
                self.fail("WMS304", f"{what} must be {' or '.join(f'`{word}`' for word in slot.among)}", span)

    def fail(self, code: str, message: str, span: Span, help: str = "", notes: tuple[Note, ...] = ()) -> NoReturn:
        """Report an error and raise `Failed`."""
        self.report.add(code, message, span, help, notes)
        raise Failed

    def unknown(self, e: s.Name, message: str, help: str, code: str = "WMS201") -> NoReturn:
        """Report an undefined name: each once, and none where declarations may be missing."""
        doubled = self.scope.has_duplicates and "did you mean" not in help  # one of the duplicates may have this name
        if not e.id or not self.scope.whole or doubled or e.id in self._unknown:
            raise Failed
        self._unknown.add(e.id)
        if self.scope.alone and "did you mean" not in help:
            library, brought = library_declaring(self.scope.undeclared_names())
            if e.id in brought:
                self._unknown |= brought
                self.fail(code, message, e.span, f"write `use {library}` above, which has it")
        close = self.scope.names.get(help.partition("did you mean `")[2].partition("`")[0])
        near = close is not None and close.name.span.source is e.span.source
        notes = (Note("it is declared here", close.name.span),) if close is not None and near else ()
        self.fail(code, message, e.span, help, notes)

    def type_mismatch(
        self, e: s.Expr, actual: Type, expected: tuple[Type, ...], what: str, beside: s.Expr | None = None
    ) -> NoReturn:
        """Report a value of the wrong type, possibly caused by the expression `beside` it.

        Where a named value is involved, its declaration may be the error; each is reported once.
        """
        span = e.span
        expected_types = either([article(str(k)) for k in expected])
        examples = [f"`{example(k)}`" for k in expected[:2] if example(k)]
        quantities = isinstance(actual, Quantity | Vector) and isinstance(expected[0], Quantity | Vector)
        help = f"write something like {' or '.join(examples)}" if examples else ""
        if A_NUMBER in expected and isinstance(actual, Quantity) and isinstance(e, s.Operation):
            help = f"divide it by its unit, as in `({span.text}) / 1 {actual.dimension.symbol}`"
        help = foreign_values.remedy(e, expected) or help
        if isinstance(e, s.Text) and e.value in names.names_of_types(self, expected):
            help = Remedy.of(f"write `{e.value}`, without quotes", span.text, e.value)
        if actual == OBJECT and DIRECTION in expected:
            help = f"write `toward({span.text})`"
        elif isinstance(e, s.Name):
            help = names.suggest_replacement(self, e, expected) or help
        shown = "a bare 0" if actual == Quantity(ZERO) else article(str(actual))
        message = f"{what} expects {expected_types}, found {shown}"
        if (
            isinstance(e, s.Name)
            and names.may_be_undeclared_name(self, e, actual)
            and set(expected) & set(names.BLOCKS.values())
        ):
            self.unknown(e, message, help, "WMS302")
        written = s.nodes((e, beside), s.Name)
        named = {n.id: d for n in written if isinstance(d := self.scope.names.get(n.id), s.Let | s.Factor)}
        if named.keys() & self.tainted:
            raise Failed
        self.tainted |= named.keys()
        own = (d for d in named.values() if d.name.span.source is span.source)
        notes = tuple(Note(f"`{d.name.id}` is declared here", d.name.span) for d in own)
        code = "WMS301" if quantities else "WMS302"
        numbers = s.nodes((e, beside), s.Number)
        if (given := next((n for n in numbers if n.span.source is not span.source), None)) is not None:
            if given.span in self._reported:
                raise Failed
            self._reported.add(given.span)
            self.fail(code, f"where this is used, {message}", given.span, "", (Note("it is used here", span),))
        self.fail(code, message, span, help, notes[:2])

    def number(self, e: s.Number, expected: tuple[Type, ...]) -> Typed:
        """Check a number with or without a unit."""
        scale, dimension = self.unit(e.unit, e.span, expected) if e.unit else (1.0, NUMBER)
        if not math.isfinite(e.value * scale):
            self.fail("WMS304", "this number is too large", e.span)
        if e.value == 0 and e.unit is None:
            dimension = ZERO
        return Typed(ir.Value(value=units.convert(e.value, scale)), Quantity(dimension))

    def unit(self, unit: str, span: Span, expected: tuple[Type, ...] = ()) -> tuple[float, Dimension]:
        """Return the SI value and dimension of a unit."""
        try:
            return units.parse_unit(unit)
        except units.UnknownUnit as error:
            dimensions = [kind.dimension for kind in expected if isinstance(kind, Quantity | Vector)]
            help = units.remedy(str(error), span.text, dimensions)
            self.fail("WMS103", f"unknown unit `{error}`", span, help)

    def memoized(self, key: tuple[str, str], span: Span, make: Callable[[], Typed]) -> Typed:
        """Check a declaration on first use; a cycle of declarations is an error."""
        if any(key == k for k, _ in self._open):
            notes = tuple(Note(f"`{'.'.join(k)}` needs this", where) for k, where in self._open[1:])
            self._known[key] = None
            self.fail("WMS209", "this value depends on itself", span, "break the cycle with a constant", notes)
        if key not in self._known:
            self._known[key] = self._evaluated(key, span, make)
        known = self._known[key]
        if known is None:
            raise Failed
        self._deepen(self._height[key], span)
        return known

    def _evaluated(self, key: tuple[str, str], span: Span, make: Callable[[], Typed]) -> Typed | None:
        """Check a declaration independently of the action or answer that refers to it."""
        before = self.subject, self.measured, self._deepest, self.imagining
        self.subject, self.measured, self._deepest, self.imagining = None, False, self._depth, False
        self._open.append((key, span))
        self._depth += 1
        try:
            self._deepen(0, span)
            return make()
        except Failed:
            return None
        finally:
            self._depth -= 1
            self._open.pop()
            self._height[key] = self._deepest - self._depth
            self.subject, self.measured, self.imagining = before[0], before[1], before[3]
            self._deepest = max(before[2], self._deepest)

    def _deepen(self, more: int, span: Span) -> None:
        self._deepest = max(self._deepest, self._depth + more)
        if self._depth + more > MAX_DEPTH:
            self.fail("WMS105", "too many values depend on one another here", span, "make the chain shorter")


#: The check of each sort of expression.
_CHECKS: dict[type[s.Expr], Callable[[Expressions, Any, tuple[Type, ...]], Typed]] = {
    s.Number: Expressions.number,
    s.Text: lambda _, e, __: Typed(ir.Value(value=e.value), TEXT),
    s.Truth: lambda _, e, __: Typed(ir.Value(value=e.value), TRUTH),
    s.Name: names.name,
    s.Member: lambda check, e, _: members.member(check, e),
    s.Index: lambda check, e, _: members.index(check, e),
    s.Call: lambda check, e, _: calls.call(check, e),
    s.Operation: operators.operation_of,
    s.Items: lists.items,
    s.Called: lists.items,
    s.Range: lambda check, e, _: lists.range_(check, e),
    s.WhatIf: lambda check, e, _: what_ifs.what_if(check, e),
    s.Cause: lambda check, e, _: what_ifs.cause(check, e),
}


@cache
def default_value(slot: PropertySpec) -> ir.Expr:
    """Return the default of a property or argument."""
    assert slot.default is not None
    source = Source("<default>", slot.default)
    report = Report()
    expr = parse_expression(Span(source, 0, len(slot.default)), report)
    assert expr is not None, slot
    return Expressions(Scope((), report), report, set()).value(expr, slot.types, "the default").expr
