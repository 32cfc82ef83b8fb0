"""What may be written at a place of a text, read off the parser's own stack, whatever comes after it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from wmspec.lang.parse.lexer import Token, read
from wmspec.lang.parse.machine import END, Machine, Part, Tree
from wmspec.lang.parse.recover import recover
from wmspec.lang.parse.tables import tables

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
#: A number with its unit so far; of a name that ends in a digit it is no part.
_QUANTITY = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:[eE][+-]?\d+)?[ \t]*(?P<unit>(?:[A-Za-z%][A-Za-z0-9^*/%-]*)?)\Z")
_LIST = re.compile(r"\][ \t]+(?P<unit>(?:[A-Za-z%][A-Za-z0-9^*/%-]*)?)\Z")


@dataclass(frozen=True)
class Cursor:
    """A place in a text: where the word there begins, and what was read before it.

    `keywords` may stand there. `stack` is what a name there would follow, outermost first; None if no name may stand.
    `unit` is where a unit begins that may stand there, with the stack before its number or list.
    """

    start: int
    keywords: tuple[str, ...] = ()
    stack: tuple[Part, ...] | None = None
    unit: tuple[int, tuple[Part, ...]] | None = None


def cursor(text: str, offset: int) -> Cursor | None:
    """What may be written at an offset; None within a comment or a text."""
    before = text[:offset]
    word = _WORD.search(before)
    start = word.start() if word else offset
    tokens = [t for t in read(before[:start]) if t.type != "WHITE"]
    if tokens and _goes_on(tokens[-1], start):
        return None
    machine = _fed(before[:start])
    words = {kind: word for word, kind in tables().keywords.items()}
    kinds = machine.accepted() & words.keys()
    keywords = tuple(sorted(words[kind] for kind in kinds if not _only_a_name(machine, kind)))
    return Cursor(start, keywords, _stack(machine, "NAME", start), _unit(before))


def _goes_on(last: Token, offset: int) -> bool:
    """Whether a comment or a text that began before the offset holds it."""
    return last.end == offset and last.type in ("COMMENT", "OPEN_STRING")


def _unit(before: str) -> tuple[int, tuple[Part, ...]] | None:
    if number := _QUANTITY.search(before):
        stack = _stack(_fed(before[: number.start()]), "NUMBER", number.start())
        return (number.start("unit"), stack) if stack is not None else None
    if units := _LIST.search(before):
        machine = _fed(before[: units.start() + 1])
        opened = [i for i, part in enumerate(machine.parts) if symbol(part) == "LSQB"]
        return (units.start("unit"), tuple(machine.parts[: opened[-1] + 1])) if opened else None
    return None


def _stack(machine: Machine, kind: str, offset: int) -> tuple[Part, ...] | None:
    """What a word of this type would follow."""
    tried = _copy(machine)
    return tuple(tried.parts[:-1]) if tried.read(Token(kind, "x", offset, 0)) else None


def _only_a_name(machine: Machine, kind: str) -> bool:
    """Whether a keyword of this type would be no more than a name there."""
    tried = _copy(machine)
    tried.read(Token(kind, "x", 0, 0))
    actions = tried.tables.states[tried.states[-1]].values()
    return all(action < 0 and tried.tables.rules[~action].origin == "name" for action in actions)


def _fed(text: str) -> Machine:
    """The machine after a text. What cannot be read is passed over, but never the last statement."""
    tokens = [t for t in read(text) if t.type not in ("WHITE", "COMMENT", "STRAY", "OPEN_STRING")]
    tokens.append(Token(END, "", len(text), 0))
    machine, i = Machine("start"), 0
    while i < len(tokens) - 1:
        if machine.read(tokens[i]):
            i += 1
            continue
        kept = _copy(machine)
        i = recover(machine, tokens, i)
        if i >= len(tokens) - 1:
            return kept
    return machine


def _copy(machine: Machine) -> Machine:
    copy = Machine("start")
    copy.states, copy.parts = list(machine.states), list(machine.parts)
    return copy


def symbol(part: Part) -> str:
    """What a part is: the type of a word, or the rule of a tree."""
    match part.read:
        case Token(type=kind):
            return kind
        case Tree(rule=rule):
            return rule
    return ""
