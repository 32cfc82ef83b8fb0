"""Expands `use`: the statements of libraries, with parameters substituted, selected and renamed.

The syntax tree is rewritten. `use room(wall: blue)` replaces the library's `wall` by `blue`. With `use room as here`
its floor is `here.floor`, or `here_floor` once names are flattened. `only [floor]` selects that statement and those it
depends on. In a library, `left` is the word, also if the task declares that name.
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
#: Prefixes given with `as`, and the names in each.
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
        items = [item for file in files for item in s.statements(file.items)]
        self._factors = {item.name.id: item for item in items if isinstance(item, s.Factor)}
        self._taken = _WORDS.intersection(item.name.id for item in items if isinstance(item, Declared))

    @property
    def whole(self) -> bool:
        """Whether all files could be read and found."""
        return self._program.whole

    @property
    def any(self) -> bool:
        """Whether any library is used."""
        return bool(self._used)

    def written(self) -> dict[str, str]:
        """Return how prefixed names are written: `here.floor` for `here_floor`."""
        return {f"{of}_{name}": f"{of}.{name}" for of, names in self._prefixes.items() for name in names}

    def statements(self, *items: Iterable[Item]) -> list[s.Statement]:
        """Return the statements, without tasks and variants, after those they use; names flattened, parameters
        substituted.
        """
        own = [item for each in items for item in each]
        values = _parameter_values({}, (item for item in own if isinstance(item, s.Parameter)))
        return self._expand([_substitute(item, values) for item in own], "", self._prefixes)

    def plain(self, node: S) -> S:
        """Return a node with `here_floor` for `here.floor`."""
        return self._plain(node, self._prefixes)

    def _expand(self, items: Iterable[Item], outer: str, prefixes: Prefixes) -> list[s.Statement]:
        """Return the statements of a file or task after those that it uses; adds its prefixes to `prefixes`."""
        own = [item for item in items if not isinstance(item, s.Task | s.Variant)]
        uses = (item for item in own if isinstance(item, s.Use))
        brought = [statement for use in uses for statement in self._import(use, outer, prefixes)]
        rest = (item for item in own if not isinstance(item, s.Use | s.Parameter))
        return [*brought, *(self._plain(statement, prefixes) for statement in rest)]

    def _plain(self, node: S, prefixes: Prefixes) -> S:
        return self._joined(node, prefixes) if prefixes else node

    def _joined(self, node: Any, prefixes: Prefixes) -> Any:
        match node:
            case s.Member(value=s.Name(id=prefix), name=s.Name(id=name)) if prefix in prefixes:
                return self._known(prefix, name, node.span, prefixes)
            case s.Name(id=dotted) if "." in dotted:  # name of a camera or a template
                prefix, _, name = dotted.partition(".")
                return self._known(prefix, name, node.span, prefixes) if prefix in prefixes else node
        return _map_children(node, lambda part: self._joined(part, prefixes))

    def _known(self, prefix: str, name: str, span: Span, prefixes: Prefixes) -> s.Name:
        """Return the flattened name; an unknown one is returned as written and reported on lookup."""
        return s.Name(f"{prefix}_{name}" if name in prefixes[prefix] else f"{prefix}.{name}", span)

    # ------------------------------------------------------------ one library

    def _import(self, use: s.Use, outer: str, prefixes: Prefixes) -> list[s.Statement]:
        """Return the renamed statements of a library, or none if they are present already."""
        path = self._program.paths.get(use.name.span)
        if path is None:  # already reported
            return []
        prefix = f"{use.prefix.id}_" if use.prefix is not None else ""
        if (first := self._used.setdefault((path, outer + prefix), use)) is not use:
            self._report_second_use(use, first)
            return []
        if len(self._used) > LIBRARIES.most:
            raise TooLarge(f"the spec {LIBRARIES.sentence}", use.span, LIBRARIES.help)
        items = self._program.libraries[path].items
        values = self._given(use, [item for item in items if isinstance(item, s.Parameter)])
        statements = self._expand([_substitute_cached(item, values) for item in items], outer + prefix, {})
        chosen = statements if use.only is None else self._select(use, use.only, statements)
        if words := self._taken.difference(_declared_names(statements)):
            chosen = _bind_words(chosen, words, self._program.libraries[path].span.source)
        if use.prefix is None:
            return chosen
        names = frozenset(filter(None, map(_name, chosen)))
        prefixes[use.prefix.id] = names
        renamed = {name: prefix + name for name in names}
        key = (prefix, names)
        return [_cached((each,), key, partial(_substitute, each, {}, renamed)) for each in chosen]

    def _report_second_use(self, use: s.Use, first: s.Use) -> None:
        if use.given or use.only:
            notes = (Note("used here first", first.span),)
            help = "say it all where it is used first, or give this one a name of its own: `as NAME`"
            self._report.add("WMS202", f"`{use.name.id}` is used twice", use.span, help, notes)

    def _given(self, use: s.Use, parameters: list[s.Parameter]) -> dict[str, s.Expr]:
        """Return the values of a library's parameters."""
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
                self._check_choice(use, parameter, given.get(parameter.name.id))
        return _parameter_values({name: p.value for name, p in given.items()}, parameters)

    def _check_choice(self, use: s.Use, parameter: s.Parameter, given: s.Property | None) -> None:
        """Report an argument that is not in its parameter's list, as far as it is a literal."""
        domain, name = parameter.domain, parameter.name.id
        if not isinstance(domain, s.Items) or domain.kind != "list" or not domain.items:
            what = f"`{name}` is one of a list, and this is none"
            self._report.add("WMS205", what, domain.span if domain else parameter.span, "write `in [...]`, or `= ...`")
            return
        known = [item.span.text for item in domain.items]
        for value in _literal_values(given.value, self._factors) if given else ():
            if value.span not in self._wrong and not any(_is_same_literal(value, item) for item in domain.items):
                self._wrong.add(value.span)
                what = f"`{use.name.id}` has no {name} {value.span.text}"
                self._report.add("WMS205", what, value.span, suggestion(value.span.text, known))

    def _select(self, use: s.Use, only: s.Expr, statements: list[s.Statement]) -> list[s.Statement]:
        """Return the statements that `only` names, and their dependencies."""
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
                pending += _references(by_name[name])
        return [statement for name, statement in by_name.items() if name in needed]


def _parameter_values(given: Mapping[str, s.Expr], parameters: Iterable[s.Parameter]) -> dict[str, s.Expr]:
    """Return the values of parameters; a default may refer to earlier parameters."""
    values: dict[str, s.Expr] = {}
    for parameter in parameters:
        name = parameter.name.id
        values[name] = given.get(name) or _substitute(parameter.value, values)
    return values


def _literal_values(value: s.Expr, factors: Mapping[str, s.Factor]) -> Iterator[s.Expr]:
    """Yield the literal values an argument can take: itself, both branches of a condition, the levels of a factor."""
    match value:
        case s.Text() | s.Number():
            yield value
        case s.Operation(operator="if", operands=(_, *branches)):
            for branch in branches:
                yield from _literal_values(branch, factors)
        case s.Called():
            yield from _literal_values(value.value, factors)
        case s.Name(id=name) if name in factors and isinstance(factors[name].domain, s.Items):
            domain = factors[name].domain
            assert isinstance(domain, s.Items)
            for level in domain.items:
                yield from _literal_values(level, factors)


def _is_same_literal(one: s.Expr, other: s.Expr) -> bool:
    """Whether two literal values are written alike."""
    if isinstance(one, s.Number) and isinstance(other, s.Number):
        return (one.value, one.unit) == (other.value, other.unit)
    return isinstance(one, s.Text) and isinstance(other, s.Text) and one.value == other.value


def _world(statement: s.Statement) -> str:
    return "world" if isinstance(statement, s.Block) and statement.kind == "world" else ""


def _name(statement: s.Statement) -> str:
    """Return the name that a statement declares; '' for the world and unnamed statements."""
    if isinstance(statement, Declared) and not _world(statement):
        return statement.name.id
    return ""


def _declared_names(statements: Iterable[s.Statement]) -> Iterator[str]:
    """Yield the names that a library and its templates declare."""
    for statement in statements:
        yield _name(statement)
        if isinstance(statement, s.Template):
            yield from (parameter.name.id for parameter in statement.parameters)


# ---------------------------------------------------------------- rewriting


def _bind_words(statements: list[s.Statement], words: frozenset[str], library: Source) -> list[s.Statement]:
    """Return a library's statements with undeclared words bound to the language."""

    def closed(node: Any) -> Any:
        if isinstance(node, s.Name):
            return replace(node, closed=True) if node.id in words and node.span.source is library else node
        return _map_children(node, closed)

    return [each if words.isdisjoint(_names_in(each)) else closed(each) for each in statements]


#: Results by identity of their source nodes, since libraries' syntax trees are shared by all specs. Entries keep the
#: nodes alive, so no other object can have their identity.
_cache: dict[tuple[object, ...], tuple[tuple[object, ...], Any]] = {}
_MAX_CACHED = 6000


def _cached(of: tuple[object, ...], how: object, make: Callable[[], T]) -> T:
    """Return `make()`, cached by the identity of the nodes `of` and the change `how`."""
    key = (*map(id, of), how)
    found = _cache.get(key)
    if found is None:
        if len(_cache) >= _MAX_CACHED:
            _cache.clear()
        found = _cache[key] = (of, make())
    made: T = found[1]
    return made


def _substitute_cached(item: S, values: Mapping[str, s.Expr]) -> S:
    """Return a node of a library with parameters substituted."""
    return _cached((item, *values.values()), tuple(values), lambda: _substitute(item, values))


def _names_in(statement: s.Statement) -> tuple[str, ...]:
    """Return the names in a statement of a library."""
    return _cached((statement,), "names", lambda: tuple(name.id for name in s.nodes(statement, s.Name)))


def _references(statement: s.Statement) -> tuple[str, ...]:
    """Return the names that a statement of a library refers to, outside of it."""
    return _cached((statement,), "references", lambda: tuple(_referred(statement)))


def _referred(node: object) -> Iterator[str]:
    """Yield the names that a subtree refers to. Keys (of properties, arguments, parts) are no names."""
    children: tuple[object, ...] = ()
    own: set[str] = set()
    match node:
        case s.Name(id=name):
            yield name
        case tuple():
            children = node
        case s.Member() | s.Argument():
            children = (node.value,)
        case s.Property():
            children = (node.value, node.at)
        case s.Part():
            children = (node.properties,)
        case s.Template():
            children = (node.parameters, node.properties, node.parts)
            own = {each.name.id for each in node.parameters} | {each.name.id for each in node.parts}
        case Node():
            children = tuple(vars(node).values())
    yield from (name for child in children for name in _referred(child) if name not in own)


def _substitute(node: S, values: Mapping[str, s.Expr], names: Mapping[str, str] | None = None) -> S:
    """Return a subtree with parameters substituted and declarations renamed."""
    return _Replace(values, names or {})(node) if values or names else node


class _Replace:
    """Substitution. Keys (of properties, arguments, parts) are no names; a template's parameters shadow outer names."""

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
                return _map_children(node, self, but="name")
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
                made = _map_children(node, self, but="name")
                return replace(made, name=self._declared(node.name))
        return _map_children(node, self)

    def _declared(self, name: s.Name) -> s.Name:
        """Return a declared name, renamed: no value can replace it."""
        return replace(name, id=self._names.get(name.id, name.id))


@cache
def _name_fields(kind: Any) -> frozenset[str]:
    """Return the fields of a node that are names and not expressions."""
    return frozenset(field.name for field in fields(kind) if field.type in ("Name", "Name | None"))


def _map_children(node: Any, change: Any, but: str = "") -> Any:
    """Return a node with its children mapped by `change`; the same node if none changes."""
    if isinstance(node, tuple):
        changed = tuple(change(item) for item in node)
        return changed if any(a is not b for a, b in zip(changed, node, strict=True)) else node
    if not isinstance(node, Node):
        return node
    kind: Any = type(node)
    named, made = _name_fields(kind), {}
    for name, old in vars(node).items():
        if name != but and isinstance(old, s.COMPOSITE_TYPES):
            new = change(old)
            if new is not old and (isinstance(new, s.Name) or name not in named):
                made[name] = new
    return replace(node, **made) if made else node  # type: ignore[type-var]
