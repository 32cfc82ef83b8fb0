"""Evaluates expressions. The environment provides names, properties and functions."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Protocol

from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.places import Location
from wmspec.lang.check.ir.ir import Call, Cause, Counterfactual, Expr, Items, Operation, Property, Ref, Value, WhatIf


class Environment(Protocol):
    """Resolves the references of an expression."""

    def ref(self, name: str) -> Any:
        """Return the value of a factor, nuisance or `let`."""

    def property(self, owner: str, name: str) -> object:
        """Return a property of an object, camera or light, or an argument of an action."""

    def call(self, function: str, arguments: tuple[Any, ...], **options: Any) -> Any:
        """Return the result of a function for evaluated arguments and options."""

    def under(self, change: Counterfactual) -> Environment:
        """Return the environment with one change. Raises Unchanged if the change has no effect."""


class NoValue(ImpossibleValue):
    """An expression has no value; the caller adds the location."""


class NoCause(NoValue):
    """No candidate, or more than one, is the cause."""


class Unchanged(NoValue):
    """A change equals the instance itself."""


def _divide(a: float, b: float) -> float:
    if b == 0:
        raise NoValue("division by zero")
    return a / b


_OPERATORS: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "*": operator.mul,
    "/": _divide,
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "not": operator.not_,
    "x": operator.itemgetter(0),
    "y": operator.itemgetter(1),
    "z": operator.itemgetter(2),
}


def evaluate(expr: Expr, env: Environment) -> Any:
    """Return the value: a float (SI), bool, str (words and names), or a tuple. Raises WmsError if there is none."""
    return _EVALUATORS[type(expr)](expr, env)


def _items(expr: Items, env: Environment) -> tuple[Any, ...]:
    return tuple(_all(expr.items, env))


def _all(exprs: tuple[Expr, ...], env: Environment) -> list[Any]:
    """Return the values of several expressions, most of which are constants."""
    return [e.value if type(e) is Value else _EVALUATORS[type(e)](e, env) for e in exprs]


def _operation(expr: Operation, env: Environment) -> Any:
    if expr.each is None:
        return _operate(expr.operator, expr.operands, env)
    values = _all(expr.operands, env)
    rows = ([*values[: expr.each], item, *values[expr.each + 1 :]] for item in values[expr.each])
    return tuple(_operate(expr.operator, tuple(Value(value=v) for v in row), env) for row in rows)


def _operate(operator: str, operands: tuple[Expr, ...], env: Environment) -> Any:
    own = _LAZY_OPERATORS.get(operator)
    return own(operands, env) if own else _OPERATORS[operator](*_all(operands, env))


def _call(expr: Call, env: Environment) -> Any:
    arguments = tuple(_all(expr.arguments, env))
    options = {option.name: evaluate(option.value, env) for option in expr.options}
    if expr.each is None:
        return env.call(expr.function, arguments, **options)
    before, items, after = arguments[: expr.each], arguments[expr.each], arguments[expr.each + 1 :]
    return tuple(env.call(expr.function, (*before, item, *after), **options) for item in items)


def _if(operands: tuple[Expr, ...], env: Environment) -> Any:
    return evaluate(operands[1] if evaluate(operands[0], env) else operands[2], env)


def _minus(operands: tuple[Expr, ...], env: Environment) -> Any:
    values = _all(operands, env)
    return -values[0] if len(values) == 1 else values[0] - values[1]


#: Operators with lazily evaluated operands.
_LAZY_OPERATORS: dict[str, Callable[[tuple[Expr, ...], Environment], Any]] = {
    "if": _if,
    "and": lambda operands, env: all(evaluate(e, env) for e in operands),
    "or": lambda operands, env: any(evaluate(e, env) for e in operands),
    "-": _minus,
}


def _what_if(expr: WhatIf, env: Environment) -> Any:
    return evaluate(expr.value, env.under(resolved(expr.change, env)))


def _cause(expr: Cause, env: Environment) -> str:
    """Return the only candidate without which the condition does not hold."""
    candidates: tuple[str, ...] = evaluate(expr.candidates, env)
    if not evaluate(expr.condition, env):
        raise NoCause("it does not happen, so nothing is its cause")
    causes = [name for name in candidates if not _holds_without(expr, name, env)]
    if len(causes) != 1:
        found = f"it needs {' and '.join(causes)}" if causes else f"it happens without any of {', '.join(candidates)}"
        raise NoCause(f"{found}, so no single one is its cause")
    return causes[0]


def _holds_without(expr: Cause, name: str, env: Environment) -> bool:
    try:
        return bool(evaluate(expr.condition, env.under(without(name, expr.place))))
    except Unchanged:  # an absent candidate
        return True


def without(name: str, place: Location) -> Counterfactual:
    """Return the change that leaves out an object or action."""
    label = f"without_{name}"
    return Counterfactual(name=label, change="without", owner=name, property="", value=None, sort="", place=place)


def resolved(change: Counterfactual, env: Environment) -> Counterfactual:
    """Return a change with its owner, which may depend on factors."""
    if change.change != "without" or change.value is None:
        return change
    return without(evaluate(change.value, env), change.place)


#: Evaluators by expression class.
_EVALUATORS: dict[type, Callable[[Any, Environment], Any]] = {
    Value: lambda expr, _: expr.value,
    Ref: lambda expr, env: env.ref(expr.name),
    Property: lambda expr, env: env.property(evaluate(expr.owner, env), expr.name),
    Items: _items,
    Call: _call,
    Operation: _operation,
    WhatIf: _what_if,
    Cause: _cause,
}


def subexpressions(expr: Expr) -> Iterator[Expr]:
    """Yield an expression and all its subexpressions."""
    stack: list[Expr] = [expr]
    while stack:
        node = stack.pop()
        yield node
        match node:
            case Property():
                stack.append(node.owner)
            case Items():
                stack.extend(node.items)
            case Call():
                stack.extend(node.arguments)
                stack.extend(option.value for option in node.options)
            case Operation():
                stack.extend(node.operands)
            case WhatIf():
                stack.append(node.value)
                stack.extend(e for e in (node.change.value,) if e is not None)
            case Cause():
                stack += (node.condition, node.candidates)


def reachable(exprs: Iterable[Expr], lets: Mapping[str, Expr]) -> Iterator[Expr]:
    """Yield all subexpressions, including those of the `lets` that they refer to."""
    waiting, seen = list(exprs), set[str]()
    while waiting:
        for part in subexpressions(waiting.pop()):
            yield part
            if isinstance(part, Ref) and part.name in lets and part.name not in seen:
                seen.add(part.name)
                waiting.append(lets[part.name])
