"""Checks function calls: positional and named arguments, and result types."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.core.diagnostics import suggestion
from wmspec.core.places import Span
from wmspec.lang.check.expressions.typed import Failed, Typed, common_type, constant, fits
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.evaluate import subexpressions
from wmspec.lang.check.tables.functions import FUNCTION_ALIASES, FUNCTIONS, Function
from wmspec.lang.check.tables.verbs import VERBS
from wmspec.lang.check.tables.vocabulary import JOINTS
from wmspec.lang.check.types.types import (
    CAMERA,
    COUNTED,
    ITEM,
    JOINT,
    LABEL,
    OBJECT,
    QUANTITY,
    TRUTH,
    VIEWER,
    List,
    Quantity,
    Type,
    Vector,
    Word,
    article,
)
from wmspec.lang.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.lang.check.expressions.expressions import Expressions

#: Parameter types of the function table that stand for several types.
_TYPE_ALIASES: dict[Type, tuple[Type, ...]] = {COUNTED: (List(OBJECT), List(TRUTH)), VIEWER: (CAMERA, OBJECT)}

#: How to turn a value of another type into a quantity.
_AS_QUANTITY: dict[Type, str] = {
    List(TRUTH): "write `count(...)` to count those that hold",
    OBJECT: "measure it, as in `height(...)`",
    List(OBJECT): "measure them, as in `height(...)`; `count(...)` is how many there are",
    JOINT: "measure it: `angle(...)` of a hinge, `extension(...)` of a slider",
    List(JOINT): "measure them: `angle(...)` of hinges, `extension(...)` of sliders",
}

#: Measures of joints: the joint kind of each, and the measure of the other kind.
JOINT_MEASURES = {"angle": ("hinge", "extension"), "extension": ("slider", "angle")}


def call(check: Expressions, e: s.Call) -> Typed:
    """Check a function call. In the IR, options follow the other arguments."""
    name, function = _function(check, e)
    if function.measured and not check.measured:
        check.fail("WMS303", f"`{name}` is measured on the executed episode, and this describes the episode",
                   e.span, "use it in `answer`, `ensure` or `margin`")  # fmt: skip
    positional = [a for a in e.arguments if a.name is None]
    least = len(function.parameters)
    if len(positional) != least and not (function.repeated and len(positional) >= least):
        check.fail("WMS205", f"`{name}` takes {_many(function)}, not {len(positional)}", e.span,
                   f"write `{signature(name, function)}`")  # fmt: skip
    expected = function.parameters + function.parameters[-1:] * (len(positional) - least)
    given = [_argument(check, name, a, kind) for a, kind in zip(positional, expected, strict=True)]
    if function.repeated:
        given = _flattened(check, name, positional, given)
    options = _options(check, e, name, function)
    each = _list_argument(check, name, function, positional, given)
    if each is not None:
        given[each] = Typed(given[each].expr, _item(given[each].type))
    arguments = tuple(g.expr for g in given)
    if name == "toward":
        if check.subject is None:
            check.fail("WMS205", "`toward` needs an acting object: it is allowed in the arguments of actions", e.span)
        arguments = (check.subject, *arguments)
    _check_distinct(check, name, arguments, positional[-1].span if positional else e.span)
    kind = _result(check, name, function, positional, given)
    if kind == OBJECT and options:  # ties yield `neither`
        kind = LABEL
    if JOINT in function.parameters:
        _check_joint_measure(check, name, positional[0], given[0])
    expr = ir.Call(function=name, arguments=arguments, options=options, each=each)
    return Typed(expr, kind if each is None else List(kind))


def _flattened(check: Expressions, name: str, written: list[s.Argument], given: list[Typed]) -> list[Typed]:
    """Flatten quantities and lists of quantities for a function of several; a single quantity is an error."""
    if len(given) == 1 and not isinstance(given[0].type, List):
        remedy = f"give it several, as in `{name}(a, b)`, or a list"
        check.fail("WMS205", f"`{name}` needs several quantities, and this is one", written[0].span, remedy)
    return [Typed(g.expr, _item(g.type)) if isinstance(g.type, List) else g for g in given]


def _check_distinct(check: Expressions, name: str, arguments: tuple[ir.Expr, ...], span: Span) -> None:
    """Report a comparison of an object with itself."""
    if len(arguments) < 2 or not isinstance(arguments[0], ir.Value) or not isinstance(arguments[0].value, str):
        return
    second = arguments[1]
    if arguments[0] in (second.items if isinstance(second, ir.Items) else (second,)):
        what = f"`{name}` is of a thing and another, and both are `{arguments[0].value}` here"
        check.fail("WMS205", what, span, "name another one")


def _function(check: Expressions, e: s.Call) -> tuple[str, Function]:
    if not isinstance(e.function, s.Name) or e.function.id not in FUNCTIONS:
        shown = e.function.span.text
        check.fail("WMS204", f"there is no function `{shown}`", e.function.span, _remedy(e, shown))
    return e.function.id, FUNCTIONS[e.function.id]


def _remedy(e: s.Call, shown: str) -> str:
    """Return the remedy for an unknown function: `ball.contact(box)` begins with its function."""
    if isinstance(e.function, s.Member):
        name = FUNCTION_ALIASES.get(e.function.name.id, e.function.name.id)
        if name in FUNCTIONS:
            return f"write `{name}({', '.join(x.span.text for x in (e.function.value, *e.arguments))})`"
    if isinstance(e.function, s.Member) or shown in VERBS:
        return "a verb stands in an action: `action NAME = ...`"
    if (other := FUNCTION_ALIASES.get(shown)) is not None:
        return f"did you mean `{other}`?" if other in FUNCTIONS else other
    return suggestion(shown, FUNCTIONS)


def _result(check: Expressions, name: str, function: Function, written: list[s.Argument], given: list[Typed]) -> Type:
    if function.result == QUANTITY:
        return _common_type(check, name, written, given)
    if function.result == ITEM:
        return _item(given[0].type)
    return function.result


def _list_argument(
    check: Expressions, name: str, function: Function, written: list[s.Argument], given: list[Typed]
) -> int | None:
    """Return the index of a list argument in place of a single value; the result then holds for each item."""
    lists = [i for i, typed in enumerate(given) if _accepts_list(function, i) and isinstance(typed.type, List)]
    if len(lists) > 1:
        check.fail("WMS302", f"`{name}` maps over one list, and this is a second",
                   written[lists[1]].span, "name one thing here")  # fmt: skip
    return lists[0] if lists else None


def _accepts_list(function: Function, i: int) -> bool:
    """Whether parameter `i` accepts a list of values, with one result for each."""
    return (
        not function.repeated
        and function.parameters[i] in (OBJECT, JOINT, QUANTITY)
        and _maps_over_lists(function.result)
    )


def _maps_over_lists(result: Type) -> bool:
    return result in (TRUTH, QUANTITY) or isinstance(result, Quantity | Word | Vector)


def _item(kind: Type) -> Type:
    assert isinstance(kind, List)
    assert kind.item is not None
    return kind.item


def _check_joint_measure(check: Expressions, name: str, written: s.Argument, joint: Typed) -> None:
    """Report a measure that the joint lacks: hinges have angles, sliders extensions."""
    for part in subexpressions(joint.expr):
        block = check.scope.names.get(str(part.value)) if isinstance(part, ir.Value) else None
        if not isinstance(block, s.Block) or block.model is None or block.kind != "joint":
            continue
        kind, (expected, other) = block.model.id, JOINT_MEASURES[name]
        if kind not in JOINTS:  # already reported
            raise Failed
        if kind != expected:
            remedy = (
                f"write `{other}({written.span.text})`"
                if kind == JOINT_MEASURES[other][0]
                else "measure a body that it moves"
            )
            what = f"`{name}` is of a {expected}, and `{written.span.text}` is a {kind} joint"
            check.fail("WMS302", what, written.span, remedy)


def _argument(check: Expressions, function: str, argument: s.Argument, kind: Type) -> Typed:
    if kind == List(ITEM):
        typed = check.infer(argument.value)
        if not isinstance(typed.type, List) or typed.type.item is None:
            check.fail(
                "WMS302", f"`{function}` expects a list of items to choose from", argument.span, "write `[a, b]`"
            )
        return typed
    if kind in _TYPE_ALIASES:
        return check.value(argument.value, _TYPE_ALIASES[kind], f"`{function}`")
    if kind != QUANTITY:
        return _one_or_each(check, function, argument, kind)
    typed = check.infer(argument.value)
    item = typed.type.item if isinstance(typed.type, List) else typed.type
    if not isinstance(item, Quantity):
        what = article(str(typed.type))
        remedy = _AS_QUANTITY.get(typed.type, "")
        check.fail("WMS302", f"`{function}` expects quantities, found {what}", argument.span, remedy)
    return typed


def _one_or_each(check: Expressions, function: str, argument: s.Argument, kind: Type) -> Typed:
    """Check an argument of a type, or a list of objects or joints if the function maps over lists."""
    if kind not in (OBJECT, JOINT) or not _maps_over_lists(FUNCTIONS[function].result):
        return check.value(argument.value, (kind,), f"`{function}`")
    typed = check.infer(argument.value, (kind,))
    if fits(typed.type, List(kind)) and typed.type != List(None):
        return Typed(typed.expr, List(kind))
    if not fits(typed.type, kind):
        check.type_mismatch(argument.value, typed.type, (kind,), f"`{function}`")
    return Typed(typed.expr, kind)


def _common_type(check: Expressions, function: str, written: list[s.Argument], given: list[Typed]) -> Type:
    """Return the common type of quantities."""
    kind = given[0].type
    for argument, typed in zip(written[1:], given[1:], strict=True):
        common = common_type(kind, typed.type)
        if common is None:
            check.type_mismatch(argument.value, typed.type, (kind,), f"`{function}`, like its first argument,")
        kind = common
    return kind


def _options(check: Expressions, e: s.Call, name: str, function: Function) -> tuple[ir.Option, ...]:
    given: dict[str, ir.Expr] = {}
    spans: dict[str, Span] = {}
    for argument in e.arguments:
        if argument.name is None:
            continue
        option = argument.name
        if option.id not in function.options:
            hint = (
                suggestion(option.id, function.options) if function.options else f"write `{signature(name, function)}`"
            )
            check.fail("WMS205", f"`{name}` has no option `{option.id}`", option.span, hint)
        if option.id in given:
            check.fail("WMS205", f"`{option.id}` is given twice", argument.span, "remove one")
        kind = function.options[option.id]
        given[option.id] = check.value(argument.value, _TYPE_ALIASES.get(kind, (kind,)), f"`{option.id}`").expr
        spans[option.id] = argument.span
    _check_time_span(check, name, given, spans)
    return tuple(ir.Option(name=option, value=given[option]) for option in function.options if option in given)


def _check_time_span(check: Expressions, name: str, given: dict[str, ir.Expr], spans: dict[str, Span]) -> None:
    """Report a time next to a time span, and a span that ends before it begins."""
    if "at" in given and (span := spans.get("from", spans.get("to"))):
        check.fail(
            "WMS205", f"`{name}` is measured at a time or over a time span, not both", span, "remove it, or `at`"
        )
    start, stop = (constant(given[option]) if option in given else None for option in ("from", "to"))
    if start is not None and stop is not None and start >= stop:
        check.fail("WMS304", "this time span ends before it begins", spans["to"], "let `to` be later than `from`")
    for option in ("at", "from", "to"):
        if option in given and (time := constant(given[option])) is not None and time < 0:
            check.fail("WMS304", "no time of an episode is before 0 s", spans[option], "make it 0 s or later")


def signature(name: str, function: Function) -> str:
    """Return the signature of a function, with parameter types, for messages and the reference."""
    parameters = [str(p) for p in function.parameters]
    more = ["..."] * function.repeated
    options = [f"{option}: {kind}" for option, kind in function.options.items()]
    return f"{name}({', '.join([*parameters, *more, *options])})"


def _many(function: Function) -> str:
    n = len(function.parameters)
    return f"{n}{' or more' if function.repeated else ''} argument{'s' * (n != 1 or function.repeated)}"
