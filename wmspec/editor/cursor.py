"""The parser state at a place in a text, independent of the text after it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from wmspec.lang.parse.lexer import Token, tokenize
from wmspec.lang.parse.lr_parser import END, LRParser, Symbol, Tree
from wmspec.lang.parse.recover import recover
from wmspec.lang.parse.tables import tables

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
#: A number with an incomplete unit; not the end of a name with a digit.
_QUANTITY = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:[eE][+-]?\d+)?[ \t]*(?P<unit>(?:[A-Za-z%][A-Za-z0-9^*/%-]*)?)\Z")
_LIST = re.compile(r"\][ \t]+(?P<unit>(?:[A-Za-z%][A-Za-z0-9^*/%-]*)?)\Z")


@dataclass(frozen=True)
class Cursor:
    """A place in a text: the start of the word there, and the parser state before it.

    `keywords` are accepted there. `stack` is the parser's stack before a name, outermost symbol first; None if no name
    is accepted. `unit` is the start of an accepted unit, with the stack before its number or list.
    """

    start: int
    keywords: tuple[str, ...] = ()
    stack: tuple[Symbol, ...] | None = None
    unit: tuple[int, tuple[Symbol, ...]] | None = None


def cursor(text: str, offset: int) -> Cursor | None:
    """Return the cursor at an offset; None within a comment or a string."""
    before = text[:offset]
    word = _WORD.search(before)
    start = word.start() if word else offset
    tokens = [t for t in tokenize(before[:start]) if t.type != "WHITE"]
    if tokens and _goes_on(tokens[-1], start):
        return None
    machine = _fed(before[:start])
    words = {kind: word for word, kind in tables().keywords.items()}
    kinds = machine.accepted() & words.keys()
    keywords = tuple(sorted(words[kind] for kind in kinds if not _only_a_name(machine, kind)))
    return Cursor(start, keywords, _stack(machine, "NAME", start), _unit(before))


def _goes_on(last: Token, offset: int) -> bool:
    """Whether a comment or string from before the offset contains it."""
    return last.end == offset and last.type in ("COMMENT", "OPEN_STRING")


def _unit(before: str) -> tuple[int, tuple[Symbol, ...]] | None:
    if number := _QUANTITY.search(before):
        stack = _stack(_fed(before[: number.start()]), "NUMBER", number.start())
        return (number.start("unit"), stack) if stack is not None else None
    if units := _LIST.search(before):
        machine = _fed(before[: units.start() + 1])
        opened = [i for i, part in enumerate(machine.parts) if symbol(part) == "LSQB"]
        return (units.start("unit"), tuple(machine.parts[: opened[-1] + 1])) if opened else None
    return None


def _stack(machine: LRParser, kind: str, offset: int) -> tuple[Symbol, ...] | None:
    """Return the stack before a token of this type; None if it is not accepted."""
    tried = _copy(machine)
    return tuple(tried.parts[:-1]) if tried.read(Token(kind, "x", offset, 0)) else None


def _only_a_name(machine: LRParser, kind: str) -> bool:
    """Whether the grammar accepts a keyword of this type only as a name."""
    tried = _copy(machine)
    tried.read(Token(kind, "x", 0, 0))
    actions = tried.tables.states[tried.states[-1]].values()
    return all(action < 0 and tried.tables.rules[~action].origin == "name" for action in actions)


def _fed(text: str) -> LRParser:
    """Return the parser after a text. It skips unreadable parts, but never the last statement."""
    tokens = [t for t in tokenize(text) if t.type not in ("WHITE", "COMMENT", "STRAY", "OPEN_STRING")]
    tokens.append(Token(END, "", len(text), 0))
    machine, i = LRParser("start"), 0
    while i < len(tokens) - 1:
        if machine.read(tokens[i]):
            i += 1
            continue
        parser = _copy(machine)
        i = recover(machine, tokens, i)
        if i >= len(tokens) - 1:
            return parser
    return machine


def _copy(machine: LRParser) -> LRParser:
    copy = LRParser("start")
    copy.states, copy.parts = list(machine.states), list(machine.parts)
    return copy


def symbol(part: Symbol) -> str:
    """Return the symbol of a stack entry: the type of a token, or the rule of a tree."""
    match part.read:
        case Token(type=kind):
            return kind
        case Tree(rule=rule):
            return rule
    return ""
