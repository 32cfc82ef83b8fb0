"""Checks lists, tuples and ranges."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from wmspec.core.places import Span
from wmspec.lang.check.expressions import names
from wmspec.lang.check.expressions.foreign_values import shared_unit
from wmspec.lang.check.expressions.typed import Typed, common_type, constant, fits
from wmspec.lang.check.ir import ir
from wmspec.lang.check.types import units
from wmspec.lang.check.types.types import A_NUMBER, List, Quantity, Type, Vector
from wmspec.lang.check.types.units import Dimension
from wmspec.lang.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.lang.check.expressions.expressions import Expressions

#: Maximum number of values of a range.
MAX_VALUES = 10_000


def items(check: Expressions, e: s.Items | s.Called, expected: tuple[Type, ...]) -> Typed:
    """Check a list of values of one type, or a tuple of two or three quantities. Labelled items belong to domains."""
    if isinstance(e, s.Called):
        what = "only the values of a factor or nuisance have names, where it lists them"
        check.fail("WMS302", what, e.text.span, "remove the name")
    inner = tuple(k.item for k in expected if isinstance(k, List) and k.item) or expected
    checked: list[Typed] = []
    for item in e.items:
        checked.append(check.infer(item, inner or tuple(first.type for first in checked[:1])))
    if e.unit is not None:
        unit = check.unit(e.unit, replace(e.span, start=e.span.end - len(e.unit)))
        checked = [_scaled(check, i, unit, written.span) for i, written in zip(checked, e.items, strict=True)]
    kind = checked[0].type if checked else None
    for typed, written in zip(checked, e.items, strict=True):
        common = common_type(kind, typed.type) if kind else None
        if kind is not None and common is None:
            if names.may_be_undeclared_name(check, e.items[0], kind):  # the declared name may be misspelled
                check.type_mismatch(e.items[0], kind, (typed.type,), f"this {e.kind}, like its other items,")
            if unit_remedy := shared_unit(e.items) if e.kind == "list" else "":
                check.fail("WMS301", "only the last number of this list has a unit", e.span, unit_remedy)
            check.type_mismatch(written, typed.type, (kind,), f"this {e.kind}, like its first item,")
        kind = common
    expr = ir.Items(items=tuple(i.expr for i in checked))
    if e.kind == "list":
        return Typed(expr, List(kind))
    if not isinstance(kind, Quantity) or len(checked) > 3:
        check.fail("WMS302", "a tuple holds two or three quantities", e.span, "use `[...]` for a list")
    return Typed(expr, Vector(kind.dimension, len(checked)))


def _scaled(check: Expressions, item: Typed, unit: tuple[float, Dimension], span: Span) -> Typed:
    """Return an item scaled by its list's unit (SI value and dimension)."""
    scale, dimension = unit
    if not fits(item.type, A_NUMBER):
        check.fail("WMS301", "this value has its own unit, in addition to that of the list", span)
    value = item.expr.value if isinstance(item.expr, ir.Value) else None
    if isinstance(value, float):
        return Typed(ir.Value(value=units.convert(value, scale)), Quantity(dimension))
    expr = ir.Operation(operator="*", operands=(item.expr, ir.Value(value=scale)))
    return Typed(expr, Quantity(dimension))


def range_(check: Expressions, e: s.Range) -> Typed:
    """Return the values of a range, or the two ends of an interval."""
    start, stop = check.infer(e.start), check.infer(e.stop)
    kind = common_type(start.type, stop.type)
    if not isinstance(kind, Quantity):
        check.type_mismatch(e.stop, stop.type, (start.type,), "`..`, like its start,")
    if e.step is not None:
        step = check.value(e.step, (kind,), "`by`")
        return Typed(_steps(check, e, start.expr, stop.expr, step.expr), List(kind))
    count = _count(check, e.count) if e.count is not None else 2
    return Typed(_points(start.expr, stop.expr, count), List(kind))


def _count(check: Expressions, e: s.Expr) -> int:
    count = constant(check.value(e, (A_NUMBER,), "`in`").expr)
    if count is None or count != int(count) or not 2 <= count <= MAX_VALUES:
        check.fail("WMS304", f"the number of values is a whole constant from 2 to {MAX_VALUES}", e.span)
    return int(count)


def _steps(check: Expressions, e: s.Range, start: ir.Expr, stop: ir.Expr, step: ir.Expr) -> ir.Items:
    a, b, by = constant(start), constant(stop), constant(step)
    if a is None or b is None or by is None:
        check.fail("WMS304", "a range with steps has constant ends", e.span, "use `a .. b in 5`")
    if by <= 0 or b < a:
        check.fail("WMS401", "this range is empty: it goes up from its start to its end", e.span)
    steps = (b - a) / by + 1e-9
    if not steps < MAX_VALUES:
        count = f"{int(steps) + 1}" if math.isfinite(steps) else "infinitely many"
        message = f"this range has {count} values; {MAX_VALUES} is the maximum"
        check.fail("WMS401", message, e.span, "take a larger step")
    return ir.Items(items=tuple(ir.Value(value=round(a + i * by, 12)) for i in range(int(steps) + 1)))


def _points(start: ir.Expr, stop: ir.Expr, count: int) -> ir.Items:
    a, b = constant(start), constant(stop)
    if a is not None and b is not None:
        return ir.Items(items=tuple(ir.Value(value=round(a + (b - a) * i / (count - 1), 12)) for i in range(count)))
    span = ir.Operation(operator="-", operands=(stop, start))
    shares = (ir.Value(value=i / (count - 1)) for i in range(count))
    steps = (ir.Operation(operator="*", operands=(span, share)) for share in shares)
    return ir.Items(items=tuple(ir.Operation(operator="+", operands=(start, step)) for step in steps))
