"""The parts of an expression that decide its value in an instance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from wmspec.lang.check.ir.evaluate import Environment, evaluate
from wmspec.lang.check.ir.ir import Call, Expr, Items, Operation, Property, Ref, TaskSpec


def decisive_parts(expr: Expr, spec: TaskSpec, env: Environment) -> Iterator[Expr]:
    """Yield an expression and the subexpressions that are evaluated for its value, named values included.

    Branches of `if`, and operands of `and` and `or`, that are not evaluated do not count.
    """
    lets = {let.name: let.value for let in spec.lets}
    return _parts(expr, lets, env, set())


def _parts(expr: Expr, lets: Mapping[str, Expr], env: Environment, seen: set[str]) -> Iterator[Expr]:
    yield expr
    for part in _evaluated(expr, lets, env, seen):
        yield from _parts(part, lets, env, seen)


def _evaluated(expr: Expr, lets: Mapping[str, Expr], env: Environment, seen: set[str]) -> Iterator[Expr]:
    """Yield the direct subexpressions that are evaluated."""
    match expr:
        case Ref() if expr.name in lets and expr.name not in seen:
            seen.add(expr.name)
            yield lets[expr.name]
        case Property():
            yield expr.owner
        case Items():
            yield from expr.items
        case Call():
            yield from expr.arguments
        case Operation(operator="if", each=None):
            condition, then, otherwise = expr.operands
            yield condition
            yield then if evaluate(condition, env) else otherwise
        case Operation(operator="and" | "or", each=None):
            for operand in expr.operands:
                yield operand
                if bool(evaluate(operand, env)) == (expr.operator == "or"):
                    return
        case Operation():
            yield from expr.operands
