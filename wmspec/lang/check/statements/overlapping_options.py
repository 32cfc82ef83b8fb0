"""Warns about options that do not exclude one another, such as `planks` beside `wood`."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, permutations

from wmspec.core.diagnostics import Note, Report
from wmspec.core.places import Span
from wmspec.lang.check.expressions.scope import Scope
from wmspec.lang.check.tables.overlaps import is_kind_of
from wmspec.lang.parse import syntax as s

Phrase = tuple[str, Span]


def warn_overlapping(options: s.Expr, scope: Scope, report: Report) -> None:
    """Warn about every two words of the options, or of a list from which they come, of which one includes the other."""
    known = set[frozenset[str]]()
    for phrases in _lists(options, scope, set()):
        for (first, at_first), (second, at) in combinations(phrases, 2):
            for kind, whole in permutations((first, second)):
                if is_kind_of(kind, whole) and frozenset((kind, whole)) not in known:
                    known.add(frozenset((kind, whole)))
                    message = f"the options `{first}` and `{second}` overlap: `{kind}` is a kind of `{whole}`"
                    notes = (Note(f"`{first}` is here", at_first),)
                    remedy = "offer words that exclude one another"
                    report.add("WMS511", message, at, remedy, notes, severity="warning")


def _lists(expr: s.Expr, scope: Scope, seen: set[str]) -> Iterator[list[Phrase]]:
    """Yield the words of each list in an expression and in the values that it names."""
    for node in s.nodes(expr, s.Items):
        phrases = [phrase for item in node.items for phrase in _phrase(item, scope)]
        if phrases and node.kind == "list":
            yield phrases
    for name in s.nodes(expr, s.Name):
        declared = scope.names.get(name.id)
        if isinstance(declared, s.Let | s.Factor) and name.id not in seen:
            seen.add(name.id)
            yield from _lists(declared.value if isinstance(declared, s.Let) else declared.domain, scope, seen)


def _phrase(item: s.Expr, scope: Scope) -> Iterator[Phrase]:
    """Yield the wording of an item if it is a text, a label or a word of the language."""
    if isinstance(item, s.Called):
        yield item.text.value, item.text.span
    elif isinstance(item, s.Text):
        yield item.value, item.span
    elif isinstance(item, s.Name) and item.id not in scope.names:
        yield item.id.replace("_", " "), item.span
