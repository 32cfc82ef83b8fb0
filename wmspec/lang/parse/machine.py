"""The machine that reads: a stack of states, driven word by word through the tables of the grammar."""

from __future__ import annotations

from copy import copy
from typing import Any, NamedTuple

from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.tables import Rule, tables

#: What comes after the last word.
END = "$END"


class Tree(NamedTuple):
    """A node of the parse tree: the rule that made it, its children (trees, words, None), and the text it spans."""

    rule: str
    children: list[Any]
    start: int
    end: int


class Part(NamedTuple):
    """What was read on the way to a state, with its place; nothing begins after everything and ends before it."""

    read: Any
    start: float
    end: int


class Machine:
    """Reads words until the end; `result` is then the tree of all."""

    def __init__(self, start: str) -> None:
        self.tables = tables()
        self.last = self.tables.last[start]
        self.states = [self.tables.first[start]]
        self.parts: list[Part] = []
        """One less than states."""
        self.result: Tree | None = None

    def read(self, token: Token) -> bool:
        """Take in a word; False if it cannot stand here, and then another may be tried."""
        states, parts = self.states, self.parts
        while (action := self.tables.states[states[-1]].get(token.type)) is not None:
            if action >= 0:
                states.append(action)
                parts.append(Part(token, token.start, token.end))
                return True
            rule = self.tables.rules[~action]
            if not rule.passes:
                parts[len(parts) - rule.size :] = [_made(rule, parts[len(parts) - rule.size :])]
            del states[len(states) - rule.size :]
            states.append(self.tables.states[states[-1]][rule.origin])
            if token.type == END and states[-1] == self.last:
                self.result = parts[-1].read
                return True
        return False

    def follow(self, kind: str) -> bool:
        """As `read`, but only the state is kept of what is read; a word of this type is enough."""
        states, moves = self.states, self.tables.states
        while (action := moves[states[-1]].get(kind)) is not None:
            if action >= 0:
                states.append(action)
                return True
            rule = self.tables.rules[~action]
            del states[len(states) - rule.size :]
            states.append(moves[states[-1]][rule.origin])
            if kind == END and states[-1] == self.last:
                return True
        return False

    def takes(self, kind: str, depth: int | None = None) -> bool:
        """Whether a word of a type could be read next, if only the first `depth` states were on the stack."""
        left = len(self.states) if depth is None else depth
        pushed: list[int] = []
        while (action := self._next(pushed, left).get(kind)) is not None:
            if action >= 0:
                return True
            rule = self.tables.rules[~action]
            left -= max(0, rule.size - len(pushed))
            del pushed[max(0, len(pushed) - rule.size) :]
            pushed.append(self._next(pushed, left)[rule.origin])
            if kind == END and pushed[-1] == self.last:
                return True
        return False

    def accepted(self) -> set[str]:
        """The types of words that could be read next."""
        return {kind for kind in self._next([], len(self.states)) if _is_word(kind) and self.takes(kind)}

    def unwind(self, *kinds: str) -> bool:
        """Forget what was read last until words of these types could follow; nothing if they never could."""
        for depth in range(len(self.states), 0, -1):
            if self.takes(kinds[0], depth) and self._follows(kinds, depth):
                del self.states[depth:], self.parts[depth - 1 :]
                return True
        return False

    def _follows(self, kinds: tuple[str, ...], depth: int) -> bool:
        if len(kinds) == 1:
            return True
        other = copy(self)
        other.states = self.states[:depth]
        return all(other.follow(kind) for kind in kinds)

    def _next(self, pushed: list[int], left: int) -> dict[str, int]:
        return self.tables.states[pushed[-1] if pushed else self.states[left - 1]]


def _is_word(symbol: str) -> bool:
    return symbol.isupper() or symbol == END


def _made(rule: Rule, parts: list[Part]) -> Part:
    """What a rule makes of the parts read last."""
    start = min([part.start for part in parts], default=float("inf"))
    end = max([part.end for part in parts], default=0)
    children: list[Any] = []
    for position, spread in rule.kept:
        if position is None:
            children.append(None)
        elif spread:
            inner: list[Any] = parts[position].read.children
            children = children + inner if children else inner  # a long list grows in place
        else:
            children.append(parts[position].read)
    if rule.collapses and len(children) == 1:
        return Part(children[0], start, end)
    return Part(Tree(rule.name, children, int(min(start, end)), end), start, end)
