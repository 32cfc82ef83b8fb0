"""The changes of the what-ifs and causes of a question."""

from __future__ import annotations

from collections.abc import Iterator

from wmspec.compile.design.depend import Dependencies
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.lang.check.ir.evaluate import Unchanged, evaluate, resolved, subexpressions, without
from wmspec.lang.check.ir.ir import Cause, Counterfactual, Expr, Question, WhatIf


def what_ifs(question: Question, values: Evaluator) -> tuple[Counterfactual, ...]:
    """Return the changes that a question imagines in an instance, each once, without those that equal it."""
    changes: dict[str, Counterfactual] = {}
    for part in _what_ifs(question):
        found = [resolved(part.change, values)] if isinstance(part, WhatIf) else _candidates(part, values)
        for change in found:
            try:
                values.under(change)
            except Unchanged:
                continue
            changes.setdefault(change.name, change)
    return tuple(changes.values())


def possible_what_ifs(question: Question, depend: Dependencies) -> tuple[Counterfactual, ...]:
    """Return the changes that a question may imagine in any instance, each once."""
    changes: dict[str, Counterfactual] = {}
    for part in _what_ifs(question):
        if isinstance(part, Cause):
            found = [without(name, part.place) for name in sorted(depend.named(part.candidates))]
        elif part.change.value is not None and not part.change.owner:
            found = [without(name, part.change.place) for name in sorted(depend.named(part.change.value))]
        else:
            found = [part.change]
        changes |= {change.name: change for change in found}
    return tuple(changes.values())


def imagines(question: Question) -> bool:
    """Whether a question has a what-if or a cause."""
    return any(True for _ in _what_ifs(question))


def _candidates(cause: Cause, values: Evaluator) -> list[Counterfactual]:
    return [without(name, cause.place) for name in evaluate(cause.candidates, values)]


def _what_ifs(question: Question) -> Iterator[WhatIf | Cause]:
    """Yield the what-ifs and causes in the measured expressions of a question."""
    for expr in _measured(question):
        for part in subexpressions(expr):
            if isinstance(part, WhatIf | Cause):
                yield part


def _measured(question: Question) -> Iterator[Expr]:
    yield question.answer
    for margin in question.margins:
        yield from (e for e in (margin.value, margin.unless) if e is not None)
    yield from (ensure.condition for ensure in question.ensures)
    yield from (outcome.condition for outcome in question.kinds)
    if question.difference is not None:
        yield question.difference.value
