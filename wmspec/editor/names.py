"""Declarations and occurrences of names in a spec and its libraries."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import Report
from wmspec.core.node import Node
from wmspec.core.places import Span
from wmspec.editor.document import Document, children
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.parser import parse_expression

_HOLE = re.compile(r"(?<!\\)\{([^{}]*)\}")
_DECLARING = (s.Factor, s.Let, s.Parameter, s.Block, s.Template, s.Action, s.Part, s.Task, s.Variant, s.Question,
              s.Counterfactual)  # fmt: skip
#: Fields whose names refer to no declaration.
_WORDS = {
    (s.Property, "name"), (s.Argument, "name"), (s.Use, "name"), (s.Design, "kind"), (s.Tolerance, "name"),
    (s.Task, "path"),
}  # fmt: skip


@dataclass(frozen=True)
class Declaration:
    """A declaration: its node, its file, and the offset of its name."""

    path: Path
    start: int
    node: Any

    @property
    def key(self) -> tuple[Path, int]:
        """The identity of the declaration."""
        return self.path, self.start


@dataclass(frozen=True)
class Occurrence:
    """A name in a document, with its declaration."""

    span: Span
    declared: Declaration


class Names:
    """All names of a document that refer to a declaration, here or in a library."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self._files = {document.path.resolve(): document.file, **document.program.libraries}

    @cached_property
    def occurrences(self) -> tuple[Occurrence, ...]:
        """All occurrences, in the order of the text."""
        path = self.document.path.resolve()
        by_place = {(o.span.start, o.span.end): o for o in self._walk(self.document.file, path, {})}
        return tuple(by_place[key] for key in sorted(by_place))

    def at(self, offset: int) -> Occurrence | None:
        """Return the name that contains a character or ends before it."""
        holding = [o for o in self.occurrences if o.span.start <= offset <= o.span.end]
        return min(holding, key=lambda o: (o.span.end - o.span.start, -o.span.start), default=None)

    def of(self, declared: Declaration) -> tuple[Span, ...]:
        """Return all occurrences of a declaration in the document."""
        return tuple(o.span for o in self.occurrences if o.declared.key == declared.key)

    def visible(self, offset: int) -> dict[str, Declaration]:
        """Return all names in scope at a character; names of a prefixed library include the prefix."""
        path = self.document.path.resolve()
        names = self._level(self.document.file.items, path)
        for inside in self.document.around(offset):
            names |= self._level(inside.body, path) if inside is not None else {}
        for node in self.document.nodes_at(offset):
            if isinstance(node, s.Template):
                names |= {p.name.id: Declaration(path, p.name.span.start, p) for p in node.parameters}
        return names

    # ------------------------------------------------------------ scopes

    def _level(self, items: tuple[Any, ...], path: Path) -> dict[str, Declaration]:
        """Return the declarations of a file, a task or a variant, including those from libraries."""
        names: dict[str, Declaration] = {}
        for item in items:
            if isinstance(item, s.Use):
                names |= self._used(item)
        for item in items:
            if isinstance(item, s.Factor | s.Let | s.Parameter | s.Block | s.Template | s.Action):
                names[item.name.id] = Declaration(path, item.name.span.start, item)
        return names

    def _used(self, use: s.Use) -> dict[str, Declaration]:
        library = self.document.program.paths.get(use.name.span)
        if library is None or library not in self._files:
            return {}
        brought = self._level(self._files[library].items, library)
        if use.prefix is None:
            return brought
        own = Declaration(self.document.path.resolve(), use.prefix.span.start, use)
        return {use.prefix.id: own} | {f"{use.prefix.id}.{name}": d for name, d in brought.items()}

    # ------------------------------------------------------------ the walk

    def _walk(  # noqa: C901, PLR0912  one case per kind of node
        self, node: Any, path: Path, scope: dict[str, Declaration]
    ) -> Iterator[Occurrence]:
        match node:
            case s.File(items=items):
                scope = self._level(items, path)
            case s.Task(body=body) | s.Variant(body=body):
                scope = scope | self._level(body, path) | _balanced(body, path)
            case s.Template(parameters=parameters):
                yield from (o for o in self._declaration(node, path))
                own = {p.name.id: Declaration(path, p.name.span.start, p) for p in parameters}
                for p in parameters:
                    yield Occurrence(p.name.span, own[p.name.id])
                scope = scope | own
            case s.Member():
                yield from self._member(node, path, scope)
                return
            case s.Text(span=span):
                yield from self._holes(span, path, scope)
                return
            case s.Name():
                yield from self._name(node, scope)
                return
            case s.Design(baseline=baseline):
                for p in baseline:
                    yield from self._name(p.name, scope)
                    balanced = p.value.id if p.name.id == "balance" and isinstance(p.value, s.Name) else ""
                    if (question := scope.get(f"balance: {balanced}")) is not None:
                        yield Occurrence(p.value.span, question)
            case s.Use():
                yield from self._use(node, path)
                scope = {}
        yield from () if isinstance(node, s.Template) else self._declaration(node, path)
        declares = isinstance(node, _DECLARING)
        for field, child in children(node):
            if (type(node), field) in _WORDS or (declares and field == "name"):
                continue
            if isinstance(node, s.Block) and field == "properties":
                yield from self._filled(node, child, scope)
            yield from self._walk(child, path, scope)

    def _declaration(self, node: Node, path: Path) -> Iterator[Occurrence]:
        name = getattr(node, "name", None)
        world = isinstance(node, s.Block) and node.kind == "world"
        if isinstance(node, _DECLARING) and isinstance(name, s.Name) and name.span.text == name.id and not world:
            yield Occurrence(name.span, Declaration(path, name.span.start, node))

    def _filled(self, block: s.Block, node: Any, scope: dict[str, Declaration]) -> Iterator[Occurrence]:
        """Yield a property that sets a parameter of the block's template."""
        template = scope.get(block.model.id) if block.model else None
        if isinstance(node, s.Property) and template is not None and isinstance(template.node, s.Template):
            for p in template.node.parameters:
                if p.name.id == node.name.id:
                    yield Occurrence(node.name.span, Declaration(template.path, p.name.span.start, p))

    def _use(self, use: s.Use, path: Path) -> Iterator[Occurrence]:
        """Yield the library, its prefix, its parameters, and the imported names."""
        library = self.document.program.paths.get(use.name.span)
        if use.prefix is not None:
            yield Occurrence(use.prefix.span, Declaration(path, use.prefix.span.start, use))
        if library is None or library not in self._files:
            return
        yield Occurrence(use.name.span, Declaration(library, 0, self._files[library]))
        brought = self._level(self._files[library].items, library)
        for p in use.given:
            yield from self._name(p.name, brought)
        if use.only is not None:
            yield from self._walk(use.only, path, brought)

    def _name(self, name: s.Name, scope: dict[str, Declaration]) -> Iterator[Occurrence]:
        if name.id in scope and "." not in name.id:
            yield Occurrence(name.span, scope[name.id])
        elif "." in name.id:
            first, _, last = name.id.partition(".")
            if first in scope:
                yield Occurrence(Span(name.span.source, name.span.start, name.span.start + len(first)), scope[first])
            if name.id in scope:
                yield Occurrence(Span(name.span.source, name.span.end - len(last), name.span.end), scope[name.id])

    def _member(self, node: s.Member, path: Path, scope: dict[str, Declaration]) -> Iterator[Occurrence]:
        """Yield a name of a library, as in `here.floor`, or a part, as in `rack.left`."""
        yield from self._walk(node.value, path, scope)
        whole = node.value.id if isinstance(node.value, s.Name) else node.value.span.text
        if (declared := scope.get(f"{whole}.{node.name.id}")) is not None:
            yield Occurrence(node.name.span, declared)
            return
        owner = scope.get(whole)
        places = [owner] if owner is not None else []
        if owner is not None and isinstance(owner.node, s.Block) and owner.node.model is not None:
            template = scope.get(owner.node.model.id)
            places += [template] if template is not None else []
        for place in places:
            for part in getattr(place.node, "parts", ()):
                if part.name.id == node.name.id:
                    yield Occurrence(node.name.span, Declaration(place.path, part.name.span.start, part))
                    return

    def _holes(self, span: Span, path: Path, scope: dict[str, Declaration]) -> Iterator[Occurrence]:
        """Yield the names in the `{...}` of a text."""
        for hole in _HOLE.finditer(span.text):
            inner = Span(span.source, span.start + hole.start(1), span.start + hole.end(1))
            if (expression := parse_expression(inner, Report())) is not None:
                yield from self._walk(expression, path, scope)


def _balanced(body: tuple[Any, ...], path: Path) -> dict[str, Declaration]:
    """Return the questions of a task, by `balance: NAME`, where alone their names are referred to."""
    named = (item for item in body if isinstance(item, s.Question) and item.name is not None)
    return {f"balance: {q.name.id}": Declaration(path, q.name.span.start, q) for q in named if q.name is not None}
