"""What `use` brings: the statements of libraries, with the values of their parameters, chosen and renamed.

All of it happens in the syntax tree. `use room(wall: blue)` puts `blue` wherever the library says `wall`. With `use
room as here` its floor is `here.floor`, or `here_floor` once names are plain. `only [floor]` takes that and what it
needs. A library that says `left` means the word, also where the task calls something so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, replace
from functools import cache, partial
from pathlib import Path
from typing import Any, TypeVar

from wmspec.core.diagnostics import Note, Report, suggestion
from wmspec.core.limits import LIBRARIES, TooLarge
from wmspec.core.node import Node
from wmspec.core.places import Source, Span
from wmspec.lang.check.tables.vocabulary import WORDS
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.load import Program

Item = s.Statement | s.Variant | s.Task
Declared = s.Factor | s.Let | s.Block | s.Action | s.Template
#: The names that libraries were given with `as`, and the names that there are in each.
Prefixes = dict[str, frozenset[str]]
S = TypeVar("S")
T = TypeVar("T")
_WORDS = frozenset(word for words in WORDS.values() for word in words)


class Modules:
    """The libraries that one task uses."""

    def __init__(self, program: Program, report: Report) -> None:
        self._program = program
        self._report = report
        self._used: dict[tuple[Path, str], s.Use] = {}
        self._prefixes: Prefixes = {}
        self._wrong: set[Span] = set()
        files = (program.file, *program.libraries.values())
        self._factors = {item.name.id: item for file in files for item in _factors(file.items)}
        self._taken = _WORDS.intersection(name for file in files for name in _declared(file.items))

    @property
    def whole(self) -> bool:
        """Whether all files could be read and found."""
        return self._program.whole

    @property
    def any(self) -> bool:
        """Whether any library is used."""
        return bool(self._used)

    def written(self) -> dict[str, str]:
        """How names from libraries with a name of their own are written: `here.floor` for `here_floor`."""
        return {f"{of}_{name}": f"{of}.{name}" for of, names in self._prefixes.items() for name in names}

    def statements(self, *items: Iterable[Item]) -> list[s.Statement]:
        """Items without tasks and variants after what they use; all names plain, all parameters filled in."""
        own = [item for each in items for item in each]
        values = _values({}, (item for item in own if isinstance(item, s.Parameter)))
        return self._level([_replaced(item, values) for item in own], "", self._prefixes)

    def plain(self, node: S) -> S:
        """What the task says, with `here_floor` for `here.floor`."""
        return self._plain(node, self._prefixes)

    def _level(self, items: Iterable[Item], outer: str, prefixes: Prefixes) -> list[s.Statement]:
        """The statements of a file or task after those that it uses; `prefixes` takes the names that it gives these."""
        own = [item for item in items if not isinstance(item, s.Task | s.Variant)]
        uses = (item for item in own if isinstance(item, s.Use))
        brought = [statement for use in uses for statement in self._brought(use, outer, prefixes)]
        rest = (item for item in own if not isinstance(item, s.Use | s.Parameter))
        return [*brought, *(self._plain(statement, prefixes) for statement in rest)]

    def _plain(self, node: S, prefixes: Prefixes) -> S:
        return self._joined(node, prefixes) if prefixes else node

    def _joined(self, node: Any, prefixes: Prefixes) -> Any:
        match node:
            case s.Member(value=s.Name(id=prefix), name=s.Name(id=name)) if prefix in prefixes:
                return self._known(prefix, name, node.span, prefixes)
            case s.Name(id=dotted) if "." in dotted:  # of a camera or a template
                prefix, _, name = dotted.partition(".")
                return self._known(prefix, name, node.span, prefixes) if prefix in prefixes else node
        return _each(node, lambda part: self._joined(part, prefixes))

    def _known(self, prefix: str, name: str, span: Span, prefixes: Prefixes) -> s.Name:
        """The plain name; if the library has no such, what was written, which is reported where it is looked up."""
        return s.Name(f"{prefix}_{name}" if name in prefixes[prefix] else f"{prefix}.{name}", span)

    # ------------------------------------------------------------ one library

    def _brought(self, use: s.Use, outer: str, prefixes: Prefixes) -> list[s.Statement]:
        """The statements of a library by the names that `use` gives them; none if they are here already."""
        path = self._program.paths.get(use.name.span)
        if path is None:  # which was reported
            return []
        prefix = f"{use.prefix.id}_" if use.prefix is not None else ""
        if (first := self._used.setdefault((path, outer + prefix), use)) is not use:
            self._again(use, first)
            return []
        if len(self._used) > LIBRARIES.most:
            raise TooLarge(f"the spec {LIBRARIES.sentence}", use.span, LIBRARIES.help)
        items = self._program.libraries[path].items
        values = self._given(use, [item for item in items if isinstance(item, s.Parameter)])
        statements = self._level([_replaced_before(item, values) for item in items], outer + prefix, {})
        chosen = statements if use.only is None else self._chosen(use, use.only, statements)
        if words := self._taken.difference(_said(statements)):
            chosen = _closed(chosen, words, self._program.libraries[path].span.source)
        if use.prefix is None:
            return chosen
        names = frozenset(filter(None, map(_name, chosen)))
        prefixes[use.prefix.id] = names
        renamed = {name: prefix + name for name in names}
        key = (prefix, names)
        return [_made_before((each,), key, partial(_replaced, each, {}, renamed)) for each in chosen]

    def _again(self, use: s.Use, first: s.Use) -> None:
        if use.given or use.only:
            notes = (Note("used here first", first.span),)
            help = "say it all where it is used first, or give this one a name of its own: `as NAME`"
            self._report.add("WMS202", f"`{use.name.id}` is used twice", use.span, help, notes)

    def _given(self, use: s.Use, parameters: list[s.Parameter]) -> dict[str, s.Expr]:
        """The values of a library's parameters."""
        known = {p.name.id for p in parameters}
        given: dict[str, s.Property] = {}
        for p in use.given:
            if p.name.id not in known:
                what = f"`{use.name.id}` has no parameter `{p.name.id}`"
                self._report.add("WMS205", what, p.name.span, suggestion(p.name.id, known))
            elif p.name.id in given:
                self._report.add("WMS205", f"`{p.name.id}` is given twice", p.span, "give it once")
            if p.at is not None:
                self._report.add("WMS101", "`at` has no meaning here", p.at.span, "write one value")
            given.setdefault(p.name.id, p)
        for parameter in parameters:
            if parameter.domain is not None:
                self._among(use, parameter, given.get(parameter.name.id))
        return _values({name: p.value for name, p in given.items()}, parameters)

    def _among(self, use: s.Use, parameter: s.Parameter, given: s.Property | None) -> None:
        """Complain unless what is given for a parameter, as far as that is written out, is in its list."""
        domain, name = parameter.domain, parameter.name.id
        if not isinstance(domain, s.Items) or domain.kind != "list" or not domain.items:
            what = f"`{name}` is one of a list, and this is none"
            self._report.add("WMS205", what, domain.span if domain else parameter.span, "write `in [...]`, or `= ...`")
            return
        known = [item.span.text for item in domain.items]
        for value in _written(given.value, self._factors) if given else ():
            if value.span not in self._wrong and not any(_same(value, item) for item in domain.items):
                self._wrong.add(value.span)
                what = f"`{use.name.id}` has no {name} {value.span.text}"
                self._report.add("WMS205", what, value.span, suggestion(value.span.text, known))

    def _chosen(self, use: s.Use, only: s.Expr, statements: list[s.Statement]) -> list[s.Statement]:
        """What `only` names, and what that needs."""
        by_name = {_name(statement) or _world(statement): statement for statement in statements}
        pending: list[str] = []
        for e in only.items if isinstance(only, s.Items) else (only,):
            name = e.span.text
            if name not in by_name:
                help = suggestion(name, filter(None, by_name))
                self._report.add("WMS201", f"there is no `{name}` in `{use.name.id}`", e.span, help)
            pending.append(name)
        needed: set[str] = set()
        while pending:
            name = pending.pop()
            if name in by_name and name not in needed:
                needed.add(name)
                pending += _names_in(by_name[name])
        return [statement for name, statement in by_name.items() if name in needed]


def _values(given: Mapping[str, s.Expr], parameters: Iterable[s.Parameter]) -> dict[str, s.Expr]:
    """The values of parameters; a default may be made of the parameters before it."""
    values: dict[str, s.Expr] = {}
    for parameter in parameters:
        name = parameter.name.id
        values[name] = given.get(name) or _replaced(parameter.value, values)
    return values


def _declared(items: Iterable[Item]) -> Iterator[str]:
    """The names that are declared in a file, in its tasks and in their variants."""
    for item in items:
        if isinstance(item, s.Task | s.Variant):
            yield from _declared(item.body)
        elif isinstance(item, Declared):
            yield item.name.id


def _factors(items: Iterable[Item]) -> Iterator[s.Factor]:
    """The factors of a file, of its tasks and of their variants."""
    for item in items:
        if isinstance(item, s.Task | s.Variant):
            yield from _factors(item.body)
        elif isinstance(item, s.Factor):
            yield item


def _written(value: s.Expr, factors: Mapping[str, s.Factor]) -> Iterator[s.Expr]:
    """What a value may be, as far as it is written out: itself, either side of a condition, the levels of a factor."""
    match value:
        case s.Text() | s.Number():
            yield value
        case s.Operation(operator="if", operands=(_, *branches)):
            for branch in branches:
                yield from _written(branch, factors)
        case s.Called():
            yield from _written(value.value, factors)
        case s.Name(id=name) if name in factors and isinstance(factors[name].domain, s.Items):
            domain = factors[name].domain
            assert isinstance(domain, s.Items)
            for level in domain.items:
                yield from _written(level, factors)


def _same(one: s.Expr, other: s.Expr) -> bool:
    """Whether two values that are written out are written alike."""
    if isinstance(one, s.Number) and isinstance(other, s.Number):
        return (one.value, one.unit) == (other.value, other.unit)
    return isinstance(one, s.Text) and isinstance(other, s.Text) and one.value == other.value


def _world(statement: s.Statement) -> str:
    return "world" if isinstance(statement, s.Block) and statement.kind == "world" else ""


def _name(statement: s.Statement) -> str:
    """What a statement declares; of the world and of what has no name, nothing."""
    if isinstance(statement, Declared) and not _world(statement):
        return statement.name.id
    return ""


def _said(statements: Iterable[s.Statement]) -> Iterator[str]:
    """What a library declares, and what its templates do."""
    for statement in statements:
        yield _name(statement)
        if isinstance(statement, s.Template):
            yield from (parameter.name.id for parameter in statement.parameters)


# ---------------------------------------------------------------- rewriting


def _closed(statements: list[s.Statement], words: frozenset[str], library: Source) -> list[s.Statement]:
    """The statements of a library, in which words that it wrote and declares nowhere are the language's own."""

    def closed(node: Any) -> Any:
        if isinstance(node, s.Name):
            return replace(node, closed=True) if node.id in words and node.span.source is library else node
        return _each(node, closed)

    return [closed(statement) for statement in statements]


#: What was made of pieces of libraries, by their identity: syntax trees of libraries are kept for all specs. The pieces
#: are kept beside what was made of them, so that no other can have their identity.
_made: dict[tuple[object, ...], tuple[tuple[object, ...], Any]] = {}
_MOST_MADE = 6000


def _made_before(of: tuple[object, ...], how: object, make: Callable[[], T]) -> T:
    """What `make` returns, or returned before for the very same pieces and `how` they are changed."""
    key = (*map(id, of), how)
    found = _made.get(key)
    if found is None:
        if len(_made) >= _MOST_MADE:
            _made.clear()
        found = _made[key] = (of, make())
    made: T = found[1]
    return made


def _replaced_before(item: S, values: Mapping[str, s.Expr]) -> S:
    """A piece of a library with values for its parameters."""
    return _made_before((item, *values.values()), tuple(values), lambda: _replaced(item, values))


def _names_in(statement: s.Statement) -> tuple[str, ...]:
    """The names in a statement of a library."""
    return _made_before((statement,), "names", lambda: tuple(name.id for name in s.names(statement)))


def _replaced(node: S, values: Mapping[str, s.Expr], names: Mapping[str, str] | None = None) -> S:
    """A piece of the syntax tree with values for parameters and new names for what is declared."""
    return _Replace(values, names or {})(node) if values or names else node


class _Replace:
    """Keys are no names: of properties, arguments and parts; a template's own parameters hide what is outside of it."""

    def __init__(self, values: Mapping[str, s.Expr], names: Mapping[str, str]) -> None:
        self._values = values
        self._names = names

    def __call__(self, node: Any) -> Any:
        match node:
            case s.Name(id=name):
                if name in self._values:
                    return self._values[name]
                return replace(node, id=self._names[name]) if name in self._names else node
            case s.Member() | s.Argument():
                return replace(node, value=self(node.value))
            case s.Property():
                return replace(node, value=self(node.value), at=self(node.at))
            case s.Part():
                return replace(node, properties=self(node.properties))
            case s.Question() | s.Counterfactual() | s.Tolerance():
                return _each(node, self, but="name")
            case s.Design():
                return replace(node, count=self(node.count), baseline=self(node.baseline))
            case s.Template(parameters=parameters) if parameters:
                own = {p.name.id for p in parameters}
                inner = _Replace(
                    {name: value for name, value in self._values.items() if name not in own},
                    {name: new for name, new in self._names.items() if name not in own},
                )
                return replace(
                    node,
                    name=self._declared(node.name),
                    parameters=self(parameters),
                    properties=inner(node.properties),
                    parts=inner(node.parts),
                )
            case s.Factor() | s.Let() | s.Block() | s.Action() | s.Template():
                made = _each(node, self, but="name")
                return replace(made, name=self._declared(node.name))
        return _each(node, self)

    def _declared(self, name: s.Name) -> s.Name:
        """A name where it is declared: no value can stand there."""
        return replace(name, id=self._names.get(name.id, name.id))


@cache
def _named(kind: Any) -> frozenset[str]:
    """The fields of a node that are names and no expressions: only another name can stand there."""
    return frozenset(field.name for field in fields(kind) if field.type in ("Name", "Name | None"))


def _each(node: Any, change: Any, but: str = "") -> Any:
    """A piece of the syntax tree whose parts are changed; as it is if none is."""
    if isinstance(node, tuple):
        changed = tuple(change(item) for item in node)
        return changed if any(a is not b for a, b in zip(changed, node, strict=True)) else node
    if not isinstance(node, Node):
        return node
    kind: Any = type(node)
    named, made = _named(kind), {}
    for name, old in vars(node).items():
        if name != but and isinstance(old, s.MADE):
            new = change(old)
            if new is not old and (isinstance(new, s.Name) or name not in named):
                made[name] = new
    return replace(node, **made) if made else node  # type: ignore[type-var]
