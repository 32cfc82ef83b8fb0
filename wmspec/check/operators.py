"""Operators: `+ - * /`, comparisons, `and or not`, `if`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.check.typed import ZERO, Typed, joined, operation
from wmspec.check.types import TRUTH, Quantity, Type, article
from wmspec.check.units import NUMBER
from wmspec.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.check.expressions import Expressions

COMPARISONS = ("==", "!=", "<", "<=", ">", ">=")


def operation_of(check: Expressions, e: s.Operation, wanted: tuple[Type, ...]) -> Typed:
    """An operator applied to what it takes."""
    if e.operator == "if":
        return _conditional(check, e, wanted)
    if e.operator in ("and", "or", "not"):
        operands = [check.value(o, (TRUTH,), f"`{e.operator}`") for o in e.operands]
        return operation(e.operator, operands, TRUTH)
    if e.operator in COMPARISONS:
        return _comparison(check, e)
    return _arithmetic(check, e)


def _conditional(check: Expressions, e: s.Operation, wanted: tuple[Type, ...]) -> Typed:
    condition = check.value(e.operands[0], (TRUTH,), "`if`")
    yes, no = (check.infer(o, wanted) for o in e.operands[1:])
    kind = joined(yes.type, no.type)
    if kind is None:
        check.misfit(e.operands[2].span, no.type, (yes.type,), "`else`, like its `then`,")
    return operation("if", [condition, yes, no], kind)


def _comparison(check: Expressions, e: s.Operation) -> Typed:
    left = check.infer(e.operands[0])
    right = check.infer(e.operands[1], (left.type,))
    if joined(left.type, right.type) is None:
        what = f"`{e.operator}`, after {article(str(left.type))},"
        check.misfit(e.operands[1].span, right.type, (left.type,), what)
    if e.operator not in ("==", "!=") and not isinstance(left.type, Quantity):
        check.fail("WMS302", f"`{e.operator}` compares quantities, not {left.type}s", e.span, "use `==` or `!=`")
    return operation(e.operator, [left, right], TRUTH)


def _arithmetic(check: Expressions, e: s.Operation) -> Typed:
    operands = [check.infer(o) for o in e.operands]
    kinds = []
    for operand, written in zip(operands, e.operands, strict=True):
        if not isinstance(operand.type, Quantity):
            message = f"`{e.operator}` wants quantities, but this is {article(str(operand.type))}"
            check.fail("WMS302", message, written.span)
        kinds.append(operand.type)
    dimensions = [NUMBER if k.dimension == ZERO and e.operator in "*/" else k.dimension for k in kinds]
    if len(operands) == 1:
        return operation("-", operands, kinds[0])
    if e.operator == "*":
        return operation("*", operands, Quantity(dimensions[0] * dimensions[1]))
    if e.operator == "/":
        return operation("/", operands, Quantity(dimensions[0] / dimensions[1]))
    kind = joined(*kinds)
    if kind is None:
        what = f"`{e.operator}`, after {article(str(kinds[0]))},"
        check.misfit(e.operands[1].span, kinds[1], (kinds[0],), what)
    return operation(e.operator, operands, kind)
