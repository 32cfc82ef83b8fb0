"""Checks domains: lists, ranges, intervals, products, distributions, and conditional domains."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

from wmspec.core.diagnostics import Note, suggestion
from wmspec.core.places import Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.lists import MAX_VALUES
from wmspec.lang.check.expressions.typed import common_type, constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.tables.functions import DOMAIN_REMEDIES, FUNCTIONS
from wmspec.lang.check.types.types import A_NUMBER, TRUTH, List, Quantity, Type, Vector, article
from wmspec.lang.parse import syntax as s

Level = ir.Level
#: A condition as written, and whether it must be true or false.
Condition = tuple[s.Expr, bool]

_WRITE = "write `[a, b, c]`, `a .. b by c` or `a .. b in 5`"


@dataclass(frozen=True)
class DomainValue:
    """A value of a domain: its span, the conditions under which it is available, and its label."""

    value: Level
    span: Span
    when: tuple[Condition, ...] = ()
    name: str = ""


@dataclass(frozen=True)
class WrittenDomain:
    """A domain as written: separate `options`, perhaps with `weights`, or a continuous `spread`."""

    type: Type
    options: tuple[DomainValue, ...] = ()
    weights: tuple[float, ...] | None = None
    spread: ir.Interval | ir.Normal | None = None

    @property
    def conditional(self) -> bool:
        """Whether some values are available only under conditions."""
        return any(option.when for option in self.options)


def read_domain(check: Expressions, e: s.Expr) -> WrittenDomain:
    """Return a domain with the type of its values. Conditions are checked later: they may refer to any other factor."""
    match e:
        case s.Operation(operator="if"):
            return _conditional(check, e)
        case s.Call(function=s.Name(id=name)) if name in FORMS:
            return FORMS[name](check, e)
        case s.Call(function=s.Name(id=name)) if name not in FUNCTIONS:
            check.fail(
                "WMS204",
                f"there is no domain `{name}`",
                e.function.span,
                DOMAIN_REMEDIES.get(name) or suggestion(name, FORMS),
            )
        case s.Range(step=None, count=None):
            return _interval(check, e)
        case s.Name(id=name) if isinstance(let := check.scope.names.get(name), s.Let):
            check.infer(e)  # reports a cycle
            return read_domain(check, let.value)
    return _list(check, e)


def _list(check: Expressions, e: s.Expr) -> WrittenDomain:
    names: tuple[str, ...] = ()
    if isinstance(e, s.Items) and any(isinstance(item, s.Called) for item in e.items):
        names = tuple(_labels(check, e.items))
        e = replace(e, items=tuple(item.value if isinstance(item, s.Called) else item for item in e.items))
    typed = check.infer(e)
    if not isinstance(typed.type, List):
        check.fail("WMS401", f"a domain is a list or a range of values, not {article(str(typed.type))}", e.span, _WRITE)
    if typed.type.item is None:
        check.fail("WMS401", "this domain has no values", e.span, _WRITE)
    if not isinstance(typed.expr, ir.Items):
        check.fail("WMS401", "the values of a domain are constants", e.span, "write them out")
    spans = [item.span for item in e.items] if isinstance(e, s.Items) else [e.span] * len(typed.expr.items)
    values = zip(typed.expr.items, spans, strict=True)
    options = tuple(DomainValue(_level(check, expr, span), span) for expr, span in values)
    options = tuple(replace(o, name=n) for o, n in zip(options, names or [""] * len(options), strict=True))
    if isinstance(e, s.Items):
        _check_unique_values(check, options)
    return WrittenDomain(typed.type.item, options)


def _labels(check: Expressions, items: tuple[s.Expr, ...]) -> Iterator[str]:
    """Yield the labels of the values, which must be distinct."""
    first: dict[str, Span] = {}
    for item in items:
        if not isinstance(item, s.Called):
            what = f"`{item.span.text}` has no name, and others here have"
            check.fail("WMS401", what, item.span, f'write `{item.span.text} called "..."`')
        name = item.text.value
        if not name.strip():
            check.fail("WMS401", "this name is empty", item.text.span, "give the value a name")
        if name in first:
            notes = (Note("it is here first", first[name]),)
            check.fail("WMS401", f'two values are named "{name}"', item.text.span, "call one otherwise", notes)
        first[name] = item.text.span
        yield name


def _level(check: Expressions, expr: ir.Expr, span: Span) -> Level:
    match expr:
        case ir.Value(value=value):
            return value
        case ir.Items(items=items):
            return tuple(_number(check, i, span) for i in items)
    return _number(check, expr, span)


def _check_unique_values(check: Expressions, options: tuple[DomainValue, ...]) -> None:
    seen: dict[Level, Span] = {}
    for option in options:
        if option.value in seen:
            notes = (Note("it is here first", seen[option.value]),)
            check.fail("WMS401", "this value is in the domain twice", option.span, "remove one", notes)
        seen[option.value] = option.span


def _interval(check: Expressions, e: s.Range) -> WrittenDomain:
    typed = check.infer(e)
    assert isinstance(typed.type, List)
    assert isinstance(typed.expr, ir.Items)
    assert typed.type.item is not None
    low, high = (_number(check, end, e.span) for end in typed.expr.items)
    if high < low:
        check.fail("WMS401", "this interval is empty: it goes up from its start to its end", e.span)
    return WrittenDomain(typed.type.item, spread=ir.Interval(low=low, high=high))


def _number(check: Expressions, expr: ir.Expr, span: Span) -> float:
    value = constant(expr)
    if value is not None:
        return value
    declared = check.scope.names.get(span.text)
    if declared is None:
        check.fail("WMS401", "the values of a domain are constants", span, "write them out")
    what = f"the values of a domain are constants, and `{span.text}` is none"
    notes = (Note("declared here", declared.name.span),)
    check.fail("WMS401", what, span, "write the values out, or rename the declaration", notes)


# ---------------------------------------------------------------- choices between domains


def _conditional(check: Expressions, e: s.Operation) -> WrittenDomain:
    """Check `if CONDITION then DOMAIN else DOMAIN`: the values of both, each with its condition."""
    condition, *branches = e.operands
    yes, no = (_separate(check, branch, "a choice between domains") for branch in branches)
    kind = common_type(yes.type, no.type)
    if kind is None:
        check.type_mismatch(branches[1], no.type, (yes.type,), "`else`, like its `then`,")
    options = [
        replace(option, when=((condition, holds), *option.when))
        for written, holds in ((yes, True), (no, False))
        for option in written.options
    ]
    return WrittenDomain(kind, tuple(options))


def _separate(check: Expressions, e: s.Expr, what: str) -> WrittenDomain:
    """Check a domain of separate, equally likely values."""
    written = read_domain(check, e)
    if written.spread is not None or written.weights is not None:
        check.fail("WMS401", f"{what} takes lists and ranges of separate values", e.span, _WRITE)
    return written


def conditions(check: Expressions, written: WrittenDomain) -> tuple[tuple[Level, ir.Expr], ...]:
    """Return the distinct values of a domain in order, each with its condition."""
    ways_of: dict[Level, list[ir.Expr]] = {}
    for option in written.options:
        ways_of.setdefault(option.value, []).append(_all(check, option.when))
    return tuple((value, _operation("or", ways)) for value, ways in ways_of.items())


def labels(written: WrittenDomain) -> tuple[str, ...] | None:
    """Return the labels of the distinct values, in order, or None if they have none."""
    called: dict[Level, str] = {}
    for option in written.options:
        called.setdefault(option.value, option.name)
    return tuple(called.values()) if any(called.values()) else None


def _all(check: Expressions, when: tuple[Condition, ...]) -> ir.Expr:
    parts: list[ir.Expr] = []
    for condition, holds in when:
        expr = check.value(condition, (TRUTH,), "`if`").expr
        parts.append(expr if holds else ir.Operation(operator="not", operands=(expr,)))
    return _operation("and", parts) if parts else ir.Value(value=True)


def _operation(operator: str, operands: list[ir.Expr]) -> ir.Expr:
    return operands[0] if len(operands) == 1 else ir.Operation(operator=operator, operands=tuple(operands))


# ---------------------------------------------------------------- products and distributions


def _product(check: Expressions, e: s.Call) -> WrittenDomain:
    """Check a Cartesian product of coordinate lists."""
    arguments = _arguments(check, e, (2, 3), "a list for each coordinate")
    lists = [_separate(check, a, "`product`") for a in arguments]
    kind = lists[0].type
    for written, argument in zip(lists, arguments, strict=True):
        common = common_type(kind, written.type)
        if not isinstance(common, Quantity):
            expected = kind if isinstance(kind, Quantity) else A_NUMBER
            check.type_mismatch(argument, written.type, (expected,), "`product`")
        if written.conditional:
            check.fail("WMS401", "`product` takes lists whose values are always available", argument.span)
        kind = common
    assert isinstance(kind, Quantity)
    if (size := math.prod(len(x.options) for x in lists)) > MAX_VALUES:
        check.fail("WMS401", f"this product has {size} points; {MAX_VALUES} is the maximum", e.span, "use two factors")
    points = product(*([float(o.value) for o in x.options if isinstance(o.value, float)] for x in lists))
    return WrittenDomain(Vector(kind.dimension, len(lists)), tuple(DomainValue(point, e.span) for point in points))


def _uniform(check: Expressions, e: s.Call) -> WrittenDomain:
    kind, (low, high) = _numbers(check, e, "the two ends of an interval")
    _check_increasing(check, e, low, high)
    return WrittenDomain(kind, spread=ir.Interval(low=low, high=high))


def _log_uniform(check: Expressions, e: s.Call) -> WrittenDomain:
    kind, (low, high) = _numbers(check, e, "the two ends of an interval")
    _check_increasing(check, e, low, high)
    if low <= 0:
        check.fail("WMS401", "a logarithm has no values at 0 and below", e.arguments[0].span, "begin above 0")
    return WrittenDomain(kind, spread=ir.Interval(low=low, high=high, logarithmic=True))


def _check_increasing(check: Expressions, e: s.Call, low: float, high: float) -> None:
    if high < low:
        check.fail("WMS401", "this interval is empty: it goes up from its start to its end", e.span)


def _normal(check: Expressions, e: s.Call) -> WrittenDomain:
    kind, (mean, deviation) = _numbers(check, e, "a mean and a standard deviation")
    if deviation <= 0:
        check.fail("WMS401", "a standard deviation is more than 0", e.arguments[1].span)
    return WrittenDomain(kind, spread=ir.Normal(mean=mean, deviation=deviation))


def _weighted(check: Expressions, e: s.Call) -> WrittenDomain:
    values, weights = _arguments(check, e, (2,), "a list of values and a list of their weights")
    written = _separate(check, values, "`weighted`")
    numbers = tuple(_weights(check, weights))
    if len(numbers) != len(written.options):
        what = f"there are {len(written.options)} values, but {len(numbers)} of weights"
        check.fail("WMS401", what, weights.span, "give one weight for each value")
    return replace(written, weights=numbers)


def _weights(check: Expressions, e: s.Expr) -> Iterator[float]:
    typed = check.value(e, (List(A_NUMBER),), "`weighted`")
    for item in typed.expr.items if isinstance(typed.expr, ir.Items) else (typed.expr,):
        weight = constant(item)
        if weight is None or weight <= 0:
            check.fail("WMS401", "a weight is a constant more than 0", e.span, "remove values that are never drawn")
        yield weight


def _arguments(check: Expressions, e: s.Call, counts: tuple[int, ...], what: str) -> tuple[s.Expr, ...]:
    assert isinstance(e.function, s.Name)
    named = next((a.name for a in e.arguments if a.name), None)
    if named is not None:
        check.fail("WMS205", f"`{e.function.id}` has no option `{named.id}`", named.span, f"it takes {what}, in order")
    if len(e.arguments) not in counts:
        many = " or ".join(map(str, counts))
        check.fail("WMS205", f"`{e.function.id}` takes {many} arguments: {what}", e.span)
    return tuple(a.value for a in e.arguments)


def _numbers(check: Expressions, e: s.Call, what: str) -> tuple[Type, tuple[float, float]]:
    """Return two constant quantities of one type."""
    first, second = _arguments(check, e, (2,), what)
    a, b = check.infer(first), check.infer(second)
    assert isinstance(e.function, s.Name)
    if not isinstance(a.type, Quantity):
        check.fail("WMS302", f"`{e.function.id}` expects quantities, found {article(str(a.type))}", first.span)
    kind = common_type(a.type, b.type)
    if kind is None:
        check.type_mismatch(second, b.type, (a.type,), f"`{e.function.id}`, like its first argument,")
    return kind, (_number(check, a.expr, first.span), _number(check, b.expr, second.span))


#: Domains that are written as calls.
FORMS: dict[str, Callable[[Expressions, s.Call], WrittenDomain]] = {
    "product": _product,
    "uniform": _uniform,
    "log_uniform": _log_uniform,
    "normal": _normal,
    "weighted": _weighted,
}
