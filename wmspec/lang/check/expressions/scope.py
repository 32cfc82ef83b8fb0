"""Scope of a task: declarations by name, and errors about duplicates."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from wmspec.core.diagnostics import Note, Report
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.tables.verbs import VERBS
from wmspec.lang.check.tables.vocabulary import WORDS
from wmspec.lang.parse import syntax as s

Declaration = s.Factor | s.Let | s.Block | s.Action | s.Template

#: Names with a meaning everywhere.
BUILTIN = {"end", "index"} | {word for words in WORDS.values() for word in words}
#: Names that cannot be declared. Other words are distinguished by the type expected at a place.
RESERVED = {"end", "index", *WORDS["color"], *WORDS["shape"], *WORDS["tie"]}


class Scope:
    """Declarations by name, in source order, and the members of sets."""

    def __init__(self, statements: Iterable[s.Statement], report: Report, alone: bool = False) -> None:
        self.names: dict[str, Declaration] = {}
        self.sets: dict[str, str] = {}
        """The set of each member."""
        self.assets: dict[str, dict[str, str]] = {}
        """Links and joints of each asset: their names in the spec, and the names of their blocks."""
        self.whole = True
        """Whether all declarations were read; if not, unknown names are not reported."""
        self.has_duplicates = False
        """Whether two declarations have the same name."""
        self.broken: set[str] = set()
        """Assets with an unusable file, which was reported."""
        self.designs: list[s.Design] = []
        self.questions: list[s.Question] = []
        self.alone = alone
        """Whether the task uses no library."""
        self._report = report
        self._statements = tuple(statements)
        for statement in self._statements:
            if isinstance(statement, s.Factor | s.Let | s.Block | s.Action | s.Template):
                self.declare(statement)
            elif isinstance(statement, s.Design):
                self.designs.append(statement)
            elif isinstance(statement, s.Question):
                self.questions.append(statement)

    def declare(self, statement: Declaration, member_of: str = "") -> None:
        """Add a declaration; report a duplicate name."""
        name = statement.name.id
        if not name:  # a missing name was reported
            self.whole = False
            return
        if (first := self.names.get(name)) is not None:
            notes = (Note("declared here first", first.name.span),)
            remedy = "give one of them another name"
            if name == "world":
                remedy = "there is one world: leave one out, of a library by naming in `only [...]` what you need"
            elif first.name.span.source is not statement.name.span.source:
                remedy += ", or the library a name of its own: `use LIBRARY as NAME`"
            self._report.add("WMS202", f"`{name}` is declared twice", statement.name.span, remedy, notes)
            self.has_duplicates = True
            return
        if isinstance(statement, s.Block) and statement.kind == "light" and (suns := self.blocks("light")):
            what = f"`{name}` is a second light, and there is one sun"
            remedy = "leave one out: of a library, name in `only [...]` what you need"
            notes = (Note("the first one", self.names[suns[0]].name.span),)
            self._report.add("WMS202", what, statement.name.span, remedy, notes)
        if name in RESERVED:
            message = f"`{name}` is a word of the language"
            self._report.add("WMS202", message, statement.name.span, "choose another name")
        self.names[name] = statement
        if member_of:
            self.sets[name] = member_of

    def asset(self, of: str, named: dict[str, str], blocks: tuple[s.Block, ...]) -> None:
        """Add the links and joints of an asset; its base replaces the object that names the asset."""
        base, *others = blocks
        self.names[of] = base
        self.assets[of] = named
        for block in others:
            self.declare(block)

    def members(self, of: str) -> tuple[str, ...]:
        """Return the names of the members of a set, in order."""
        return tuple(member for member, whole in self.sets.items() if whole == of)

    def known(self) -> list[str]:
        """Return every word that may be a value."""
        return [*self.names, *BUILTIN, "true", "false", *FUNCTIONS, *VERBS]

    def written(self, of: Mapping[str, str]) -> dict[str, str]:
        """Return how members of sets and parts of assets are written; `of` renames the sets and assets."""
        sets = {m: f"{of.get(whole, whole)}[{m.removeprefix(whole)[1:]}]" for m, whole in self.sets.items()}
        assets = ((a, name, block) for a, named in self.assets.items() for name, block in named.items() if block != a)
        return sets | {block: f"{of.get(a, a)}.{name}" for a, name, block in assets}

    def undeclared_names(self) -> set[str]:
        """Return the names without a declaration."""
        written = {n.id for n in s.nodes(self._statements, s.Name)}
        return written.difference(self.names, BUILTIN, FUNCTIONS, VERBS)

    def of(self, *types: type[Declaration]) -> list[str]:
        """Return the names declared by statements of the given types."""
        return [n for n, d in self.names.items() if isinstance(d, types)]

    def blocks(self, kind: str) -> list[str]:
        """Return the names of the blocks of a kind, without members of sets."""
        blocks = ((n, d) for n, d in self.names.items() if isinstance(d, s.Block) and d.kind == kind)
        return [n for n, d in blocks if n not in self.sets and not d.whole]
