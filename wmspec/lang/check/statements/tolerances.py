"""Checks tolerances: allowed disagreement between engines."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress

from wmspec.core.diagnostics import Note, suggestion
from wmspec.core.places import Span
from wmspec.lang.check.expressions.bounds import check_bounds
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import Failed, constant
from wmspec.lang.check.tables.vocabulary import TOLERANCES
from wmspec.lang.parse import syntax as s


def tolerances(check: Expressions, written: Iterable[s.Tolerance]) -> dict[str, float]:
    """Return the tolerances (SI) by name; wrong ones are reported and left out."""
    checked: dict[str, float] = {}
    spans: dict[str, Span] = {}
    for tolerance in written:
        name = tolerance.name
        if name.id in spans:
            notes = (Note("first set here", spans[name.id]),)
            check.report.add("WMS202", f"the tolerance `{name.id}` is set twice", name.span, "remove one", notes)
        spans.setdefault(name.id, name.span)
        with suppress(Failed):
            checked[name.id] = _tolerance(check, tolerance)
    return checked


def _tolerance(check: Expressions, tolerance: s.Tolerance) -> float:
    name = tolerance.name
    if name.id not in TOLERANCES:
        message = f"there is no tolerance `{name.id}`"
        check.fail("WMS203", message, name.span, suggestion(name.id, TOLERANCES))
    slot = TOLERANCES[name.id]
    typed = check.value(tolerance.value, slot.types, f"`{name.id}`")
    check_bounds(check, typed.expr, slot, tolerance.value.span, f"`{name.id}`")
    value = constant(typed.expr)
    if value is None:
        check.fail("WMS304", "a tolerance is a constant", tolerance.value.span, "write a quantity")
    return value
