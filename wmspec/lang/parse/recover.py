"""Panic-mode recovery: where parsing can continue after an error.

Nothing is copied or retried, so the time is linear in the dropped tokens and popped states.
"""

from __future__ import annotations

from bisect import bisect_left

from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.lr_parser import END, LRParser
from wmspec.lang.parse.tables import tables


def recover(machine: LRParser, tokens: list[Token], i: int) -> int:
    """Drop tokens up to the next start of a statement, property or `}`, and the unfinished rule before it.

    A block whose header cannot be parsed is dropped as a whole. Returns the index of the next token, or one past the
    end if nothing fits.
    """
    stuck, deep = i, 0
    while i < len(tokens):
        kind = tokens[i].type
        far_enough = i > stuck or kind in tables().starters
        if (deep == 0 or kind == END) and far_enough and _can_continue(machine, tokens, i):
            return i
        deep = max(0, deep + (kind == "LBRACE") - (kind == "RBRACE"))
        i += 1
    return i


def drop_unreadable(machine: LRParser, tokens: list[Token], i: int) -> list[Token]:
    """Return the tokens without those that `recover` drops."""
    on = recover(machine, tokens, i)
    if on >= len(tokens):
        return [*tokens[:i], tokens[-1]] if tokens[i].type != END else [tokens[-1]]
    read = max((part.end for part in machine.parts), default=0)
    kept = bisect_left([token.end for token in tokens[:i]], int(read) + 1)
    return [*tokens[:kept], *tokens[on:]]


def _can_continue(machine: LRParser, tokens: list[Token], i: int) -> bool:
    """Pop the unfinished rule if parsing can then continue here with a statement, a property or a `}`."""
    kind = tokens[i].type
    if kind in ("RBRACE", END):
        return machine.recover_to(kind)
    if kind in tables().starters:  # some are names too: the next token decides
        return machine.recover_to(kind, tokens[i + 1].type) or machine.recover_to(kind)
    return tokens[i + 1].type == "COLON" and machine.recover_to(kind, "COLON")
