"""What can be said against a task without building any of its scenes: statements that decide nothing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from wmspec.check.ir import Choices, Expr, Said, TaskSpec
from wmspec.check.measured import measured
from wmspec.design.constrain import Constraint
from wmspec.design.depend import Dependencies
from wmspec.places import Location

#: A code, a message, its place and a remedy.
Doubt = tuple[str, str, Location, str]


def doubts(spec: TaskSpec) -> Iterator[Doubt]:
    """Factors on which nothing depends, or words alone, and answers that depend on nothing."""
    depend = Dependencies(spec)
    yield from _idle_factors(spec, depend)
    yield from _constant_answers(spec, depend)


def idle_requires(spec: TaskSpec, conditions: Sequence[Constraint]) -> Iterator[Doubt]:
    """Conditions that every combination meets."""
    for said, require in enumerate(spec.requires):
        if all(len(c.allowed) == c.tries for c in conditions if c.said == said):
            yield "WMS406", "this `require` excludes nothing", require.place, "remove it, or mend its condition"


def short_sample(spec: TaskSpec, size: int) -> Iterator[Doubt]:
    """A sample that is larger than what there is to choose from, which is `size` instances."""
    if spec.plan.kind == "sample" and spec.plan.count and spec.plan.place and size < spec.plan.count:
        message = f"a sample of {spec.plan.count} is asked for, but there are only {size} combinations"
        yield "WMS408", message, spec.plan.place, "ask for fewer, widen a domain, or say `repeat`"


def _idle_factors(spec: TaskSpec, depend: Dependencies) -> Iterator[Doubt]:
    deciding = _with_tied(spec, depend, _reached(depend, _deciding(spec)))
    told = _with_tied(spec, depend, _reached(depend, _texts(spec)))
    for factor in spec.factors:
        name, what = factor.name, "nuisance" if factor.nuisance else "factor"
        if name not in deciding | told:
            remedy = "use it in an object, action or question, or remove it"
            yield "WMS403", f"nothing depends on the {what} `{name}`", factor.place, remedy
        elif name not in deciding and not factor.nuisance:
            message = f"`{name}` changes the words of a question, but neither the scene nor an answer"
            yield "WMS409", message, factor.place, "let an answer depend on it, or make it a nuisance"


def _with_tied(spec: TaskSpec, depend: Dependencies, names: frozenset[str]) -> frozenset[str]:
    """Names, with those of the factors that conditions tie to them: these decide which values they can have."""
    factors = {f.name for f in spec.factors}
    ties = [depend.expression(r.condition) & factors for r in spec.requires]
    domains = {f.name: f.domain.when for f in spec.factors if isinstance(f.domain, Choices) and f.domain.when}
    ties += [(_reached(depend, when) & factors) | {name} for name, when in domains.items()]
    while True:
        wider = names.union(*(tie for tie in ties if tie & names))
        if wider == names:
            return names
        names = wider


def _constant_answers(spec: TaskSpec, depend: Dependencies) -> Iterator[Doubt]:
    varying = {f.name for f in spec.factors}
    for question in spec.questions:
        if not measured(spec, question.answer) and not depend.expression(question.answer) & varying:
            message = "the answer to this is the same in every instance"
            yield "WMS506", message, question.place, "let it depend on a factor, or measure it on the episode"


def _texts(spec: TaskSpec) -> Iterator[Expr]:
    for question in spec.questions:
        yield from (part.value for part in question.text if isinstance(part, Said))


def _deciding(spec: TaskSpec) -> Iterator[Expr]:
    """All that decides what is there, what happens, what is seen, and what can be answered."""
    yield spec.horizon
    for thing in spec.things:
        yield from (setting.value for setting in thing.properties.values())
    yield from (observation.times for observation in spec.observations)
    for q in spec.questions:
        gates = (e for m in q.margins for e in (m.value, m.bound, m.unless))
        changed = (c.value for c in q.counterfactuals)
        some = (q.options, q.distinct, q.within, q.stable, *gates, *changed, *(e.condition for e in q.ensures))
        yield q.answer
        yield from (e for e in some if e is not None)


def _reached(depend: Dependencies, expressions: Iterable[Expr]) -> frozenset[str]:
    return frozenset[str]().union(*map(depend.expression, expressions))
