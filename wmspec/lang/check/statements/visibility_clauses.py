"""Checks `may hide` and `seen`: the pictures in which objects of a question must be visible."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from wmspec.core.diagnostics import Note
from wmspec.core.places import Location, Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import Typed, without_failed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.types.types import A_TIME, OBJECT, List
from wmspec.lang.parse import syntax as s

#: `seen none`: no object of the question must be visible.
NONE = "none"


def visibility(check: Expressions, clauses: Sequence[s.Clause]) -> tuple[ir.Visibility, ...]:
    """Return the declared visibility of objects. Errors are reported, and their clauses left out."""
    ordered = sorted(clauses, key=lambda each: each.span.start)
    made = [each for group in without_failed(partial(_visibility, check), ordered) for each in group]
    _report_conflicts(check, made, {Location.of(clause.span): clause.span for clause in clauses})
    return tuple(made)


def _visibility(check: Expressions, clause: s.Clause) -> list[ir.Visibility]:
    """Return the declared visibility of every object, or set, that a clause lists."""
    place = Location.of(clause.span)
    if _is_none(check, clause):
        if clause.bound is not None:
            check.fail("WMS304", "`seen none` has no times", clause.bound.span, "remove them")
        return [ir.Visibility(objects=None, times=None, place=place)]
    what = "`may hide`" if clause.kind == "hide" else "`seen`"
    listed = (
        clause.value.items if isinstance(clause.value, s.Items) and clause.value.kind == "list" else (clause.value,)
    )
    objects = [check.value(item, (OBJECT, List(OBJECT)), what).expr for item in listed]
    if clause.kind == "hide":
        return [ir.Visibility(objects=each, times=None, place=place) for each in objects]
    if clause.bound is None:
        remedy = (
            f"say when: `seen {clause.value.span.text} at [0 s]`; without a clause it must be seen in every picture"
        )
        check.fail("WMS304", "`seen` has no times", clause.span, remedy)
    times = _times(check, clause.bound).expr
    return [ir.Visibility(objects=each, times=times, place=place) for each in objects]


def _is_none(check: Expressions, clause: s.Clause) -> bool:
    value = clause.value
    return clause.kind == "seen" and isinstance(value, s.Name) and value.id == NONE and NONE not in check.scope.names


def _times(check: Expressions, written: s.Expr) -> Typed:
    """Return the times as a list; a single time is a list of one."""
    typed = check.value(written, (List(A_TIME), A_TIME), "`at`")
    return Typed(ir.Items(items=(typed.expr,)), List(A_TIME)) if typed.type == A_TIME else typed


def _report_conflicts(check: Expressions, made: Sequence[ir.Visibility], spans: dict[Location, Span]) -> None:
    """Report an object in two clauses, and clauses beside `seen none`."""
    first = dict[str, ir.Visibility]()
    everything = next((each for each in made if each.objects is None), None)
    for each in made:
        if everything is not None and each is not everything:
            notes = (Note("no object must be visible", spans[everything.place]),)
            check.report.add("WMS202", "`seen none` holds for every object", spans[each.place], "remove one", notes)
        for name in _constant_names(each):
            if first.setdefault(name, each) is not each:
                notes = (Note("first set here", spans[first[name].place]),)
                what = f"when `{name}` must be visible is set twice"
                check.report.add("WMS202", what, spans[each.place], "remove one", notes)


def _constant_names(each: ir.Visibility) -> Iterator[str]:
    """Yield the names of objects that do not depend on factors."""
    items = each.objects.items if isinstance(each.objects, ir.Items) else (each.objects,)
    yield from (item.value for item in items if isinstance(item, ir.Value) and isinstance(item.value, str))
