"""Rules on the options of a question, before anything happens: they coincide, or lack the answer."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

from wmspec.compile.design.depend import Dependencies
from wmspec.compile.design.describe import told_of
from wmspec.compile.design.design import Design, Instance
from wmspec.compile.layout.values import Values
from wmspec.compile.lint.question_rules import asked
from wmspec.compile.lint.rule import Breach, rule
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.expressions.measured import measured
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Question
from wmspec.lang.check.types import units
from wmspec.lang.check.types.types import AN_ANGLE

#: Of how many instances the options are compared.
COMPARED = 100


@dataclass(frozen=True)
class Options:
    """The options of a question in a sample of instances.

    `coinciding` is what two options are, with the instance; `lacking` are answers that are no option, of `checked`
    instances in which the answer is known.
    """

    question: Question
    design: Design
    coinciding: tuple[object, Instance] | None
    lacking: tuple[tuple[object, Instance], ...]
    checked: int


@dataclass(frozen=True)
class Tried:
    """A question, and the values of the instances whose scenes are built."""

    question: Question
    values: tuple[Values, ...]


def compared(question: Question, design: Design, depend: Dependencies) -> Options:
    """The options compared, up to the first instance in which two are the same. Raises WmsError without a value."""
    known = not measured(design.spec, question.answer)
    directions = question.sort == str(AN_ANGLE) and not known
    lacking, checked = [], 0
    for instance in _sample(question, design, depend, known):
        values = Values(design.spec, instance.values, None, instance.key)
        options = evaluate(question.options, values) if question.options else ()
        same = [a for a, b in combinations(options, 2) if _same(a, b, directions)]
        answer = _answer(question, values) if known else None
        if (not same and answer is None) or not asked(question, values):
            continue
        if same:
            return Options(question, design, (same[0], instance), (), checked)
        checked += 1
        if question.options is not None and not any(_same(answer, option, directions) for option in options):
            lacking.append((answer, instance))
    return Options(question, design, None, tuple(lacking), checked)


@rule("WMS507", "error")
def coinciding_options(options: Options) -> Iterator[Breach]:
    """Two options that are the same in an instance."""
    if options.coinciding is not None:
        value, instance = options.coinciding
        where = told_of(options.design, instance)
        what = f"two options of this question are the same, {_shown(value, options.question)}, {where}"
        yield Breach(what, options.question.place, "keep them apart with `require`")


@rule("WMS502", "error")
def answer_never_among_options(options: Options) -> Iterator[Breach]:
    """An answer that is in no instance among the options."""
    if options.lacking and len(options.lacking) == options.checked:
        what = f"in no instance is the answer among the options: it is {_first_lacking(options)}"
        yield Breach(what, options.question.place, "add it to the options")


@rule("WMS502")
def answer_not_always_among_options(options: Options) -> Iterator[Breach]:
    """An answer that is in some instances not among the options."""
    if 0 < len(options.lacking) < options.checked:
        what = f"the answer is not among the options: it is {_first_lacking(options)}"
        remedy = "add it to the options, or exclude this with `require`"
        yield Breach(what, options.question.place, remedy)


@rule("WMS509", "error")
def condition_never_met(tried: Tried) -> Iterator[Breach]:
    """An `ensure` that is known before the episode, and holds in none of the instances that are tried."""
    for ensure in tried.question.ensures:
        if not tried.values or measured(tried.values[0].spec, ensure.condition):
            continue
        if not any(evaluate(ensure.condition, values) for values in tried.values):
            what = f"this holds in none of the {len(tried.values)} instances that were tried: nothing is asked"
            yield Breach(what, ensure.place, "mend the condition, or exclude its opposite with `require`")


ALWAYS = (condition_never_met,)
RULES = (coinciding_options, answer_never_among_options, answer_not_always_among_options)


def _first_lacking(options: Options) -> str:
    answer, instance = options.lacking[0]
    return f"{_shown(answer, options.question)}, {told_of(options.design, instance)}"


def _sample(question: Question, design: Design, depend: Dependencies, known: bool) -> Iterator[Instance]:
    """Instances in which the options, or a known answer, may differ."""
    expressions = [e for e in (question.options, question.answer if known else None) if e is not None]
    deciding = frozenset[str]().union(*map(depend.expression, expressions))
    varies = deciding & {f.name for f in design.spec.factors}
    return (design[index] for index in design.sample(COMPARED if varies else 1))


def _answer(question: Question, values: Values) -> object:
    """The answer; None if it has no value here, which is told when it is asked."""
    try:
        return evaluate(question.answer, values)
    except WmsError:
        return None


def _same(a: object, b: object, directions: bool) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        apart = math.remainder(a - b, 2 * math.pi) if directions else a - b
        return abs(apart) <= 1e-9 * max(1.0, abs(a))
    return a == b


def _shown(value: object, question: Question) -> str:
    return units.told(value, units.named(question.sort)) if isinstance(value, float) else f"`{value}`"
