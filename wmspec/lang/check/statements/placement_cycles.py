"""Checks placement: objects that rest on or are placed by one another must not form a cycle."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from graphlib import CycleError, TopologicalSorter

from wmspec.core.diagnostics import Note
from wmspec.core.places import Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.members import named
from wmspec.lang.check.ir import ir


def report_placement_cycles(check: Expressions, things: Iterable[ir.Entity]) -> None:
    """Report every cycle among constant references; cycles that depend on factors appear in an instance."""
    needs = {t.name: dict(_dependencies(t)) for t in things if t.kind in ("object", "robot")}
    graph = dict(needs)
    while circle := _find_cycle(graph):
        _report(check, circle, needs)
        for name in circle:
            graph[name] = {}


def _find_cycle(graph: dict[str, dict[str, str]]) -> list[str]:
    """Return a cycle of entities, starting with the one declared first, or an empty list."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        circle: list[str] = error.args[1][:0:-1]
        first = min(range(len(circle)), key=lambda i: list(graph).index(circle[i]))
        return circle[first:] + circle[:first]
    return []


def _dependencies(thing: ir.Entity) -> Iterator[tuple[str, str]]:
    """Yield the entities that determine this one's place, each with the property; for a link, its asset."""
    if thing.of:
        yield thing.of, "of"
    for name in ("on", "inside", "at"):
        value = thing.properties[name].value if name in thing.properties else None
        if isinstance(value, ir.Value) and name != "at":
            yield str(value.value), name
        if isinstance(value, ir.Call) and name == "at":
            for argument in (*value.arguments, *(option.value for option in value.options)):
                if isinstance(argument, ir.Value) and isinstance(argument.value, str):
                    yield argument.value, name


def _report(check: Expressions, circle: list[str], needs: dict[str, dict[str, str]]) -> None:
    following = [*circle[1:], circle[0]]
    spans = [_span(check, a, needs[a][b]) for a, b in zip(circle, following, strict=True)]
    others = zip(circle[1:], following[1:], spans[1:], strict=True)
    notes = tuple(Note(f"`{a}` is placed by `{b}`", span) for a, b, span in others)
    whom = f"`{following[0]}`, and that by it" if len(circle) > 1 else "itself"
    remedy = "let one of them say `at: (x, y, z)`"
    check.report.add("WMS209", f"`{circle[0]}` is placed by {whom}", spans[0], remedy, notes)


def _span(check: Expressions, name: str, prop: str) -> Span:
    of = named(check, name)
    return (
        of.set_properties[prop].value.span if prop in of.set_properties else of.span
    )  # a duplicate may lack the property
