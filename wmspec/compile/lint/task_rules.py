"""Rules on a task and its design, checked without scenes: what has no effect, and samples that are too large."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from wmspec.compile.design.depend import Dependencies
from wmspec.compile.design.design import Design
from wmspec.compile.lint.rule import Breach, rule
from wmspec.lang.check.expressions.measured import is_measured
from wmspec.lang.check.ir.evaluate import subexpressions
from wmspec.lang.check.ir.ir import Choices, Expr, Interpolation, Items, Property, TaskSpec, Value

#: Properties that no picture shows, and those that it shows.
_INVISIBLE = ("mass", "density", "friction", "restitution")
_LOOKS = ("form", "color", "material", "image")


@dataclass(frozen=True)
class LintTask:
    """A task with its dependencies."""

    spec: TaskSpec
    depend: Dependencies


@rule("WMS403")
def idle_factor(task: LintTask) -> Iterator[Breach]:
    """Find factors and nuisances without effect."""
    used = _dependencies(task, _effective_expressions(task.spec)) | _dependencies(task, _texts(task.spec))
    for factor in task.spec.factors:
        if factor.name not in used:
            message = f"nothing depends on the {'nuisance' if factor.nuisance else 'factor'} `{factor.name}`"
            yield Breach(message, factor.place, "use it in an object, action or question, or remove it")


@rule("WMS409")
def factor_in_words_alone(task: LintTask) -> Iterator[Breach]:
    """Find factors that only the text of a question mentions."""
    in_words_alone = _dependencies(task, _texts(task.spec)) - _dependencies(task, _effective_expressions(task.spec))
    for factor in task.spec.factors:
        if not factor.nuisance and factor.name in in_words_alone:
            message = f"`{factor.name}` changes the words of a question, but neither the scene nor an answer"
            yield Breach(message, factor.place, "let an answer depend on it, or make it a nuisance")


@rule("WMS506")
def constant_answer(task: LintTask) -> Iterator[Breach]:
    """Find answers that are known beforehand and depend on no factor."""
    varying = {f.name for f in task.spec.factors}
    for question in task.spec.questions:
        if question.asks_possible:
            continue  # `require_violation` checks these
        if not is_measured(task.spec, question.answer) and not task.depend.expression(question.answer) & varying:
            message = "the answer to this is the same in every instance"
            yield Breach(message, question.place, "let it depend on a factor, or measure it on the episode")


@rule("WMS605")
def invisible_answer(task: LintTask) -> Iterator[Breach]:
    """Find answers from properties that a single picture cannot show, such as a mass."""
    if not _has_one_picture(task.spec):
        return
    for question in task.spec.questions:
        said = [part.value for part in question.text if isinstance(part, Interpolation)]
        for part in subexpressions(question.answer):
            match part:
                case Property(owner=Value(value=str(owner)), name=name) if name in _INVISIBLE and part not in said:
                    shown = task.depend.sources(f"{owner}.{look}" for look in _LOOKS)
                    if not task.depend.source(f"{owner}.{name}") & {f.name for f in task.spec.factors} <= shown:
                        what = f"one picture does not show `{owner}.{name}`, on which the answer depends"
                        remedy = "show what it does in more pictures, or let how the object looks depend on it"
                        yield Breach(what, question.place, remedy, about=("invisible", question.place))
                        break


def _has_one_picture(spec: TaskSpec) -> bool:
    times = [observation.times for observation in spec.observations]
    return len(times) == 1 and isinstance(times[0], Items) and len(times[0].items) == 1


RULES = (idle_factor, factor_in_words_alone, constant_answer, invisible_answer)


def _texts(spec: TaskSpec) -> Iterator[Expr]:
    for question in spec.questions:
        model_texts = (*question.film_text, *question.action_text)
        parts = (*question.text, *model_texts, *(part for text in question.texts for part in text.parts))
        yield from (part.value for part in parts if isinstance(part, Interpolation))


def _effective_expressions(spec: TaskSpec) -> Iterator[Expr]:
    """Yield the expressions that determine presence, events, visibility and answers."""
    yield spec.horizon
    for thing in spec.things:
        yield from (setting.value for setting in thing.properties.values())
    yield from (observation.times for observation in spec.observations)
    yield from (time for time in (spec.film.start, spec.film.end) if time is not None) if spec.film else ()
    for q in spec.questions:
        gates = (e for m in q.margins for e in (m.value, m.bound, m.unless))
        changed = (c.value for c in q.counterfactuals)
        some = (q.options, q.distinct, q.within, q.stable, *gates, *changed, *(e.condition for e in q.ensures))
        yield q.answer
        yield from (e for e in some if e is not None)


def _dependencies(task: LintTask, expressions: Iterable[Expr]) -> frozenset[str]:
    """Return the dependencies of expressions, with the factors tied to them by conditions."""
    factors = {f.name for f in task.spec.factors}
    ties = [task.depend.expression(r.condition) & factors for r in task.spec.requires]
    domains = {f.name: f.domain.when for f in task.spec.factors if isinstance(f.domain, Choices) and f.domain.when}
    ties += [(_sources(task, when) & factors) | {name} for name, when in domains.items()]
    reached = _sources(task, expressions)
    while (wider := reached.union(*(tie for tie in ties if tie & reached))) != reached:
        reached = wider
    return reached


def _sources(task: LintTask, expressions: Iterable[Expr]) -> frozenset[str]:
    return frozenset[str]().union(*map(task.depend.expression, expressions))


@rule("WMS406")
def idle_require(design: Design) -> Iterator[Breach]:
    """Find conditions that exclude nothing."""
    for number, require in enumerate(design.spec.requires):
        if all(len(c.allowed) == c.tries for c in design.conditions if c.statement == number):
            yield Breach("this `require` excludes nothing", require.place, "remove it, or fix its condition")


@rule("WMS408")
def short_sample(design: Design) -> Iterator[Breach]:
    """Find samples larger than the number of combinations."""
    plan, size = design.spec.plan, len(design.blocks.members(0))
    if plan.kind == "sample" and plan.count and plan.place and size < plan.count:
        message = f"a sample of {plan.count} exceeds the {size} combinations"
        yield Breach(message, plan.place, "ask for fewer, widen a domain, or say `repeat`")


DESIGN_RULES = (idle_require, short_sample)
