"""Checked expressions with their types, and type compatibility."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeVar

from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import WORDS
from wmspec.lang.check.types import units
from wmspec.lang.check.types.types import LABEL, NEITHER, OBJECT, TEXT, List, Quantity, Type, Vector, Word
from wmspec.lang.check.types.units import Dimension

C = TypeVar("C")
T = TypeVar("T")
#: Dimension of a bare `0`, which is compatible with every quantity.
ZERO = Dimension(99, 99, 99, 99)

#: Types that may be mixed among the options of one question.
_LABELS = (OBJECT, TEXT, NEITHER, LABEL)


class Failed(Exception):
    """An error was reported; the caller continues without the value."""


def without_failed(check: Callable[[C], T], items: Iterable[C]) -> list[T]:
    """Return the results of checking each of the items, without failed ones."""
    results = []
    for item in items:
        with suppress(Failed):
            results.append(check(item))
    return results


@dataclass(frozen=True)
class Typed:
    """A checked expression and its type."""

    expr: ir.Expr
    type: Type


def fits(given: Type, expected: Type) -> bool:
    """Whether a value of type `given` is allowed where the other is expected."""
    return common_type(given, expected) == expected


def common_type(a: Type, b: Type) -> Type | None:
    """Return the common type of two values, or None. A bare zero and an empty list adapt to the other."""
    if a == b:
        return a
    match a, b:
        case Quantity(dimension), Quantity() if dimension == ZERO:
            return b
        case Quantity(), Quantity(dimension) if dimension == ZERO:
            return a
        case Vector(dimension, n), Vector(_, m) if dimension == ZERO and n == m:
            return b
        case Vector(_, n), Vector(dimension, m) if dimension == ZERO and n == m:
            return a
        case List(None), List():
            return b
        case List(), List(None):
            return a
        case List(x), List(y) if x and y:
            item = common_type(x, y)
            return List(item) if item else None
    return LABEL if _can_mix_as_options(a, b) or _can_mix_as_options(b, a) else None


def _can_mix_as_options(a: Type, b: Type) -> bool:
    """Whether both may be options of one question though their types differ."""
    return a in _LABELS and (b in _LABELS or (isinstance(b, Word) and a in (NEITHER, LABEL)))


def operation(operator: str, operands: list[Typed], result: Type, each: int | None = None) -> Typed:
    """Return an operation, folded if its operands are constant numbers. `each` is that of `ir.Operation`."""
    values = [o.expr.value for o in operands if isinstance(o.expr, ir.Value) and isinstance(o.expr.value, float)]
    expr = ir.Operation(operator=operator, operands=tuple(o.expr for o in operands), each=each)
    if len(values) == len(operands) and (folded := constant(expr)) is not None:
        return Typed(ir.Value(value=folded), result)
    return Typed(expr, result)


def constant(expr: ir.Expr) -> float | None:
    """Return the value of a constant numeric expression, or None."""
    match expr:
        case ir.Value(value=float(value)):
            return value
        case ir.Operation(operator="-", operands=(a,)):
            return None if (x := constant(a)) is None else -x
        case ir.Operation(operator=("+" | "-" | "*" | "/") as operator, operands=(a, b)):
            x, y = constant(a), constant(b)
            if x is None or y is None or (operator == "/" and y == 0):
                return None
            value = {"+": x + y, "-": x - y, "*": x * y, "/": x / (y or 1)}[operator]
            return value if math.isfinite(value) else None
    return None


def example(of: Type) -> str:
    """Return an example of a value of a type, for messages, or ''."""
    match of:
        case Quantity(dimension):
            return units.EXAMPLES.get(dimension, "")
        case Vector(dimension, size) if dimension in units.EXAMPLES:
            return f"({', '.join([units.EXAMPLES[dimension]] * size)})"
        case Word(vocabulary):
            return WORDS[vocabulary][0]
    return ""
