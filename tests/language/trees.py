"""Random syntax trees and their text: whatever the grammar can say, whether or not it makes sense."""

from dataclasses import fields, is_dataclass
from typing import Any

from hypothesis import strategies as st

from wmspec.parse import syntax as s
from wmspec.parse.source import Source, Span

NOWHERE = Span(Source("tree", ""), 0, 0)

#: Ordinary names, and words that are keywords elsewhere.
_NAMES = ["a", "b2", "Cup", "_x", "light", "camera", "world", "options", "answer", "state", "order", "repeat", "horizon",
          "title", "design", "tolerance", "template", "part", "joint", "robot", "objects", "within", "stable", "of"]  # fmt: skip
_UNITS = ["cm", "m", "s", "deg", "kg/m^3", "m/s^2", "N*s", "%"]

names = st.sampled_from(_NAMES).map(lambda n: s.Name(n, NOWHERE))
_numbers = st.one_of(st.integers(0, 10**6).map(float), st.floats(0, 1e9, allow_subnormal=False))
_texts = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc", "Zl", "Zp")), max_size=8)
texts = _texts.map(lambda t: s.Text(t, NOWHERE))


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
        st.builds(s.Items, st.just("list"), _many(inner), st.one_of(none, st.sampled_from(["cm", "m/s"])), here),
        st.builds(s.Items, st.just("tuple"), _many(inner, 2), none, here),
    )


expressions = st.recursive(_atoms(), _larger, max_leaves=6)


def _statements() -> st.SearchStrategy[s.Statement]:
    here, none = st.just(NOWHERE), st.none()
    optional = st.one_of(none, expressions)
    properties = _many(st.builds(s.Property, names, expressions, optional, here))
    parts = _many(st.builds(s.Part, names, properties, here), most=2)
    model = st.one_of(none, names)
    timings = _many(st.builds(s.Timing, st.sampled_from(["at", "for", "after", "with"]), expressions, here), most=2)
    plain = ("options", "answer", "ensure", "within", "difference", "distinct", "stable")
    clause = st.one_of(
        st.builds(s.Clause, st.sampled_from(plain), expressions, none, here, none),
        st.builds(s.Clause, st.just("margin"), expressions, expressions, here, optional),
    )
    places = st.builds(s.Member, names, names, here)
    change = st.one_of(
        st.builds(s.Change, st.sampled_from(["action", "state"]), places, expressions, here),
        st.builds(s.Change, st.just("without"), names, none, here),
        st.builds(s.Change, st.just("order"), names, names, here),
    )
    counterfactual = st.builds(s.Counterfactual, names, _many(change, most=2), here)
    kinds = st.sampled_from(["object", "camera", "light", "joint", "robot"])
    return st.one_of(
        st.builds(s.Factor, names, expressions, st.booleans(), here),
        st.builds(s.Let, names, expressions, here),
        st.builds(s.Require, expressions, here),
        st.builds(s.Setting, st.sampled_from(["repeat", "horizon"]), expressions, here),
        st.builds(s.Setting, st.sampled_from(["title", "license", "source"]), texts, here),
        st.builds(s.Design, names, optional, properties, here),
        st.builds(s.Tolerance, names, expressions, here),
        st.builds(s.Template, names, properties, properties, parts, here),
        st.builds(s.Block, kinds, names, properties, here, model, none, parts),
        st.builds(s.Block, st.just("objects"), names, properties, here, model, expressions, parts),
        st.builds(s.Block, st.just("world"), st.just(s.Name("world", NOWHERE)), properties, here),
        st.builds(s.Action, names, st.builds(s.Call, names, st.just(()), here), timings, here),
        st.builds(s.Observe, names, expressions, here, optional),
        st.builds(s.Question, texts, _many(clause), _many(counterfactual, most=2), here, model),
    )


statements = _statements()
files = st.builds(
    s.File,
    _many(st.one_of(statements, st.builds(s.Task, names, _many(names), _many(statements), st.just(NOWHERE))), most=4),
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
    match node:
        case None:
            return ""
        case s.Number():
            return f"{node.value!r}".removesuffix(".0") + (f" {node.unit}" if node.unit else "")
        case s.Text():
            return '"' + node.value.replace("\\", "\\\\").replace('"', '\\"') + '"'
        case s.Truth():
            return "true" if node.value else "false"
        case s.Name():
            return node.id
        case s.Member():
            return f"{written(node.value)}.{written(node.name)}"
        case s.Index():
            return f"{written(node.value)}[{written(node.index)}]"
        case s.Argument():
            return f"{written(node.name)}: {written(node.value)}" if node.name else written(node.value)
        case s.Call():
            return f"{written(node.function)}({_listed(node.arguments)})"
        case s.Operation():
            return f"({_operation(node)})"
        case s.Range():
            tail = f" by {written(node.step)}" if node.step else f" in {written(node.count)}" if node.count else ""
            return f"({written(node.start)} .. {written(node.stop)}{tail})"
        case s.Items(kind="list"):
            return f"[{_listed(node.items)}]" + (f" {node.unit}" if node.unit else "")
        case s.Items():
            return f"({_listed(node.items)})"
        case s.File():
            return "\n".join(map(written, node.items)) + "\n"
        case _:
            return _statement(node)


def _listed(nodes: Any) -> str:
    return ", ".join(map(written, nodes))


def _operation(node: s.Operation) -> str:
    operands = [written(o) for o in node.operands]
    if node.operator == "if":
        return "if {} then {} else {}".format(*operands)
    return f"{node.operator} {operands[0]}" if len(operands) == 1 else f" {node.operator} ".join(operands)


def _statement(node: Any) -> str:
    match node:
        case s.Task():
            path = f" : {'.'.join(map(written, node.path))}" if node.path else ""
            return f"task {written(node.name)}{path} {_block(node.body)}"
        case s.Factor():
            return f"{'nuisance' if node.nuisance else 'factor'} {written(node.name)} in {written(node.domain)}"
        case s.Let():
            return f"let {written(node.name)} = {written(node.value)}"
        case s.Require():
            return f"require {written(node.condition)}"
        case s.Setting():
            return f"{node.key} {written(node.value)}"
        case s.Design():
            count = f" of {written(node.count)}" if node.count else ""
            return f"design {written(node.kind)}{count}" + (f" {_block(node.baseline)}" if node.baseline else "")
        case s.Tolerance():
            return f"tolerance {written(node.name)} {written(node.value)}"
        case s.Template():
            return f"template {written(node.name)}({_listed(node.parameters)}) {_block(node.properties + node.parts)}"
        case s.Part():
            return f"part {written(node.name)} {_block(node.properties)}"
        case s.Property():
            return f"{written(node.name)}: {written(node.value)}" + (f" at {written(node.at)}" if node.at else "")
        case s.Block(kind="world"):
            return f"world {_block(node.properties)}"
        case s.Block():
            count = f"[{written(node.count)}]" if node.count else ""
            model = f" : {written(node.model)}" if node.model else ""
            return f"{node.kind} {written(node.name)}{count}{model} {_block(node.properties + node.parts)}"
        case s.Action():
            timings = "".join(f" {t.kind} {written(t.value)}" for t in node.timings)
            return f"action {written(node.name)} = {written(node.call)}{timings}"
        case s.Observe():
            channels = f" as {written(node.channels)}" if node.channels else ""
            return f"observe {written(node.camera)} at {written(node.times)}{channels}"
        case _:
            return _asking(node)


def _asking(node: Any) -> str:
    match node:
        case s.Question():
            name = f"{written(node.name)} " if node.name else ""
            return f"question {name}{written(node.text)} {_block(node.clauses + node.counterfactuals)}"
        case s.Clause(kind="margin"):
            unless = f" unless {written(node.unless)}" if node.unless else ""
            return f"margin {written(node.value)} apart by {written(node.bound)}{unless}"
        case s.Clause():
            return f"{node.kind} {'by ' if node.kind in ('distinct', 'stable') else ''}{written(node.value)}"
        case s.Counterfactual():
            return f"counterfactual {written(node.name)} {_block(node.changes)}"
        case s.Change(kind="order"):
            return f"order {written(node.target)}, {written(node.value)}"
        case s.Change(kind="without"):
            return f"without {written(node.target)}"
        case _:
            return f"{node.kind} {written(node.target)}: {written(node.value)}"


def _block(nodes: Any) -> str:
    return "{\n" + "".join(f"{written(n)}\n" for n in nodes) + "}"
