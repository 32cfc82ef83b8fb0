"""Checks what-ifs (`value without ball`, `value under CHANGE`) and causes (`cause of CONDITION among [a, b]`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.core.places import Location, Span
from wmspec.lang.check.expressions.typed import Typed, fits
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.evaluate import subexpressions
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.types.types import ACTION, OBJECT, TRUTH, List, article
from wmspec.lang.parse import syntax as s

if TYPE_CHECKING:
    from wmspec.lang.check.expressions.expressions import Expressions

#: A function whose value is a picture of the executed episode.
_PICTURE = "frame"


def what_if(check: Expressions, e: s.WhatIf) -> Typed:
    """Check a value in the episode with one change."""
    word = "without" if e.change.kind == "without" else "under"
    _require_measuring(check, e, f"`{word}` changes the executed episode")
    value = _inside(check, e.value)
    if not _is_executed(value.expr):
        message = f"`{e.value.span.words}` does not depend on what happens, so a change makes no difference"
        remedy = "ask for something measured on the episode, such as `contact(a, b)`"
        check.fail("WMS503", message, e.value.span, remedy)
    change = check.change_of(e.change)
    if change.change == "without" and change.owner:
        _require_not_measured(check, e.value, change.owner)
    return Typed(ir.WhatIf(value=value.expr, change=change), value.type)


def cause(check: Expressions, e: s.Cause) -> Typed:
    """Check the one of several objects or actions without which a condition does not hold."""
    _require_measuring(check, e, "a cause is found by executing the episode without each candidate")
    condition = _inside(check, e.condition)
    if not fits(condition.type, TRUTH):
        check.type_mismatch(e.condition, condition.type, (TRUTH,), "`cause of`")
    if not _is_executed(condition.expr):
        message = f"`{e.condition.span.words}` does not depend on what happens, so it has no cause"
        check.fail("WMS503", message, e.condition.span, "write something measured, such as `toppled(tower)`")
    kinds = List(OBJECT), List(ACTION)
    candidates = check.infer(e.candidates, kinds)
    if not any(fits(candidates.type, kind) for kind in kinds) or candidates.type == List(None):
        remedy = "write `among [a, b]`, the candidates"
        message = f"`among` expects a list of objects or of actions, found {article(str(candidates.type))}"
        check.fail("WMS302", message, e.candidates.span, remedy)
    if isinstance(candidates.expr, ir.Items):
        for item in candidates.expr.items:
            if isinstance(item, ir.Value):
                _require_not_measured(check, e.condition, str(item.value))
    kind = OBJECT if fits(candidates.type, List(OBJECT)) else ACTION
    made = ir.Cause(condition=condition.expr, candidates=candidates.expr, place=Location.of(e.span))
    return Typed(made, kind)


def _require_measuring(check: Expressions, e: s.WhatIf | s.Cause, why: str) -> None:
    """Report a what-if or cause outside answers and gates, or within another one."""
    if check.imagining:
        message = "a what-if is one change, and this is a second one"
        check.fail("WMS503", message, e.span, "ask about each change in a question of its own")
    if not check.measured:
        message = f"{why}, and this describes the episode"
        check.fail("WMS303", message, e.span, "use it in `answer`, `ensure` or `margin`")


def _inside(check: Expressions, e: s.Expr) -> Typed:
    """Check an expression that is evaluated in a changed episode."""
    check.imagining = True
    try:
        return check.infer(e)
    finally:
        check.imagining = False


def _is_executed(expr: ir.Expr) -> bool:
    """Whether a value depends on the executed episode."""
    calls = (part.function for part in subexpressions(expr) if isinstance(part, ir.Call))
    return any(name == _PICTURE or (name in FUNCTIONS and bool(FUNCTIONS[name].measured)) for name in calls)


def _require_not_measured(check: Expressions, written: s.Expr, removed: str) -> None:
    """Report a measure of the object that is removed."""
    span = _measured_at(check, written, removed)
    if span is not None:
        message = f"`{span.text}` is measured here, and without it there is nothing to measure"
        check.fail("WMS503", message, span, "measure what the change may have an effect on")


def _measured_at(check: Expressions, written: s.Expr, removed: str) -> Span | None:
    """Return where an argument of a measured function is the removed object, or None."""
    for call in s.nodes(written, s.Call):
        function = FUNCTIONS.get(call.function.id) if isinstance(call.function, s.Name) else None
        if function is None or not function.measured or function.chooses:
            continue
        for argument in call.arguments:
            if argument.name is None and check.infer(argument.value).expr == ir.Value(value=removed):
                return argument.value.span
    return None
