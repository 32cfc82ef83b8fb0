"""The names of a task: who declared them, and a complaint where two did."""

from __future__ import annotations

from collections.abc import Iterable

from wmspec.check.functions import FUNCTIONS
from wmspec.check.verbs import VERBS
from wmspec.check.vocabulary import WORDS
from wmspec.parse import syntax as s
from wmspec.parse.diagnostics import Note, Report

Declaration = s.Factor | s.Let | s.Block | s.Action

#: Names that mean something everywhere.
BUILTIN = {"end"} | {word for words in WORDS.values() for word in words}


class Scope:
    """Declarations by name, in the order of the text."""

    def __init__(self, statements: Iterable[s.Statement], report: Report) -> None:
        self.names: dict[str, Declaration] = {}
        for statement in statements:
            if isinstance(statement, s.Factor | s.Let | s.Block | s.Action):
                self._declare(statement, report)

    def _declare(self, statement: Declaration, report: Report) -> None:
        name = statement.name.id
        if (first := self.names.get(name)) is not None:
            report.add(
                "WMS202",
                f"`{name}` is declared twice",
                statement.name.span,
                "give one of them another name",
                (Note("declared here first", first.name.span),),
            )
            return
        if name in BUILTIN:
            report.add("WMS202", f"`{name}` is a word of the language", statement.name.span, "choose another name")
        self.names[name] = statement

    def known(self) -> list[str]:
        """Every word that may be used as a value."""
        return [*self.names, *BUILTIN, *(f for f in FUNCTIONS), *(v for v in VERBS)]

    def of(self, *types: type[Declaration]) -> list[str]:
        """The names declared by statements of the given types."""
        return [n for n, d in self.names.items() if isinstance(d, types)]

    def blocks(self, kind: str) -> list[str]:
        """The names of the objects, cameras or lights."""
        return [n for n, d in self.names.items() if isinstance(d, s.Block) and d.kind == kind]
