"""Checks operators: `+ - * /`, comparisons, `and or not`, `if`."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

from wmspec.lang.check.expressions.typed import ZERO, Typed, common_type, operation
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import HEADINGS
from wmspec.lang.check.types.types import DIRECTION, TRUTH, List, Plain, Quantity, Type, Word, article
from wmspec.lang.check.types.units import NUMBER
from wmspec.lang.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.lang.check.expressions.expressions import Expressions

COMPARISONS = ("==", "!=", "<", "<=", ">", ">=")


def operation_of(check: Expressions, e: s.Operation, expected: tuple[Type, ...]) -> Typed:
    """Check an operation."""
    if e.operator == "if":
        return _conditional(check, e, expected)
    if e.operator in ("and", "or", "not"):
        return _truth(check, e)
    if e.operator in COMPARISONS:
        return _comparison(check, e)
    return _arithmetic(check, e)


def _truth(check: Expressions, e: s.Operation) -> Typed:
    """Check `and`, `or` and `not`; `not` of a list applies to each item."""
    if e.operator == "not" and (typed := check.infer(e.operands[0], (TRUTH,))).type == List(TRUTH):
        return operation("not", [typed], List(TRUTH), 0)
    operands = [check.value(o, (TRUTH,), f"`{e.operator}`") for o in e.operands]
    return operation(e.operator, operands, TRUTH)


def _conditional(check: Expressions, e: s.Operation, expected: tuple[Type, ...]) -> Typed:
    condition = check.value(e.operands[0], (TRUTH,), "`if`")
    yes, no = (check.infer(o, expected) for o in e.operands[1:])
    kind = common_type(yes.type, no.type)
    if kind is None:
        check.type_mismatch(e.operands[2], no.type, (yes.type,), "`else`, like its `then`,", e.operands[1])
    return operation("if", [condition, yes, no], kind)


def _comparison(check: Expressions, e: s.Operation) -> Typed:
    left = check.infer(e.operands[0])
    right = check.infer(e.operands[1], (_single(left.type),))
    each = _each(check, e, [left, right])
    if each is not None:
        left, right = Typed(left.expr, _single(left.type)), Typed(right.expr, _single(right.type))
    if common_type(left.type, right.type) is None:
        what = f"`{e.operator}`, after {article(str(left.type))},"
        check.type_mismatch(e.operands[1], right.type, (left.type,), what, e.operands[0])
    if e.operator not in ("==", "!=") and not isinstance(left.type, Quantity):
        check.fail("WMS302", f"`{e.operator}` compares quantities, not {left.type}s", e.span, "use `==` or `!=`")
    return operation(e.operator, [left, right], TRUTH if each is None else List(TRUTH), each)


def _single(kind: Type) -> Type:
    """Return the item type of a list that an operator maps over, or the type itself."""
    return kind.item if isinstance(kind, List) and isinstance(kind.item, Quantity | Word | Plain) else kind


def _each(check: Expressions, e: s.Operation, operands: list[Typed]) -> int | None:
    """Return the index of the list operand that a comparison maps over; two lists can only be equal or not."""
    lists = [i for i, o in enumerate(operands) if _single(o.type) != o.type]
    if len(lists) > 1 and e.operator not in ("==", "!="):
        message = f"`{e.operator}` maps over one list, and this is a second"
        check.fail("WMS302", message, e.operands[lists[1]].span, "compare with one value, such as `max(...)` of it")
    return lists[0] if len(lists) == 1 else None


def _arithmetic(check: Expressions, e: s.Operation) -> Typed:
    operands = [check.infer(o) for o in e.operands]
    each = _each(check, e, operands)
    typed = _arithmetic_of(check, e, [Typed(o.expr, _single(o.type)) for o in operands], each)
    return typed if each is None else Typed(typed.expr, List(typed.type))


def _as_angle(operand: Typed) -> str:
    """Return the remedy for a direction word in arithmetic, or ''."""
    if operand.type != DIRECTION:
        return ""
    if isinstance(operand.expr, ir.Value) and isinstance(operand.expr.value, str):
        return f"write its angle, `{degrees(HEADINGS[operand.expr.value]):.0f} deg`"
    return "use angles: " + ", ".join(f"{word} is {degrees(angle):.0f} deg" for word, angle in HEADINGS.items())


def _arithmetic_of(check: Expressions, e: s.Operation, operands: list[Typed], each: int | None) -> Typed:
    kinds = []
    for operand, written in zip(operands, e.operands, strict=True):
        if not isinstance(operand.type, Quantity):
            message = f"`{e.operator}` expects quantities, found {article(str(operand.type))}"
            check.fail("WMS302", message, written.span, _as_angle(operand))
        kinds.append(operand.type)
    dimensions = [NUMBER if k.dimension == ZERO and e.operator in "*/" else k.dimension for k in kinds]
    if len(operands) == 1:
        return operation("-", operands, kinds[0], each)
    if e.operator == "*":
        return operation("*", operands, Quantity(dimensions[0] * dimensions[1]), each)
    if e.operator == "/":
        return operation("/", operands, Quantity(dimensions[0] / dimensions[1]), each)
    kind = common_type(*kinds)
    if kind is None:
        what = f"`{e.operator}`, after {article(str(kinds[0]))},"
        check.type_mismatch(e.operands[1], kinds[1], (kinds[0],), what, e.operands[0])
    return operation(e.operator, operands, kind, each)
