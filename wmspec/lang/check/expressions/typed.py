"""What is known of a checked expression: its IR and its kind; and which kinds go together."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.vocabulary import WORDS
from wmspec.lang.check.types import units
from wmspec.lang.check.types.types import LABEL, NEITHER, OBJECT, TEXT, List, Quantity, Type, Vector, Word
from wmspec.lang.check.types.units import Dimension

#: The dimension of a bare `0`, which fits wherever a quantity is wanted.
ZERO = Dimension(99, 99, 99, 99)

#: What can stand side by side as options of one question.
_LABELS = (OBJECT, TEXT, NEITHER, LABEL)


class Failed(Exception):
    """A mistake was reported; whoever asked for the value goes on without it."""


@dataclass(frozen=True)
class Typed:
    """A checked expression and its type."""

    expr: ir.Expr
    type: Type


def fits(given: Type, wanted: Type) -> bool:
    """Whether a value of this type may stand where the other is wanted."""
    return joined(given, wanted) == wanted


def joined(a: Type, b: Type) -> Type | None:
    """The common type of two values, None if they have none. A bare zero and an empty list give way."""
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
            item = joined(x, y)
            return List(item) if item else None
    return LABEL if _side_by_side(a, b) or _side_by_side(b, a) else None


def _side_by_side(a: Type, b: Type) -> bool:
    """Whether the two may be options of one question though they are of different types."""
    return a in _LABELS and (b in _LABELS or (isinstance(b, Word) and a in (NEITHER, LABEL)))


def operation(operator: str, operands: list[Typed], result: Type, each: int | None = None) -> Typed:
    """An operator applied to operands; of constant numbers, its value. `each` is as of `ir.Operation`."""
    values = [o.expr.value for o in operands if isinstance(o.expr, ir.Value) and isinstance(o.expr.value, float)]
    expr = ir.Operation(operator=operator, operands=tuple(o.expr for o in operands), each=each)
    if len(values) == len(operands) and (folded := constant(expr)) is not None:
        return Typed(ir.Value(value=folded), result)
    return Typed(expr, result)


def constant(expr: ir.Expr) -> float | None:
    """The value of an expression of constant numbers; None if it is anything else."""
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
    """How a value of a type may be written, for messages; empty if there is no short way to say it."""
    match of:
        case Quantity(dimension):
            return units.EXAMPLES.get(dimension, "")
        case Vector(dimension, size) if dimension in units.EXAMPLES:
            return f"({', '.join([units.EXAMPLES[dimension]] * size)})"
        case Word(vocabulary):
            return WORDS[vocabulary][0]
    return ""
