"""Random syntax trees and their text: all that the grammar permits, whether or not it makes sense."""

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

from hypothesis import strategies as st

from wmspec.core.places import Source, Span
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.tables import grammar, lark_parser

NOWHERE = Span(Source("tree", ""), 0, 0)


def soft_words() -> list[str]:
    """Keywords that may be names too, as the grammar says."""
    lark = lark_parser(grammar())
    name = {rule.expansion[0].name for rule in lark.rules if rule.origin.name == "name"}
    return sorted(t.pattern.value for t in lark.terminals if t.name in name and t.pattern.type == "str")


#: Ordinary names, and words that are keywords elsewhere.
_NAMES = ["a", "b2", "Cup", "_x", "title", *soft_words()]
_UNITS = ["cm", "m", "s", "deg", "kg/m^3", "m/s^2", "N*s", "%"]

names = st.sampled_from(_NAMES).map(lambda n: s.Name(n, NOWHERE))
words = st.sampled_from(_NAMES).map(lambda n: s.Word(n, NOWHERE))
_numbers = st.one_of(st.integers(0, 10**6).map(float), st.floats(0, 1e9, allow_subnormal=False))
_texts = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc", "Zl", "Zp")), max_size=8)
texts = _texts.map(lambda t: s.Text(t, NOWHERE))
pieces = st.builds(s.Pieces, st.lists(texts, min_size=1, max_size=3).map(tuple), st.just(NOWHERE))
docstrings = st.text("aé {#.", max_size=8).map(lambda t: s.Docstring(t.strip(), NOWHERE))


def _atoms() -> st.SearchStrategy[s.Expr]:
    return st.one_of(
        st.builds(s.Number, _numbers, st.one_of(st.none(), st.sampled_from(_UNITS)), st.just(NOWHERE)),
        texts,
        st.booleans().map(lambda b: s.Truth(b, NOWHERE)),
        names,
    )


def _many(of: st.SearchStrategy[Any], least: int = 0, most: int = 3) -> st.SearchStrategy[tuple[Any, ...]]:
    return st.lists(of, min_size=least, max_size=most).map(tuple)


def _larger(inner: st.SearchStrategy[s.Expr]) -> st.SearchStrategy[s.Expr]:
    here = st.just(NOWHERE)
    none = st.none()
    arguments = st.builds(s.Argument, st.one_of(none, names), inner, here)
    entries = st.one_of(inner, inner, st.builds(s.Called, inner, texts, here))
    binary = st.sampled_from(["+", "-", "*", "/", "==", "!=", "<", "<=", ">", ">=", "and", "or"])
    return st.one_of(
        st.builds(s.Member, names, names, here),
        st.builds(s.Index, names, inner, here),
        st.builds(s.Call, names, _many(arguments), here),
        st.builds(s.Operation, binary, st.tuples(inner, inner), here),
        st.builds(s.Operation, st.sampled_from(["not", "-"]), st.tuples(inner), here),
        st.builds(s.Operation, st.just("if"), st.tuples(inner, inner, inner), here),
        st.builds(s.Range, inner, inner, none, none, here),
        st.builds(s.Range, inner, inner, inner, none, here),
        st.builds(s.Range, inner, inner, none, inner, here),
        st.builds(s.Items, st.just("list"), _many(entries), st.one_of(none, st.sampled_from(["cm", "m/s"])), here),
        st.builds(s.Items, st.just("tuple"), _many(inner, 2), none, here),
    )


expressions = st.recursive(_atoms(), _larger, max_leaves=6)


def _statements() -> st.SearchStrategy[s.Statement]:
    here, none = st.just(NOWHERE), st.none()
    optional = st.one_of(none, expressions)
    properties = _many(st.builds(s.Property, names, expressions, optional, here))
    parts = _many(st.builds(s.Part, names, properties, here), most=2)
    model = st.one_of(none, names)
    some = _many(names, least=1)
    timings = _many(st.builds(s.Timing, st.sampled_from(["at", "for", "after", "with"]), expressions, here), most=2)
    plain = ("options", "answer", "ensure", "within", "difference", "distinct", "stable", "hide")
    clause = st.one_of(
        st.builds(s.Clause, st.sampled_from(plain), expressions, none, here, none),
        st.builds(s.Clause, st.just("margin"), expressions, expressions, here, optional),
        st.builds(s.Clause, st.just("seen"), expressions, optional, here, none),
        st.builds(s.Clause, st.just("orbit"), st.builds(s.Items, st.just("list"), some, none, here), none, here),
    )
    places = st.builds(s.Member, names, names, here)
    calls = st.builds(s.Call, names, _many(st.builds(s.Argument, st.one_of(none, names), expressions, here)), here)
    change = st.one_of(
        st.builds(s.Change, st.sampled_from(["action", "state"]), places, expressions, here),
        st.builds(s.Change, st.just("without"), names, none, here),
        st.builds(s.Change, st.just("order"), names, names, here),
        st.builds(s.Change, st.just("add"), calls, none, here, timings),
    )
    changes = st.one_of(
        st.builds(s.Counterfactual, names, _many(change, most=2), here), st.builds(s.EachOther, places, here)
    )
    outcomes = st.builds(s.Kinds, properties, here)
    legibility = st.builds(s.Legibility, words, here)
    kinds = st.sampled_from(["object", "camera", "light", "joint", "robot"])
    return st.one_of(
        st.builds(s.Factor, names, expressions, st.booleans(), here, st.none() | words),
        st.builds(s.Let, names, expressions, here),
        st.builds(s.Require, expressions, here),
        st.builds(
            s.Holdout, names | st.builds(s.Items, st.just("tuple"), _many(names, 2), none, here), expressions, here
        ),
        st.builds(s.Setting, st.sampled_from(["repeat", "horizon"]), expressions, here),
        st.builds(s.Setting, st.sampled_from(["title", "license", "source"]), texts, here),
        st.builds(s.Design, names, optional, properties, here),
        st.builds(s.Tolerance, names, expressions, here),
        st.builds(s.Template, names, properties, properties, parts, here),
        st.builds(s.Block, kinds, names, properties, here, model, none, parts),
        st.builds(s.Block, st.sampled_from(["objects", "joints"]), names, properties, here, model, expressions, parts),
        st.builds(s.Block, st.just("world"), st.just(s.Name("world", NOWHERE)), properties, here),
        st.builds(s.Action, names, calls, timings, here),
        st.builds(s.Observe, names, expressions, here, optional),
        st.builds(
            s.Question,
            pieces,
            _many(clause),
            _many(changes, most=2),
            here,
            model,
            _many(outcomes, most=1),
            _many(legibility, most=1),
        ),
        st.builds(s.Use, names, properties, model, optional, here),
        st.builds(s.Parameter, names, expressions, here),
    )


statements = _statements()
inside = st.one_of(
    statements, docstrings, st.builds(s.Variant, names, _many(st.one_of(statements, docstrings)), st.just(NOWHERE))
)
files = st.builds(
    s.File,
    _many(st.one_of(statements, st.builds(s.Task, names, _many(names), _many(inside), st.just(NOWHERE))), most=4),
    st.just(NOWHERE),
)


def bare(node: Any) -> Any:
    """A tree without its places, to compare."""
    if is_dataclass(node) and not isinstance(node, type):
        return (type(node).__name__, *(bare(getattr(node, f.name)) for f in fields(node) if f.name != "span"))
    return tuple(map(bare, node)) if isinstance(node, tuple) else node


# ---------------------------------------------------------------- the text of a tree


def written(node: Any) -> str:
    """The text of a tree; every operation in brackets."""
    return "" if node is None else _TEXTS[type(node)](node)


def _listed(nodes: Any) -> str:
    return ", ".join(map(written, nodes))


def _block(*nodes: Any) -> str:
    return "{\n" + "".join(f"{written(n)}\n" for n in nodes) + "}"


def _after(word: str, node: Any) -> str:
    return f"{word}{written(node)}" if node else ""


def _operation(node: s.Operation) -> str:
    operands = [written(o) for o in node.operands]
    if node.operator == "if":
        return "(if {} then {} else {})".format(*operands)
    return (
        f"({node.operator} {operands[0]})" if len(operands) == 1 else f"({operands[0]} {node.operator} {operands[1]})"
    )


def _items(node: s.Items) -> str:
    unit = f" {node.unit}" if node.unit else ""
    return f"[{_listed(node.items)}]{unit}" if node.kind == "list" else f"({_listed(node.items)})"


def _named_block(node: s.Block) -> str:
    name = "" if node.kind == "world" else f" {written(node.name)}"
    count = f"[{written(node.count)}]" if node.count else ""
    return f"{node.kind}{name}{count}{_after(' : ', node.model)} {_block(*node.properties, *node.parts)}"


def _use(node: s.Use) -> str:
    given = f"({_listed(node.given)})" if node.given else ""
    return f"use {node.name.id}{given}{_after(' as ', node.prefix)}{_after(' only ', node.only)}"


def _question(node: s.Question) -> str:
    clauses = _block(*node.clauses, *node.legibility, *node.kinds, *node.counterfactuals)
    return f"question {written(node.name)} {written(node.text)} {clauses}"


def _clause(node: s.Clause) -> str:
    if node.kind == "orbit" and isinstance(node.value, s.Items):
        return f"options orbit of {_listed(node.value.items)}"
    by = "by " if node.kind in ("distinct", "stable") else ""
    if node.kind == "seen":
        return f"seen {written(node.value)}{_after(' at ', node.bound)}"
    keyword = "may hide" if node.kind == "hide" else node.kind
    return f"{keyword} {by}{written(node.value)}{_after(' apart by ', node.bound)}{_after(' unless ', node.unless)}"


def _change(node: s.Change) -> str:
    between = {"order": ", ", "without": "", "add": " "}.get(node.kind, ": ")
    return f"{node.kind} {written(node.target)}{between}{written(node.value)}{' '.join(map(written, node.timings))}"


def _design(node: s.Design) -> str:
    baseline = f" {_block(*node.baseline)}" if node.baseline else ""
    return f"design {written(node.kind)}{_after(' of ', node.count)}{baseline}"


_TEXTS: dict[type, Callable[[Any], str]] = {
    s.Number: lambda n: f"{n.value!r}".removesuffix(".0") + (f" {n.unit}" if n.unit else ""),
    s.Text: lambda n: '"' + n.value.replace("\\", "\\\\").replace('"', '\\"') + '"',
    s.Pieces: lambda n: "\n".join(map(written, n.pieces)),
    s.Called: lambda n: f"{written(n.value)} called {written(n.text)}",
    s.Docstring: lambda n: f'"""{n.text}"""',
    s.Use: _use,
    s.Parameter: lambda n: f"parameter {n.name.id} = {written(n.value)}",
    s.Variant: lambda n: f"variant {n.name.id} {_block(*n.body)}",
    s.Kinds: lambda n: f"kinds {_block(*n.kinds)}",
    s.EachOther: lambda n: f"counterfactual each other {written(n.target)}",
    s.Truth: lambda n: "true" if n.value else "false",
    s.Name: lambda n: n.id,
    s.Member: lambda n: f"{written(n.value)}.{written(n.name)}",
    s.Index: lambda n: f"{written(n.value)}[{written(n.index)}]",
    s.Argument: lambda n: (f"{n.name.id}: " if n.name else "") + written(n.value),
    s.Call: lambda n: f"{written(n.function)}({_listed(n.arguments)})",
    s.Operation: _operation,
    s.Range: lambda n: f"({written(n.start)} .. {written(n.stop)}{_after(' by ', n.step)}{_after(' in ', n.count)})",
    s.Items: _items,
    s.File: lambda n: "\n".join(map(written, n.items)) + "\n",
    s.Task: lambda n: f"task {n.name.id}{' : ' * bool(n.path)}{'.'.join(map(written, n.path))} {_block(*n.body)}",
    s.Factor: lambda n: (
        f"{'nuisance' if n.nuisance else 'factor'} {n.name.id} in {written(n.domain)}{_after(' about ', n.about)}"
    ),
    s.Word: lambda n: n.id,
    s.Legibility: lambda n: f"legibility {n.word.id}",
    s.Let: lambda n: f"let {n.name.id} = {written(n.value)}",
    s.Require: lambda n: f"require {written(n.condition)}",
    s.Holdout: lambda n: f"holdout {written(n.target)} in {written(n.levels)}",
    s.Setting: lambda n: f"{n.key} {written(n.value)}",
    s.Design: _design,
    s.Tolerance: lambda n: f"tolerance {n.name.id} {written(n.value)}",
    s.Template: lambda n: f"template {n.name.id}({_listed(n.parameters)}) {_block(*n.properties, *n.parts)}",
    s.Part: lambda n: f"part {n.name.id} {_block(*n.properties)}",
    s.Property: lambda n: f"{n.name.id}: {written(n.value)}{_after(' at ', n.at)}",
    s.Block: _named_block,
    s.Timing: lambda n: f"{n.kind} {written(n.value)}",
    s.Action: lambda n: f"action {n.name.id} = {written(n.call)} {' '.join(map(written, n.timings))}",
    s.Observe: lambda n: f"observe {n.camera.id} at {written(n.times)}{_after(' as ', n.channels)}",
    s.Question: _question,
    s.Clause: _clause,
    s.Counterfactual: lambda n: f"counterfactual {n.name.id} {_block(*n.changes)}",
    s.Change: _change,
}
