"""Complaints about constants that are out of bounds."""

from __future__ import annotations

from wmspec.core.places import Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import Slot


def within(check: Expressions, expr: ir.Expr, slot: Slot, span: Span, what: str) -> None:
    """Complain about a constant that its slot does not take, or a point or size with such a part."""
    for part in expr.items if isinstance(expr, ir.Items) else (expr,):
        value = constant(part)
        if value is not None and (reason := slot.fault(value)):
            check.fail("WMS304", f"{what} must be {reason}", span)
        if slot.among and isinstance(part, ir.Value) and part.value not in slot.among:
            check.fail("WMS304", f"{what} must be {' or '.join(f'`{word}`' for word in slot.among)}", span)
