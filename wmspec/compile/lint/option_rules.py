"""Rules on options, before execution: duplicates and missing answers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

from wmspec.compile.design.depend import Dependencies
from wmspec.compile.design.design import Design, Instance
from wmspec.compile.design.levels import format_instance
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.lint.question_rules import is_posed
from wmspec.compile.lint.rule import Breach, rule
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.expressions.measured import is_measured
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Question
from wmspec.lang.check.types import units
from wmspec.lang.check.types.types import AN_ANGLE

#: Maximum number of instances in which options are compared.
MAX_COMPARED = 100


@dataclass(frozen=True)
class OptionSample:
    """The options of a question in a sample of instances.

    `coinciding` is the value of two equal options, with the instance. `lacking` are answers that are not an option,
    among `checked` instances with a known answer.
    """

    question: Question
    design: Design
    coinciding: tuple[object, Instance] | None
    lacking: tuple[tuple[object, Instance], ...]
    checked: int


@dataclass(frozen=True)
class SampledQuestion:
    """A question, and the values of the instances whose scenes are built."""

    question: Question
    values: tuple[Evaluator, ...]


def compare_options(question: Question, design: Design, depend: Dependencies) -> OptionSample:
    """Return the compared options, up to the first instance with two equal ones. Raises WmsError without a value."""
    known = not is_measured(design.spec, question.answer)
    directions = question.sort == str(AN_ANGLE) and not known
    lacking, checked = [], 0
    for instance in _sample(question, design, depend, known):
        values = Evaluator(design.spec, instance.values, None, instance.key)
        options = evaluate(question.options, values) if question.options else ()
        same = [a for a, b in combinations(options, 2) if _is_same(a, b, directions)]
        answer = _answer(question, values) if known else None
        if (not same and answer is None) or not is_posed(question, values):
            continue
        if same:
            return OptionSample(question, design, (same[0], instance), (), checked)
        checked += 1
        if question.options is not None and not any(_is_same(answer, option, directions) for option in options):
            lacking.append((answer, instance))
    return OptionSample(question, design, None, tuple(lacking), checked)


@rule("WMS507", "error")
def coinciding_options(options: OptionSample) -> Iterator[Breach]:
    """Find options that are equal in an instance."""
    if options.coinciding is not None:
        value, instance = options.coinciding
        where = format_instance(options.design, instance)
        what = f"two options of this question are the same, {_format_option(value, options.question)}, {where}"
        yield Breach(what, options.question.place, "keep them apart with `require`")


@rule("WMS502", "error")
def answer_never_among_options(options: OptionSample) -> Iterator[Breach]:
    """Find answers that are an option in no instance."""
    if options.lacking and len(options.lacking) == options.checked:
        what = f"in no instance is the answer among the options: it is {_first_lacking(options)}"
        yield Breach(what, options.question.place, "add it to the options")


@rule("WMS502")
def answer_not_always_among_options(options: OptionSample) -> Iterator[Breach]:
    """Find answers that are not an option in some instances."""
    if 0 < len(options.lacking) < options.checked:
        what = f"the answer is not among the options: it is {_first_lacking(options)}"
        remedy = "add it to the options, or exclude this with `require`"
        yield Breach(what, options.question.place, remedy)


@rule("WMS509", "error")
def condition_never_met(tried: SampledQuestion) -> Iterator[Breach]:
    """Find `ensure`s that are known before the episode and false in all sampled instances."""
    for ensure in tried.question.ensures:
        if not tried.values or is_measured(tried.values[0].spec, ensure.condition):
            continue
        if not any(evaluate(ensure.condition, values) for values in tried.values):
            what = f"this holds in none of the {len(tried.values)} sampled instances: the question is never asked"
            yield Breach(what, ensure.place, "fix the condition, or exclude its opposite with `require`")


ALWAYS = (condition_never_met,)
RULES = (coinciding_options, answer_never_among_options, answer_not_always_among_options)


def _first_lacking(options: OptionSample) -> str:
    answer, instance = options.lacking[0]
    return f"{_format_option(answer, options.question)}, {format_instance(options.design, instance)}"


def _sample(question: Question, design: Design, depend: Dependencies, known: bool) -> Iterator[Instance]:
    """Yield instances in which the options, or a known answer, may differ."""
    expressions = [e for e in (question.options, question.answer if known else None) if e is not None]
    deciding = frozenset[str]().union(*map(depend.expression, expressions))
    varies = deciding & {f.name for f in design.spec.factors}
    return (design[index] for index in design.sample(MAX_COMPARED if varies else 1))


def _answer(question: Question, values: Evaluator) -> object:
    """Return the answer, or None if it has no value here; execution reports that case."""
    try:
        return evaluate(question.answer, values)
    except WmsError:
        return None


def _is_same(a: object, b: object, directions: bool) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        apart = math.remainder(a - b, 2 * math.pi) if directions else a - b
        return abs(apart) <= 1e-9 * max(1.0, abs(a))
    return a == b


def _format_option(value: object, question: Question) -> str:
    return (
        units.format_quantity(value, units.dimension_named(question.sort)) if isinstance(value, float) else f"`{value}`"
    )
