"""Going on after a mistake: where reading can go on.

Nothing is copied or tried twice, so that it takes time in proportion to the words dropped and the states forgotten.
"""

from __future__ import annotations

from bisect import bisect_left

from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.machine import END, Machine
from wmspec.lang.parse.tables import tables


def recover(machine: Machine, tokens: list[Token], i: int) -> int:
    """Drop tokens up to the next start of a statement, property or `}`, and what was half read before it.

    A block whose header cannot be read is dropped as a whole. Returns the index of the token to go on with; past the
    end if nothing fits.
    """
    stuck, deep = i, 0
    while i < len(tokens):
        kind = tokens[i].type
        far_enough = i > stuck or kind in tables().starters
        if (deep == 0 or kind == END) and far_enough and _goes_on(machine, tokens, i):
            return i
        deep = max(0, deep + (kind == "LBRACE") - (kind == "RBRACE"))
        i += 1
    return i


def dropped(machine: Machine, tokens: list[Token], i: int) -> list[Token]:
    """The words without those that `recover` drops and forgets."""
    on = recover(machine, tokens, i)
    if on >= len(tokens):
        return [*tokens[:i], tokens[-1]] if tokens[i].type != END else [tokens[-1]]
    read = max((part.end for part in machine.parts), default=0)
    kept = bisect_left([token.end for token in tokens[:i]], int(read) + 1)
    return [*tokens[:kept], *tokens[on:]]


def _goes_on(machine: Machine, tokens: list[Token], i: int) -> bool:
    """Forget what was half read if reading could then go on here: with a statement, a property or a `}`."""
    kind = tokens[i].type
    if kind in ("RBRACE", END):
        return machine.unwind(kind)
    if kind in tables().starters:  # some of them are names too: what follows tells
        return machine.unwind(kind, tokens[i + 1].type) or machine.unwind(kind)
    return tokens[i + 1].type == "COLON" and machine.unwind(kind, "COLON")
