"""Checks what an instance must meet to yield a question: `ensure`, `margin`, `distinct`; and its `difference`."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from math import pi

from wmspec.core.diagnostics import Note
from wmspec.core.places import Location
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import ZERO, Failed, constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import PropertySpec
from wmspec.lang.check.types.types import A_LENGTH, AN_ANGLE, TRUTH, Quantity, article
from wmspec.lang.check.types.units import NUMBER
from wmspec.lang.parse import syntax as s

_APART = PropertySpec((A_LENGTH,), "how far apart", above=0)
_TURNED = PropertySpec((AN_ANGLE,), "by what turn", above=0, most=pi)
#: Value of `distinct by` next to quantities: the kind of the outcome.
KIND = "kind"


class QuestionGates:
    """Checks gates; an error is reported and raises `Failed`."""

    def __init__(self, check: Expressions) -> None:
        self.check = check
        self.report = check.report

    def ensure(self, clause: s.Clause) -> ir.Require:
        """Return a condition that an instance must meet."""
        typed = self.check.measuring(clause.value, (TRUTH,), "`ensure`")
        return ir.Require(condition=typed.expr, text=clause.value.span.words, place=Location.of(clause.value.span))

    def margin(self, clause: s.Clause) -> ir.Margin:
        """Return the required distance of a value from the threshold."""
        assert clause.bound is not None
        value, kind = self._quantity(clause, "margin")
        bound = self.check.value(clause.bound, (kind,), "`apart by`")
        ratio = kind.dimension == NUMBER
        if ratio and (factor := constant(bound.expr)) is not None and factor < 1:
            self.check.fail("WMS304", "a ratio is apart by a factor of 1 or more", clause.bound.span)
        self.check.bounds(bound.expr, PropertySpec((kind,), "", least=0), clause.bound.span, "`apart by`")
        unless = self.check.measuring(clause.unless, (TRUTH,), "`unless`").expr if clause.unless else None
        return ir.Margin(value=value, bound=bound.expr, ratio=ratio, unless=unless, place=Location.of(clause.span))

    def difference(self, clause: s.Clause) -> ir.Difference:
        """Return the stimulus strength."""
        value, kind = self._quantity(clause, "difference")
        return ir.Difference(value=value, unit=kind.dimension.symbol)

    def _quantity(self, clause: s.Clause, what: str) -> tuple[ir.Expr, Quantity]:
        value = self.check.measuring(clause.value)
        if not isinstance(value.type, Quantity):
            message = f"`{what}` expects a quantity, found {article(str(value.type))}"
            self.check.fail("WMS302", message, clause.value.span)
        return value.expr, Quantity(NUMBER) if value.type.dimension == ZERO else value.type

    def distinct(
        self, clauses: list[s.Clause], kinds: tuple[s.Kinds, ...]
    ) -> tuple[ir.Expr | None, ir.Expr | None, bool]:
        """Return the required difference between options: length (m), angle (rad), and whether of kind of outcome.

        `distinct by 5 cm or 20 deg` and `distinct by kind`: at most one of each.
        """
        first: dict[bool, s.Clause] = {}
        for clause in clauses:
            kind = self._by_kind(clause)
            if first.setdefault(kind, clause) is not clause:
                notes = (Note("first set here", first[kind].span),)
                self.report.add("WMS202", "`distinct` is set twice", clause.span, "remove one", notes)
        if True in first and not kinds:
            remedy = "define them: `kinds { NAME: CONDITION ... }`"
            self.report.add("WMS502", "the outcomes of this question have no kinds", first[True].value.span, remedy)
        length, turn = None, None
        if False in first:
            with suppress(Failed):  # reported
                length, turn = self._bounds(first[False])
        return length, turn, True in first

    def _by_kind(self, clause: s.Clause) -> bool:
        return isinstance(clause.value, s.Name) and clause.value.id == KIND and KIND not in self.check.scope.names

    def _bounds(self, clause: s.Clause) -> tuple[ir.Expr, ir.Expr | None]:
        """Return the required distance of options and, after `or`, the required angle."""
        length, turn = clause.value, None
        if isinstance(clause.value, s.Operation) and clause.value.operator == "or":
            length, turn = clause.value.operands
        apart = self.separately(replace(clause, value=length))
        if turn is None:
            return apart, None
        typed = self.check.value(turn, _TURNED.types, "`distinct by`, after `or`,")
        self.check.bounds(typed.expr, _TURNED, turn.span, "`distinct by`")
        return apart, typed.expr

    def separately(self, clause: s.Clause) -> ir.Expr:
        """Return the required distance of options, or the displacement of objects."""
        typed = self.check.value(clause.value, _APART.types, f"`{clause.kind} by`")
        self.check.bounds(typed.expr, _APART, clause.value.span, f"`{clause.kind} by`")
        return typed.expr
