"""Objects that a question depends on through its text, options and answer."""

from __future__ import annotations

from wmspec.compile.design.depend import dependencies
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.lang.check.ir.evaluate import evaluate, reachable
from wmspec.lang.check.ir.ir import Expr, Interpolation, Question, Ref, Value, WhatIf


def referenced_objects(question: Question, values: Evaluator) -> set[str]:
    """Return the present objects that the text, the options or the answer name, also through a `let`.

    If none is named, these are the objects with a property that depends on the factors of the answer. For example,
    `answer tone` depends on every object with `color: tone`.
    """
    said = [*question.text, *(part for text in question.texts for part in text.parts)]
    spoken: list[Expr] = [part.value for part in said if isinstance(part, Interpolation)]
    spoken += [question.answer] if question.options is None else [question.answer, question.options]
    things = {t.name: t for t in values.spec.things}
    names: set[str] = set()
    for part in reachable(spoken, {let.name: let.value for let in values.spec.lets}):
        if isinstance(part, WhatIf) and part.change.owner:
            names.add(part.change.owner)
        if isinstance(part, Value | Ref):
            value = evaluate(part, values)
            names.update(v for v in (value if isinstance(value, tuple) else (value,)) if isinstance(v, str))
    for joint in [name for name in names if name in things and things[name].kind == "joint"]:
        names.add(values.reference(joint, "of"))  # a joint is visible only through the objects that it moves
    if not any(name in things and things[name].kind == "object" for name in names):
        names |= _objects_depending_on(question.answer, values)
    return names


def _objects_depending_on(answer: Expr, values: Evaluator) -> set[str]:
    """Return the objects with a property that depends on a factor or nuisance of the answer."""
    depend, factors = dependencies(values.spec), {f.name for f in values.spec.factors}
    decisive = depend.expression(answer) & factors
    return {
        thing.name
        for thing in values.spec.things
        if thing.kind == "object" and any(decisive & depend.source(f"{thing.name}.{name}") for name in thing.properties)
    }
