"""Bounds checks of constants."""

from __future__ import annotations

from wmspec.core.places import Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import PropertySpec


def check_bounds(check: Expressions, expr: ir.Expr, slot: PropertySpec, span: Span, what: str) -> None:
    """Report a constant, or a component of a point or size, outside the bounds of its slot."""
    for part in expr.items if isinstance(expr, ir.Items) else (expr,):
        value = constant(part)
        if value is not None and (reason := slot.violation(value)):
            check.fail("WMS304", f"{what} must be {reason}", span)
        if slot.among and isinstance(part, ir.Value) and part.value not in slot.among:
            check.fail("WMS304", f"{what} must be {' or '.join(f'`{word}`' for word in slot.among)}", span)
