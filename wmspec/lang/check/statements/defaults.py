"""Default values of properties and arguments."""

from __future__ import annotations

from functools import cache

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source, Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.scope import Scope
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import PropertySpec
from wmspec.lang.parse.parser import parse_expression


@cache
def default_value(slot: PropertySpec) -> ir.Expr:
    """Return the default of a property or argument."""
    assert slot.default is not None
    source = Source("<default>", slot.default)
    report = Report()
    expr = parse_expression(Span(source, 0, len(slot.default)), report)
    assert expr is not None, slot
    return Expressions(Scope((), report), report, set()).value(expr, slot.types, "the default").expr
