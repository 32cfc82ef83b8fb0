"""What can be said against the options of a question before anything happens: they coincide, or lack the answer."""

from __future__ import annotations

import math
from itertools import combinations

from wmspec.check import units
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Question
from wmspec.check.measured import measured
from wmspec.check.types import AN_ANGLE
from wmspec.design.depend import Dependencies
from wmspec.design.describe import told_of
from wmspec.design.design import Design
from wmspec.diagnostics import Report, WmsError
from wmspec.layout.values import Values

#: Of how many instances the options are compared.
COMPARED = 100


def compare(question: Question, design: Design, report: Report) -> None:
    """Report options that are the same in one of the instances compared, or that lack an answer which is known."""
    if question.options is None:
        return
    known = not measured(design.spec, question.answer)
    depend = Dependencies(design.spec)
    deciding = depend.expression(question.options) | (depend.expression(question.answer) if known else frozenset())
    directions = question.sort == str(AN_ANGLE) and not known
    checked, lacking = 0, []
    for index in design.sample(COMPARED if deciding & {f.name for f in design.spec.factors} else 1):
        instance = design[index]
        values = Values(design.spec, instance.values, None, instance.key)
        options = evaluate(question.options, values)
        same = [a for a, b in combinations(options, 2) if _same(a, b, directions)]
        answer = _answer(question, values) if known else None
        if (not same and answer is None) or not asked(question, values):
            continue
        if same:
            what = (
                f"two options of this question are the same, {_shown(same[0], question)}, {told_of(design, instance)}"
            )
            report.add("WMS507", what, question.place, "keep them apart with `require`")
            return
        checked += 1
        if not any(_same(answer, option, directions) for option in options):
            lacking.append(f"{_shown(answer, question)}, {told_of(design, instance)}")
    if lacking:
        never = len(lacking) == checked
        what = (
            f"{'in no instance is the answer' if never else 'the answer is not'} among the options: it is {lacking[0]}"
        )
        remedy = "add it to the options" if never else "add it to the options, or exclude this with `require`"
        span = question.place
        report.add("WMS502", what, span, remedy, severity="error" if never else "warning")


def _answer(question: Question, values: Values) -> object:
    """The answer; None if it has no value here, which is told when it is asked."""
    try:
        return evaluate(question.answer, values)
    except WmsError:
        return None


def asked(question: Question, values: Values) -> bool:
    """Whether the conditions that can be looked at before the episode let the question be asked."""
    known = (e.condition for e in question.ensures if not measured(values.spec, e.condition))
    return all(evaluate(condition, values) for condition in known)


def _same(a: object, b: object, directions: bool) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        apart = math.remainder(a - b, 2 * math.pi) if directions else a - b
        return abs(apart) <= 1e-9 * max(1.0, abs(a))
    return a == b


def _shown(value: object, question: Question) -> str:
    return units.told(value, units.named(question.sort)) if isinstance(value, float) else f"`{value}`"
