"""LR parser: a stack of states, advanced token by token through the tables of the grammar."""

from __future__ import annotations

from copy import copy
from typing import Any, NamedTuple

from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.tables import Rule, tables

#: Type of the token after the last one.
END = "$END"


class Tree(NamedTuple):
    """A node of the parse tree: its rule, its children (trees, tokens, None), and its span."""

    rule: str
    children: list[Any]
    start: int
    end: int


class Symbol(NamedTuple):
    """A parsed symbol with its span; an empty symbol starts at infinity and ends at 0."""

    read: Any
    start: float
    end: int


class LRParser:
    """Parses tokens until the end; `result` is then the tree of the whole input."""

    def __init__(self, start: str) -> None:
        """`parts` has one item fewer than `states`."""
        self.tables = tables()
        self.last = self.tables.last[start]
        self.states = [self.tables.first[start]]
        self.parts: list[Symbol] = []
        """One less than states."""
        self.result: Tree | None = None

    def read(self, token: Token) -> bool:
        """Consume a token; return False, without a change of state, if it cannot follow."""
        states, parts = self.states, self.parts
        while (action := self.tables.states[states[-1]].get(token.type)) is not None:
            if action >= 0:
                states.append(action)
                parts.append(Symbol(token, token.start, token.end))
                return True
            rule = self.tables.rules[~action]
            if not rule.passes:
                parts[len(parts) - rule.size :] = [_reduced(rule, parts[len(parts) - rule.size :])]
            del states[len(states) - rule.size :]
            states.append(self.tables.states[states[-1]][rule.origin])
            if token.type == END and states[-1] == self.last:
                self.result = parts[-1].read
                return True
        return False

    def shift(self, kind: str) -> bool:
        """Like `read` with a token type only; builds no tree."""
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

    def accepts(self, kind: str, depth: int | None = None) -> bool:
        """Whether a token type could be read next, with only the first `depth` states on the stack."""
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
        """Return the token types that could be read next; types with the same reductions are followed together."""
        found = set[str]()
        kinds = [kind for kind in self._next([], len(self.states)) if _is_terminal(kind)]
        waiting: list[tuple[list[int], int, list[str]]] = [([], len(self.states), kinds)]
        while waiting:
            pushed, left, kinds = waiting.pop()
            row, reducing = self._next(pushed, left), dict[int, list[str]]()
            for kind in kinds:
                action = row.get(kind)
                if action is not None and action >= 0:
                    found.add(kind)
                elif action is not None:
                    reducing.setdefault(~action, []).append(kind)
            for number, those in reducing.items():
                rule = self.tables.rules[number]
                below = left - max(0, rule.size - len(pushed))
                states = pushed[: max(0, len(pushed) - rule.size)]
                states.append(self._next(states, below)[rule.origin])
                if states[-1] == self.last and END in those:
                    found.add(END)
                    those.remove(END)
                waiting.append((states, below, those))
        return found

    def recover_to(self, *kinds: str) -> bool:
        """Pop states until tokens of these types can follow; leave the stack unchanged if they never can."""
        for depth in range(len(self.states), 0, -1):
            if self.accepts(kinds[0], depth) and self._can_follow(kinds, depth):
                del self.states[depth:], self.parts[depth - 1 :]
                return True
        return False

    def _can_follow(self, kinds: tuple[str, ...], depth: int) -> bool:
        if len(kinds) == 1:
            return True
        other = copy(self)
        other.states = self.states[:depth]
        return all(other.shift(kind) for kind in kinds)

    def _next(self, pushed: list[int], left: int) -> dict[str, int]:
        return self.tables.states[pushed[-1] if pushed else self.states[left - 1]]


def _is_terminal(symbol: str) -> bool:
    return symbol.isupper() or symbol == END


def _reduced(rule: Rule, parts: list[Symbol]) -> Symbol:
    """Return the part that a rule builds from the last parts."""
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
        return Symbol(children[0], start, end)
    return Symbol(Tree(rule.name, children, int(min(start, end)), end), start, end)
