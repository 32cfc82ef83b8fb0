"""A spec while it is edited, tolerant of mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import Report, WmsError
from wmspec.core.node import Node
from wmspec.core.places import Source, Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.statements.task import scope_of
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.files import display_path
from wmspec.lang.parse.load import Program, load_source
from wmspec.lang.parse.parser import parse


@dataclass(frozen=True)
class Document:
    """The text of a spec or library, and the path of its file."""

    path: Path
    text: str

    @cached_property
    def source(self) -> Source:
        """The text under the name that messages use."""
        return Source(display_path(self.path), self.text)

    @cached_property
    def program(self) -> Program:
        """The parsed program, with the libraries that could be read."""
        with suppress(WmsError):  # such as a library that is not UTF-8
            return load_source(self.source, self.path.parent, Report())
        return Program(self.source, parse(self.source, Report()), {}, {})

    @property
    def file(self) -> s.File:
        """The syntax tree."""
        return self.program.file

    def around(self, offset: int) -> tuple[s.Task | None, s.Variant | None]:
        """Return the task and the variant around a character; outside of variants, the first one."""
        tasks = [item for item in self.file.items if isinstance(item, s.Task)]
        task = next((t for t in reversed(tasks) if t.span.start <= offset), tasks[0] if tasks else None)
        variants = [item for item in task.body if isinstance(item, s.Variant)] if task else []
        inside = (v for v in variants if v.span.start <= offset <= v.span.end)
        return task, next(inside, variants[0] if variants else None)

    def meaning(self, offset: int) -> Expressions | None:
        """Return the checker of expressions in the scope of a character."""
        with suppress(WmsError):
            return scope_of(self.program, *self.around(offset))
        return None

    def nodes_at(self, offset: int) -> list[Node]:
        """Return the syntax nodes around a character, from the file to the smallest."""
        path: list[Node] = [self.file]
        while (inner := _holding(path[-1], offset)) is not None:
            path.append(inner)
        return path


def children(node: Node) -> Iterator[tuple[str, Node]]:
    """Yield the direct child nodes with their field names."""
    for field in fields(node):  # type: ignore[arg-type]
        for each in _flat(getattr(node, field.name)):
            yield field.name, each


def _flat(value: Any) -> Iterator[Node]:
    if isinstance(value, tuple):
        for item in value:
            yield from _flat(item)
    elif isinstance(value, Node) and isinstance(getattr(value, "span", None), Span):
        yield value


def _holding(node: Node, offset: int) -> Node | None:
    """Return the child around a character; where two meet, the second."""
    holding = [c for _, c in children(node) if c.span.start <= offset <= c.span.end]  # type: ignore[attr-defined]
    return max(holding, key=lambda c: c.span.start, default=None)  # type: ignore[attr-defined]
