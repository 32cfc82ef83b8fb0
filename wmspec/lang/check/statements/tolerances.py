"""Checks tolerances: allowed disagreement between engines."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from wmspec.core.diagnostics import suggestion
from wmspec.lang.check.expressions.bounds import check_bounds
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import constant, without_failed
from wmspec.lang.check.tables.vocabulary import TOLERANCES
from wmspec.lang.parse import syntax as s


def tolerances(check: Expressions, written: Iterable[s.Tolerance]) -> dict[str, float]:
    """Return the tolerances (SI) by name; wrong ones are reported and left out."""
    every = list(written)
    check.report.add_set_twice(((x.name.id, x.name.span) for x in every), "the tolerance `{}` is set twice")
    return dict(without_failed(partial(_tolerance, check), every))


def _tolerance(check: Expressions, tolerance: s.Tolerance) -> tuple[str, float]:
    """Return the name and the value."""
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
    return name.id, value
