"""What a question is about: the objects that its text, its options and its answer depend on."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from wmspec.compile.design.depend import dependencies
from wmspec.compile.layout.values import Values
from wmspec.lang.check.ir.evaluate import evaluate, parts
from wmspec.lang.check.ir.ir import Expr, Question, Ref, Said, Value


def named(question: Question, values: Values) -> set[str]:
    """The objects that are there and that the text, the options or the answer speak of, if need be by a `let`.

    If none is named, it is those whose look or place shows what the answer rests on: `answer tone` is about what has
    `color: tone`.
    """
    said = [*question.text, *(part for text in question.texts for part in text.parts)]
    spoken: list[Expr] = [part.value for part in said if isinstance(part, Said)]
    spoken += [question.answer] if question.options is None else [question.answer, question.options]
    things = {t.name: t for t in values.spec.things}
    names: set[str] = set()
    for part in _spelled_out(spoken, values):
        if isinstance(part, Value | Ref):
            value = evaluate(part, values)
            names.update(v for v in (value if isinstance(value, tuple) else (value,)) if isinstance(v, str))
    for joint in [name for name in names if name in things and things[name].kind == "joint"]:
        names.add(values.reference(joint, "of"))  # what is said of a joint is seen on what it moves
    if not any(name in things and things[name].kind == "object" for name in names):
        names |= _showing(question.answer, values)
    return names


def _spelled_out(spoken: Iterable[Expr], values: Values) -> Iterator[Expr]:
    """All that expressions are made of, and what the named values in them are made of."""
    lets = {let.name: let.value for let in values.spec.lets}
    waiting, seen = list(spoken), set[str]()
    while waiting:
        for part in parts(waiting.pop()):
            yield part
            if isinstance(part, Ref) and part.name in lets and part.name not in seen:
                seen.add(part.name)
                waiting.append(lets[part.name])


def _showing(answer: Expr, values: Values) -> set[str]:
    """The objects a property of which depends on a factor or nuisance on which the answer depends."""
    depend, factors = dependencies(values.spec), {f.name for f in values.spec.factors}
    decisive = depend.expression(answer) & factors
    return {
        thing.name
        for thing in values.spec.things
        if thing.kind == "object" and any(decisive & depend.source(f"{thing.name}.{name}") for name in thing.properties)
    }
