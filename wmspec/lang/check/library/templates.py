"""Expands templates into the objects that use them, before checks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from wmspec.core.diagnostics import Note, Report, suggestion
from wmspec.core.places import Span
from wmspec.lang.check.expressions.libraries import library_declaring
from wmspec.lang.check.library.substitute import Substitute, TooLarge
from wmspec.lang.check.tables.vocabulary import PROPERTIES
from wmspec.lang.parse import syntax as s


class Templates:
    """The templates of a task."""

    def __init__(self, statements: Iterable[s.Statement], substitute: Substitute, report: Report) -> None:
        self._substitute = substitute
        self._report = report
        self._used: set[str] = set()
        self.known: dict[str, s.Template] = {}
        for statement in statements:
            if isinstance(statement, s.Template):
                self.known.setdefault(statement.name.id, statement)
                self._once_each(statement)

    def expanded(self, statement: s.Statement) -> s.Statement:
        """Return an object or set with its template's properties; other statements are unchanged."""
        if not isinstance(statement, s.Block) or statement.kind not in ("object", "objects") or statement.model is None:
            return statement
        name = statement.model
        bare = replace(statement, model=None)
        if name.id not in self.known:
            library, _ = library_declaring({name.id})
            help = f"write `use {library}` above, which has it" if library else suggestion(name.id, self.known)
            self._report.add("WMS201", f"there is no template `{name.id}`", name.span, help)
            known = tuple(p for p in bare.properties if p.name.id in PROPERTIES["object"])
            return replace(bare, properties=known)
        self._used.add(name.id)
        return self._made(bare, self.known[name.id], name.span)

    def unused(self) -> Iterable[s.Block]:
        """Return an object of each unused template, so that its errors are found."""
        for name, template in self.known.items():
            if name not in self._used:
                block = s.Block("object", template.name, (), template.span)
                yield self._made(block, template, template.name.span)

    def _made(self, block: s.Block, template: s.Template, span: Span) -> s.Block:
        try:
            return self._filled(block, template)
        except TooLarge:
            notes = (Note("the template is declared here", template.name.span),)
            self._report.add("WMS105", "what this template makes is too large", span, "make it simpler", notes)
            return block

    def _filled(self, block: s.Block, template: s.Template) -> s.Block:
        parameters = {p.name.id for p in template.parameters}
        given = {p.name.id: p.value for p in block.properties if p.name.id in parameters}
        self._without_place(p for p in block.properties if p.name.id in parameters)
        own = tuple(p for p in block.properties if p.name.id not in parameters and self._known(p, template))
        values: dict[str, s.Expr] = {}
        for p in template.parameters:  # a default may refer to earlier parameters
            value = given.get(p.name.id)
            values[p.name.id] = self._substitute.expression(p.value, values) if value is None else value
        written = {p.name.id for p in own} | {"at" for p in own if p.at is not None}
        for either in ({"on", "inside"}, {"mass", "density"}):
            written |= either if written & either else set()
        kept = (p for p in template.properties if p.name.id not in written)
        common = tuple(self._substitute.property(p, values) for p in kept)
        if "at" in written:  # the object's own place takes precedence
            common = tuple(replace(p, at=None) for p in common)
        parts = tuple(self._substitute.part(p, values) for p in template.parts)
        return replace(block, properties=(*common, *own), parts=(*parts, *block.parts))

    def _known(self, p: s.Property, template: s.Template) -> bool:
        """Whether objects can have the property; otherwise report it and suggest the template's parameters."""
        table = PROPERTIES["object"]
        if p.name.id in table:
            return True
        names = [*table, *(x.name.id for x in template.parameters)]
        message = f"`{template.name.id}` has no parameter `{p.name.id}`, nor has an object such a property"
        notes = (Note("the template is declared here", template.name.span),)
        self._report.add("WMS203", message, p.name.span, suggestion(p.name.id, names), notes)
        return False

    def _without_place(self, parameters: Iterable[s.Property]) -> None:
        for p in parameters:
            if p.at is not None:
                self._report.add("WMS101", "`at` follows `on:` and `inside:` only", p.at.span, "remove it")

    def _once_each(self, template: s.Template) -> None:
        self._without_place(template.parameters)
        parameters = ((p.name.id, p.name.span) for p in template.parameters)
        self._report.add_repeated(parameters, f"`{template.name.id}` has two parameters `{{}}`", "remove one")
