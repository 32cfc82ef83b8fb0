"""Going on after a mistake: where reading can go on.

Nothing is copied or tried twice, so that it takes time in proportion to the words dropped and the states forgotten.
"""

from __future__ import annotations

from bisect import bisect_left

from wmspec.parse.machine import END, Machine
from wmspec.parse.tables import tables
from wmspec.parse.words import Token


def recover(machine: Machine, tokens: list[Token], i: int) -> int:
    """Drop tokens up to the next start of a statement, property or `}`, and what was half read before it.

    Returns the index of the token to go on with; past the end if nothing fits.
    """
    stuck, starters = i, tables().starters
    while i < len(tokens):
        if (i > stuck or tokens[i].type in starters) and (kinds := _boundary(tokens, i)) and machine.unwind(*kinds):
            return i
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


def _boundary(tokens: list[Token], i: int) -> tuple[str, ...]:
    """The types of the words with which reading could go on here; none if it is no place to go on."""
    kind = tokens[i].type
    if kind in tables().starters or kind in ("RBRACE", END):
        return (kind,)
    return (kind, "COLON") if tokens[i + 1].type == "COLON" else ()
