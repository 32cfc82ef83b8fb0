"""Builds the syntax tree from the parse tree: one method per grammar rule that needs one."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source, Span
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.lr_parser import Tree

_QUANTITY = re.compile(r"([\d.]+(?:[eE][+-]?\d+)?)[ \t]*(.+)")
_ESCAPES = {"n": "\n", "t": "\t", '"': '"', "\\": "\\"}


def build_file(source: Source, tree: Tree, report: Report, whole: bool) -> s.File:
    """Return the syntax tree of a whole file; `whole` is true if recovery dropped nothing."""
    build = _Builder(source, report)
    return s.File(tuple(build(c) for c in tree.children if c is not None), Span(source, 0, len(source.text)), whole)


def build_expression(source: Source, tree: Tree, report: Report) -> s.Expr:
    """Return the syntax tree of one expression."""
    expression: s.Expr = _Builder(source, report)(tree)
    return expression


class _Builder:
    def __init__(self, source: Source, report: Report) -> None:
        self.source = source
        self.report = report

    def __call__(self, node: Any) -> Any:
        rule: Callable[[Any, Span], Any] = getattr(self, node.rule)
        return rule(node.children, self.span(node))

    def span(self, node: Tree | Token) -> Span:
        return Span(self.source, node.start, node.end)

    def maybe(self, node: Any) -> Any:
        return None if node is None else self(node)

    def every(self, nodes: list[Any]) -> tuple[Any, ...]:
        return tuple(self(n) for n in nodes if isinstance(n, Tree))

    def _node(kind: Callable[..., Any], *first: object, heads: int | None = None) -> Callable[..., Any]:
        """Return the method of a rule whose children are the fields of a node, after `first`.

        With a number of `heads`, the children after these are one field.
        """

        def build(self: _Builder, c: Any, span: Span) -> Any:
            rest = () if heads is None else (self.every(c[heads:]),)
            return kind(*first, *map(self.maybe, c[:heads]), *rest, span)

        return build

    # ------------------------------------------------------------ statements

    def docstring(self, c: Any, span: Span) -> s.Docstring:
        return s.Docstring(c[0].text[3:-3].strip(), span)

    def use(self, c: Any, span: Span) -> s.Use:
        given = self.every(c[1].children) if c[1] is not None else ()
        return s.Use(self(c[0]), given, self.maybe(c[2]), self.maybe(c[3]), span)

    variant = _node(s.Variant, heads=1)
    parameter = _node(s.Parameter)

    def choice(self, c: Any, span: Span) -> s.Parameter:
        name, domain = self(c[0]), self(c[1])
        value = domain.items[0] if isinstance(domain, s.Items) and domain.items else domain
        return s.Parameter(name, value, span, domain)

    def dotted(self, c: Any, span: Span) -> s.Name:
        return s.Name(".".join(self(n).id for n in c if n is not None), span)

    def task(self, c: Any, span: Span) -> s.Task:
        path = self.every(c[1].children) if c[1] is not None else ()
        return s.Task(self(c[0]), path, self.every(c[2:]), span)

    def factor(self, c: Any, span: Span) -> s.Factor:
        return s.Factor(self(c[0]), self(c[1]), False, span, self.maybe(c[2]))

    def nuisance(self, c: Any, span: Span) -> s.Factor:
        return s.Factor(self(c[0]), self(c[2]), True, span, self.maybe(c[3]), self.maybe(c[1]))

    def about(self, c: Any, span: Span) -> s.Word:  # noqa: ARG002  the word alone
        return self.word(c[0])

    def word(self, tree: Any) -> s.Word:
        """Return a name as a word of the language."""
        name = self(tree)
        return s.Word(name.id, name.span)

    let = _node(s.Let)
    require = _node(s.Require)
    holdout = _node(s.Holdout)
    repeat = _node(s.Setting, "repeat")
    horizon = _node(s.Setting, "horizon")

    def setting(self, c: Any, span: Span) -> s.Setting:
        return s.Setting(c[0].text, self.text(c[1:], self.span(c[1])), span)

    design = _node(s.Design, heads=2)
    tolerance = _node(s.Tolerance)

    def block(self, c: Any, span: Span) -> s.Block:
        kind = c[0].text
        trees = [n for n in c[1:] if isinstance(n, Tree)]
        properties, parts = self.members(trees)
        if kind == "world":
            return s.Block(kind, s.Name("world", self.span(c[0])), properties, span)
        model = next((self(n.children[0]) for n in trees if n.rule == "model"), None)
        count = self(trees[1]) if kind in ("objects", "joints") else None
        return s.Block(kind, self(trees[0]), properties, span, model, count, parts)

    def template(self, c: Any, span: Span) -> s.Template:
        parameters = self.every(c[1].children) if c[1] is not None else ()
        return s.Template(self(c[0]), parameters, *self.members(c[2:]), span)

    def members(self, nodes: Any) -> tuple[tuple[s.Property, ...], tuple[s.Part, ...]]:
        trees = [n for n in nodes if isinstance(n, Tree)]
        properties = tuple(self(n) for n in trees if n.rule == "property")
        return properties, tuple(self(n) for n in trees if n.rule == "part")

    def part(self, c: Any, span: Span) -> s.Part:
        return s.Part(self(c[0]), self.members(c[1:])[0], span)

    property = _node(s.Property)
    action = _node(s.Action, heads=2)

    def actions(self, c: Any, span: Span) -> s.Action:
        return s.Action(self(c[0]), self(c[2]), self.every(c[3:]), span, self(c[1]))

    def timing(self, c: Any, span: Span) -> s.Timing:
        return s.Timing(c[0].text, self(c[1]), span)

    def observe(self, c: Any, span: Span) -> s.Observe:
        return s.Observe(self(c[0]), self(c[1]), span, self.maybe(c[2]))

    film = _node(s.Film)

    # ------------------------------------------------------------ questions

    def question(self, c: Any, span: Span) -> s.Question:
        parts = self.every(c[2:])
        clauses = tuple(p for p in parts if isinstance(p, s.Clause))
        counterfactuals = tuple(p for p in parts if isinstance(p, s.Counterfactual | s.EachOther))
        kinds = tuple(p for p in parts if isinstance(p, s.Kinds))
        legibility = tuple(p for p in parts if isinstance(p, s.Legibility))
        texts = tuple(p for p in parts if isinstance(p, s.ModelText))
        return s.Question(self(c[1]), clauses, counterfactuals, span, self.maybe(c[0]), kinds, legibility, texts)

    def pieces(self, c: Any, span: Span) -> s.Pieces:
        return s.Pieces(tuple(self.text([token], self.span(token)) for token in c), span)

    def _clause(kind: str) -> Callable[[_Builder, Any, Span], s.Clause]:  # type: ignore[misc]
        def build(self: _Builder, c: Any, span: Span) -> s.Clause:
            value, bound, unless = [self.maybe(n) for n in c] + [None] * (3 - len(c))
            return s.Clause(kind, value, bound, span, unless)

        return build

    options = _clause("options")
    answer = _clause("answer")
    margin = _clause("margin")
    ensure = _clause("ensure")
    distinct = _clause("distinct")
    within = _clause("within")
    difference = _clause("difference")
    stable = _clause("stable")
    hide = _clause("hide")
    seen = _clause("seen")

    def orbit(self, c: Any, span: Span) -> s.Clause:
        names = self.every(c)
        return s.Clause("orbit", s.Items("list", names, None, names[0].span.to(names[-1].span)), None, span)

    def legibility(self, c: Any, span: Span) -> s.Legibility:
        return s.Legibility(self.word(c[0]), span)

    film_text = _node(s.ModelText, "film_text")
    action_text = _node(s.ModelText, "action_text")
    kinds = _node(s.Kinds, heads=0)
    each_other = _node(s.EachOther)
    counterfactual = _node(s.Counterfactual, heads=1)
    change_action = _node(s.Change, "action")
    change_state = _node(s.Change, "state")
    change_level = _node(s.Change, "level")

    def change_without(self, c: Any, span: Span) -> s.Change:
        return s.Change("without", self(c[0]), None, span)

    change_order = _node(s.Change, "order")

    def change_add(self, c: Any, span: Span) -> s.Change:
        return s.Change("add", self(c[0]), None, span, self.every(c[1:]))

    # ------------------------------------------------------------ expressions

    def called(self, c: Any, span: Span) -> s.Called:
        return s.Called(self(c[0]), self.text(c[1:], self.span(c[1])), span)

    conditional = _node(s.Operation, "if", heads=0)

    def taken_away(self, c: Any, span: Span) -> s.WhatIf:
        target = self(c[1])
        return s.WhatIf(self(c[0]), s.Change("without", target, None, target.span), span)

    under = _node(s.WhatIf)
    cause = _node(s.Cause)

    either = _node(s.Operation, "or", heads=0)
    both = _node(s.Operation, "and", heads=0)
    negate = _node(s.Operation, "not", heads=0)

    def compare(self, c: Any, span: Span) -> s.Operation:
        return s.Operation(c[1].text, (self(c[0]), self(c[2])), span)

    binary = compare

    def minus(self, c: Any, span: Span) -> s.Operation:
        return s.Operation("-", (self(c[1]),), span)

    def range_(self, c: Any, span: Span) -> s.Range:
        return s.Range(self(c[0]), self(c[1]), None, None, span)

    def steps(self, c: Any, span: Span) -> s.Range:
        return s.Range(self(c[0]), self(c[1]), self(c[2]), None, span)

    def points(self, c: Any, span: Span) -> s.Range:
        return s.Range(self(c[0]), self(c[1]), None, self(c[2]), span)

    member = _node(s.Member)
    index = _node(s.Index)
    call = _node(s.Call, heads=1)

    def argument(self, c: Any, span: Span) -> s.Argument:
        return s.Argument(self(c[0]) if len(c) > 1 else None, self(c[-1]), span)

    def number(self, c: Any, span: Span) -> s.Number:
        return s.Number(float(c[0].text), None, span)

    def quantity(self, c: Any, span: Span) -> s.Number:
        match = _QUANTITY.fullmatch(c[0].text)
        assert match, c[0]
        return s.Number(float(match[1]), match[2], span)

    def text(self, c: Any, span: Span) -> s.Text:
        return s.Text(re.sub(r"\\(.)", lambda m: _ESCAPES.get(m[1], m[1]), c[0].text[1:-1]), span)

    true = _node(s.Truth, True)
    false = _node(s.Truth, False)

    def name(self, c: Any, span: Span) -> s.Name:
        return s.Name(c[0].text, span)

    at_name = name
    at_key = name
    named = name

    def reference(self, c: Any, _: Span) -> s.Name:
        name: s.Name = self(c[0])
        return name

    def tuple(self, c: Any, span: Span) -> s.Items:
        return s.Items("tuple", self.every(c), None, span)

    def list(self, c: Any, span: Span) -> s.Items:
        unit = c[-1].text.strip() if isinstance(c[-1], Token) else None
        return s.Items("list", self.every(c), unit, span)
