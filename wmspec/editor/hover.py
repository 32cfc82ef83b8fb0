"""Documentation of the word at a place, from the tables of the language or its declaration."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

from wmspec.core.node import Node
from wmspec.core.places import Source, Span
from wmspec.editor.complete import accepted_values, type_with_example
from wmspec.editor.document import Document
from wmspec.editor.names import Names, Occurrence
from wmspec.lang.check.expressions.calls import signature
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import Failed
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS, Verb
from wmspec.lang.check.tables.vocabulary import (
    CLAUSE_WORDS,
    CLAUSES,
    COLORS,
    DESIGNS,
    FACTOR_DIMENSIONS,
    JOINTS,
    LEGIBILITY,
    PROPERTIES,
    SETS,
    TOLERANCES,
    WORDS,
    PropertySpec,
)
from wmspec.lang.check.types.units import UNITS, UnknownUnit, parse_unit
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.parser import tokens_and_comments
from wmspec.lang.parse.tables import tables
from wmspec.sim.materials import MATERIALS


@dataclass(frozen=True)
class Hover:
    """Markdown for a span."""

    span: Span
    markdown: str


def hover(document: Document, offset: int) -> Hover | None:
    """Return the documentation of the word at an offset; None if there is none."""
    token = _token(document, offset)
    if token is None:
        return None
    span = Span(document.source, token.start, token.end)
    nodes = document.nodes_at(offset)
    text = _key(document, nodes, token)
    if not text and (name := Names(document).at(offset)) is not None:
        return Hover(name.span, _declared(document, document.meaning(offset), name))
    text = text or _clause(token, nodes) or _unit(token) or _word(token.text) or _keyword(token, nodes)
    return Hover(span, text) if text else None


def _token(document: Document, offset: int) -> Token | None:
    touching = [t for t in tokens_and_comments(document.text) if t.start <= offset <= t.end and t.type != "COMMENT"]
    telling = [t for t in touching if t.text[0].isalnum() or t.text[0] == "_"]
    return next(reversed(telling or touching), None)


# ---------------------------------------------------------------- properties, arguments, verbs


def _key(document: Document, nodes: list[Node], token: Token) -> str:  # noqa: C901  one case per owner
    """Return the documentation of a property or an argument, from the table of its owner."""
    name = nodes[-1]
    if isinstance(name, s.Word) and name.id in FACTOR_DIMENSIONS:
        return f"`about {name.id}`: {FACTOR_DIMENSIONS[name.id]}"
    if isinstance(name, s.Word) and len(nodes) > 1 and isinstance(nodes[-2], s.Legibility) and name.id in LEGIBILITY:
        return f"`legibility {name.id}`: {LEGIBILITY[name.id]}"
    if not isinstance(name, s.Name) or len(nodes) < 2:
        return ""
    holder, outer = nodes[-2], nodes[:-2]
    match holder:
        case s.Property(name=s.Name(id=key)) if holder.name is name:
            whole = next((n for n in reversed(outer) if isinstance(n, s.Part | s.Block | s.Template)), None)
            slot = PROPERTIES.get(_kind(whole), {}).get(key)
            return slot_markdown(f"{key}:", slot) if slot is not None else ""
        case s.Argument(name=s.Name(id=key)) if holder.name is name:
            call = next((n for n in reversed(outer) if isinstance(n, s.Call)), None)
            called = call.function.span.text if call else ""
            verb = _verb(called)
            if verb is not None and key in verb.arguments:
                return slot_markdown(f"{key}:", verb.arguments[key])
            return _function(called)
        case s.Call(function=function) if function is name:
            verb = VERBS.get(name.id) if any(isinstance(n, s.Action) for n in outer) else None
            return verb_markdown(name.id, verb) if verb is not None else _function(name.id)
        case s.Member(name=last) if last is name and any(isinstance(n, s.Call) and n.function is holder for n in outer):
            robot = _verb(f".{name.id}")
            return verb_markdown(name.id, robot) if robot is not None else ""
        case s.Member(name=last) if last is name:
            slot = next((table[name.id] for table in PROPERTIES.values() if name.id in table), None)
            declared = Names(document).at(token.start)
            return slot_markdown(name.id, slot) if slot is not None and declared is None else ""
        case s.Design(kind=kind) if kind is name and name.id in DESIGNS:
            return f"`{DESIGNS[name.id].written}`\n\n{DESIGNS[name.id].meaning}"
        case s.Tolerance(name=kind) if kind is name and name.id in TOLERANCES:
            return slot_markdown(name.id, TOLERANCES[name.id])
        case s.Block(model=model, kind=kind) if model is name and SETS.get(kind, kind) == "joint" and name.id in JOINTS:
            return f"`{name.id}`: {JOINTS[name.id]}"
    return ""


def _kind(whole: Node | None) -> str:
    match whole:
        case s.Part():
            return "part"
        case s.Block(kind=kind):
            return SETS.get(kind, kind)
    return "object"


def _verb(called: str) -> Verb | None:
    _, dot, name = called.rpartition(".")
    if not dot:
        return VERBS.get(called)
    return next((verbs[name] for verbs in ROBOTS.values() if name in verbs), None)


def _function(name: str) -> str:
    if name not in FUNCTIONS:
        return ""
    function = FUNCTIONS[name]
    where = "\n\nMeasured on the executed episode." if function.measured else ""
    result = type_with_example(function.result)
    return f"```wms\n{signature(name, function)}\n```\n{function.meaning}; returns {result}{where}"


def slot_markdown(name: str, slot: PropertySpec) -> str:
    """Return the meaning, types and default of a property or argument."""
    kinds = " or ".join(type_with_example(t) for t in slot.types)
    left_out = f"  \ndefault: `{slot.default}`" if slot.default is not None else ""
    return f"**{name}** {slot.meaning}\n\ntakes {kinds}{left_out}"


def verb_markdown(name: str, verb: Verb) -> str:
    """Return the signature, meaning and arguments of a verb."""
    call = f"{name}({', '.join(verb.arguments)}){' for TIME' if verb.lasts else ''}"
    rows = "\n".join(f"- `{key}`: {slot.meaning} ({accepted_values(slot)})" for key, slot in verb.arguments.items())
    return f"```wms\n{call}\n```\n{verb.meaning}\n\n{rows}".rstrip()


# ---------------------------------------------------------------- words and names


def _unit(token: Token) -> str:
    if token.type not in ("QUANTITY", "LIST_UNIT"):
        return ""
    unit = token.text.lstrip("0123456789.eE+- \t") if token.type == "QUANTITY" else token.text.strip()
    with suppress(UnknownUnit):
        scale, dimension = parse_unit(unit)
        one = f": {scale:.6g} {dimension.symbol}".rstrip() if dimension.symbol and unit in UNITS else ""
        return f"`{unit}`, a unit of {dimension}{one}"
    return ""


def _clause(token: Token, nodes: list[Node]) -> str:
    """Return the documentation of a clause of a question, at its keyword or at the word that is its value."""
    kind = next((node.kind for node in reversed(nodes) if isinstance(node, s.Clause)), "")
    form = CLAUSE_WORDS.get((kind, token.text))
    if form is None and token.text in tables().keywords and isinstance(nodes[-1], s.Clause):
        form = CLAUSES.get(kind)
    return f"`{form.written}`\n\n{form.meaning}" if form is not None else ""


def _word(word: str) -> str:
    if word in MATERIALS:
        return f"`{word}`, a material: {MATERIALS[word].meaning}"
    if word in COLORS:
        return f"`{word}`, a color: rgb({', '.join(f'{c:g}' for c in COLORS[word])})"
    kinds = [vocabulary for vocabulary, all_ in WORDS.items() if word in all_]
    return f"`{word}`, a word for a {' or a '.join(kinds)}" if kinds else ""


def _keyword(token: Token, nodes: list[Node]) -> str:
    """Return the documentation of the statement that a keyword begins or is part of."""
    if token.text not in tables().keywords:
        return ""
    node = nodes[-1]
    about = (type(node).__doc__ or "").strip()
    return "" if isinstance(node, s.File | s.Task) and token.text != "task" else about


def _declared(document: Document, meaning: Expressions | None, name: Occurrence) -> str:
    """Return the first line of a declaration, with its type and file."""
    node = name.declared.node
    if isinstance(node, s.File):  # a library
        about = next((item.text for item in node.items if isinstance(item, s.Docstring)), "")
        return f"library `{name.declared.path.name}`\n\n{about}"
    source: Source = node.span.source
    first = node.span.text.partition("\n")[0].rstrip()
    of = ""
    known = meaning.scope.names.get(name.span.text) if meaning is not None else None
    if meaning is not None and isinstance(node, s.Factor | s.Let) and known is not None:
        with suppress(Failed):
            of = f"\n\n{type_with_example(meaning.infer(s.Name(name.span.text, name.span)).type)}"
    where = "" if source.name == document.source.name else f"\n\nfrom `{source.name}`"
    return f"```wms\n{first}\n```{of}{where}"
