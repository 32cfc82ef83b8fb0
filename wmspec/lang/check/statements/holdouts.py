"""Checks hold-outs: levels of factors, and combinations of levels, that training never sees."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace

from wmspec.core.diagnostics import Note
from wmspec.core.places import Location, Span
from wmspec.lang.check.expressions.domains import Level, read_domain
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import Failed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.statements.factors import Factors
from wmspec.lang.parse import syntax as s

_WRITE = "write `holdout color in [purple]`, or `holdout (shape, color) in [(cone, blue)]`"
_Seen = dict[frozenset[tuple[str, Level]], Span]


def holdouts(factors: Factors, written: Iterable[s.Holdout]) -> tuple[ir.Holdout, ...]:
    """Return the hold-outs; wrong ones are reported and left out."""
    checked: list[ir.Holdout] = []
    seen: _Seen = {}
    for one in written:
        with suppress(Failed):
            checked.append(_holdout(factors, one, seen))
            _check_rest(factors, one, checked)
    return tuple(checked)


def _holdout(factors: Factors, written: s.Holdout, seen: _Seen) -> ir.Holdout:
    check = factors.check
    named = _factors(factors, written.target)
    items = written.levels
    if not isinstance(items, s.Items) or items.kind != "list":
        check.fail("WMS401", "the levels of a hold-out are a list", items.span, _WRITE)
    if not items.items:
        check.fail("WMS401", "this hold-out has no levels", items.span, _WRITE)
    names = tuple(named)
    levels = []
    for item in items.items:
        values = tuple(_levels(factors, list(named.values()), item, items.unit))
        key = frozenset(zip(names, values, strict=True))
        if key in seen:
            notes = (Note("held out here first", seen[key]),)
            check.fail("WMS202", f"`{item.span.text}` is held out twice", item.span, "remove one", notes)
        seen[key] = item.span
        levels.append(values)
    return ir.Holdout(factors=names, levels=tuple(levels), place=Location.of(written.span))


def _factors(factors: Factors, target: s.Expr) -> dict[str, s.Factor]:
    """Return the factors before `in`, by name."""
    check, named = factors.check, dict[str, s.Factor]()
    for e in target.items if isinstance(target, s.Items) and target.kind == "tuple" else (target,):
        if not isinstance(e, s.Name):
            check.fail("WMS101", "a hold-out names factors, in parentheses if there are several", e.span, _WRITE)
        known = check.scope.names.get(e.id)
        if isinstance(known, s.Factor) and known.nuisance:
            notes = (Note("declared here", known.name.span),)
            remedy = "make it a factor, and vary it in the design"
            check.fail("WMS408", f"`{e.id}` is a nuisance, and only factors have hold-outs", e.span, remedy, notes)
        factor = factors.declared(e.id, e.span)
        if e.id in named:
            check.fail("WMS202", f"`{e.id}` is named twice", e.span, "name it once")
        if read_domain(check, factor.domain).spread is not None:
            notes = (Note("its values", factor.domain.span),)
            message = f"`{e.id}` has no separate values that could be held out"
            check.fail("WMS408", message, e.span, "give it a list or a range with steps", notes)
        named[e.id] = factor
    return named


def _levels(factors: Factors, named: list[s.Factor], item: s.Expr, unit: str | None) -> Iterator[Level]:
    """Yield the level of each factor in an item of the list."""
    if len(named) == 1:
        if unit is not None:
            item = _with_unit(item, unit)
        yield factors.level(named[0], item)
        return
    levels = item.items if isinstance(item, s.Items) and item.kind == "tuple" else ()
    if len(levels) != len(named) or unit is not None:
        message = f"each combination has {len(named)} levels, one of each factor" if unit is None else (
            "levels of several factors have units of their own"
        )  # fmt: skip
        factors.check.fail("WMS401", message, item.span, _WRITE)
    yield from map(factors.level, named, levels)


def _with_unit(item: s.Expr, unit: str) -> s.Expr:
    """Return a number with the unit of its list."""
    if isinstance(item, s.Number) and item.unit is None:
        return replace(item, unit=unit)
    if isinstance(item, s.Operation) and len(item.operands) == 1:
        return replace(item, operands=(_with_unit(item.operands[0], unit),))
    return item


def _check_rest(factors: Factors, written: s.Holdout, checked: list[ir.Holdout]) -> None:
    """Report a hold-out after which a factor has no level left for training."""
    for name in checked[-1].factors:
        factor = factors.declared(name, written.target.span)
        out = {combination for one in checked if one.factors == (name,) for combination in one.levels}
        if out >= {(option.value,) for option in read_domain(factors.check, factor.domain).options}:
            notes = (Note("its levels", factor.domain.span),)
            message = f"every level of `{name}` is held out, so that nothing is left for training"
            factors.check.fail("WMS408", message, written.levels.span, "leave some levels for training", notes)


def check_holdouts(check: Expressions, spec: ir.TaskSpec, written: Iterable[s.Statement]) -> None:
    """Report questions of which the options show held-out levels even where the instance has none."""
    written = tuple(written)
    outs = [x for x in written if isinstance(x, s.Holdout)]
    spans = {Location.of(x.text.span): x.text.span for x in written if isinstance(x, s.Question)}
    for question in spec.questions:
        shown = {varied.factor for varied in question.orbit}
        shown.update(name for change in question.counterfactuals for name in change.levels)
        for span, name in ((x.target.span, name.id) for x in outs for name in s.nodes(x.target, s.Name)):
            if name in shown:
                notes = (Note("the question is here", spans.get(question.place, question.place)),)
                message = f"the options of a question show other levels of `{name}`, so training sees all of them"
                check.report.add("WMS408", message, span, "hold out another factor", notes)
