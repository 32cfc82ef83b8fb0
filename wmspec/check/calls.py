"""Calls of functions: their arguments, in order and by name, and what they give."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.check import ir
from wmspec.check.functions import FUNCTIONS, Function
from wmspec.check.typed import Typed, joined
from wmspec.check.types import ITEM, LABEL, OBJECT, QUANTITY, List, Quantity, Type, article
from wmspec.check.verbs import VERBS
from wmspec.diagnostics import suggestion
from wmspec.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.check.expressions import Expressions


def call(check: Expressions, e: s.Call) -> Typed:
    """A function of arguments. An option that is given follows the other arguments in the IR."""
    name, function = _function(check, e)
    if function.measured and not check.measured:
        check.fail("WMS303", f"`{name}` is measured on the executed episode; here it is still being described",
                   e.span, "use it in `answer`, `ensure` or `margin`")  # fmt: skip
    positional = [a for a in e.arguments if a.name is None]
    least = len(function.parameters)
    if len(positional) != least and not (function.repeated and len(positional) >= least):
        check.fail("WMS205", f"`{name}` takes {_many(function)}, not {len(positional)}", e.span,
                   f"write `{signature(name, function)}`")  # fmt: skip
    wanted = function.parameters + function.parameters[-1:] * (len(positional) - least)
    given = [_argument(check, name, a, kind) for a, kind in zip(positional, wanted, strict=True)]
    options = _options(check, e, name, function)
    arguments = (*(g.expr for g in given), *options)
    if name == "toward":
        if check.subject is None:
            check.fail("WMS205", "`toward` needs an acting object: it is for the arguments of actions", e.span)
        arguments = (check.subject, *arguments)
    kind = _result(check, name, function, positional, given)
    if kind == OBJECT and options:  # of equals it gives `neither`
        kind = LABEL
    return Typed(ir.Call(function=name, arguments=arguments), kind)


def _function(check: Expressions, e: s.Call) -> tuple[str, Function]:
    if not isinstance(e.function, s.Name) or e.function.id not in FUNCTIONS:
        shown = e.function.span.text
        verb = isinstance(e.function, s.Member) or shown in VERBS
        hint = "a verb stands in an action: `action NAME = ...`" if verb else suggestion(shown, FUNCTIONS)
        check.fail("WMS204", f"there is no function `{shown}`", e.function.span, hint)
    return e.function.id, FUNCTIONS[e.function.id]


def _result(check: Expressions, name: str, function: Function, written: list[s.Argument], given: list[Typed]) -> Type:
    if function.result == QUANTITY:
        return _common(check, name, written, given)
    if function.result == ITEM:
        items = given[0].type
        assert isinstance(items, List)
        assert items.item is not None
        return items.item
    return function.result


def _argument(check: Expressions, function: str, argument: s.Argument, kind: Type) -> Typed:
    if kind == List(ITEM):
        typed = check.infer(argument.value)
        if not isinstance(typed.type, List) or typed.type.item is None:
            check.fail("WMS302", f"`{function}` wants a list of items to choose from", argument.span, "write `[a, b]`")
        return typed
    if kind != QUANTITY:
        return check.value(argument.value, (kind,), f"`{function}`")
    typed = check.infer(argument.value)
    if not isinstance(typed.type, Quantity):
        what = article(str(typed.type))
        check.fail("WMS302", f"`{function}` wants quantities, but this is {what}", argument.span)
    return typed


def _common(check: Expressions, function: str, written: list[s.Argument], given: list[Typed]) -> Type:
    """The kind that quantities have in common."""
    kind = given[0].type
    for argument, typed in zip(written[1:], given[1:], strict=True):
        common = joined(kind, typed.type)
        if common is None:
            check.misfit(argument.span, typed.type, (kind,), f"`{function}`, like its first argument,")
        kind = common
    return kind


def _options(check: Expressions, e: s.Call, name: str, function: Function) -> list[ir.Expr]:
    found: list[ir.Expr] = []
    for argument in e.arguments:
        if argument.name is None:
            continue
        option = argument.name
        if option.id not in function.options:
            hint = (
                suggestion(option.id, function.options) if function.options else f"write `{signature(name, function)}`"
            )
            check.fail("WMS205", f"`{name}` has no option `{option.id}`", option.span, hint)
        if found:
            check.fail("WMS205", f"`{option.id}` is given twice", argument.span, "remove one")
        found.append(check.value(argument.value, (function.options[option.id],), f"`{option.id}`").expr)
    return found


def signature(name: str, function: Function) -> str:
    """How a function is called, with the kinds of its arguments, for messages and the reference."""
    parameters = [str(p) for p in function.parameters]
    more = ["..."] * function.repeated
    options = [f"{option}: {kind}" for option, kind in function.options.items()]
    return f"{name}({', '.join([*parameters, *more, *options])})"


def _many(function: Function) -> str:
    n = len(function.parameters)
    return f"{n}{' or more' if function.repeated else ''} argument{'s' * (n != 1 or function.repeated)}"
