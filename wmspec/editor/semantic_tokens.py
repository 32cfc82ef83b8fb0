"""Semantic tokens: what each word of a spec is, by its declaration, for highlighting."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from wmspec.editor.document import Document
from wmspec.editor.names import Names
from wmspec.editor.words import SOFT, constants, functions
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.lexer import Token, tokenize
from wmspec.lang.parse.tables import tables

#: Types of tokens, in the order of the legend.
TYPES = ("keyword", "variable", "parameter", "property", "function", "method", "class", "event", "enumMember",
         "namespace", "number", "string", "comment", "operator")  # fmt: skip
#: Modifiers of tokens.
MODIFIERS = ("declaration", "readonly")

_VERBS = frozenset({*VERBS, *(verb for verbs in ROBOTS.values() for verb in verbs)})
_LITERALS = {
    "COMMENT": "comment",
    "LONG_STRING": "string",
    "STRING": "string",
    "OPEN_STRING": "string",
    "NUMBER": "number",
    "QUANTITY": "number",
    "LIST_UNIT": "number",
    "COMPARE": "operator",
    "PLUS": "operator",
    "MINUS": "operator",
    "TIMES": "operator",
    "RANGE": "operator",
}
_DECLARED: dict[type, str] = {
    s.Factor: "parameter",
    s.Parameter: "parameter",
    s.Let: "variable",
    s.Block: "variable",
    s.Part: "property",
    s.Template: "class",
    s.Action: "event",
    s.Use: "namespace",
    s.File: "namespace",
    s.Task: "class",
    s.Variant: "class",
    s.Question: "class",
    s.Counterfactual: "event",
}


class SemanticToken(NamedTuple):
    """A token: offsets, the type (an index of TYPES), and the modifiers as bits."""

    start: int
    end: int
    type: int
    modifiers: int


def semantic_tokens(document: Document) -> Iterator[SemanticToken]:
    """Yield the tokens of a document that have a type, in order, none over several lines."""
    names = {o.span.start: o for o in Names(document).occurrences}
    tokens = [t for t in tokenize(document.text) if t.type != "WHITE"]
    for i, token in enumerate(tokens):
        occurrence = names.get(token.start)
        if occurrence is not None and occurrence.span.end == token.end:
            kind = _DECLARED.get(type(occurrence.declared.node), "variable")
            here = occurrence.declared.path == document.path.resolve() and occurrence.declared.start == token.start
            yield SemanticToken(token.start, token.end, TYPES.index(kind), int(here))
            continue
        following = tokens[i + 1] if i + 1 < len(tokens) else Token("", "", 0, 0)
        if (word := _type(token, tokens[i - 1].type if i else "", following)) is None:
            continue
        start = token.start
        for line in token.text.splitlines(keepends=True):
            if text := line.rstrip("\r\n"):
                yield SemanticToken(start, start + len(text), TYPES.index(word), 0)
            start += len(line)


def _type(token: Token, before: str, following: Token) -> str | None:
    """Return the type of a token that is no declared name, or None for punctuation and unknown words."""
    if token.type in _LITERALS:
        return _LITERALS[token.type]
    word = token.text
    if following.type == "COLON" and before != "COLON" and word.isidentifier():
        return "property"
    if following.type == "LPAR" and word in functions():
        return "method" if word in _VERBS else "function"
    if word in tables().keywords and not (word in SOFT and before in ("COLON", "DOT")):
        return "keyword"
    return "enumMember" if word in constants() else None
