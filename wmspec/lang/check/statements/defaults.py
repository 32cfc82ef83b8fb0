"""The values of what is left out."""

from __future__ import annotations

from functools import cache

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source, Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.scope import Scope
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import Slot
from wmspec.lang.parse.parser import parse_expression


@cache
def default_value(slot: Slot) -> ir.Expr:
    """The value that a property or argument has when it is left out."""
    assert slot.default is not None
    source = Source("<default>", slot.default)
    report = Report()
    expr = parse_expression(Span(source, 0, len(slot.default)), report)
    assert expr is not None, slot
    return Expressions(Scope((), report), report, set()).value(expr, slot.types, "the default").expr
