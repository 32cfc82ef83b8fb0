"""Going on after a mistake: where reading can go on.

Nothing is copied or tried twice, so that it takes time in proportion to the words dropped and the states forgotten.
"""

from __future__ import annotations

from wmspec.parse.machine import END, Machine
from wmspec.parse.tables import tables
from wmspec.parse.words import Token


def recover(machine: Machine, tokens: list[Token], i: int) -> int:
    """Drop tokens up to the next start of a statement, property or `}`, and what was half read before it.

    Returns the index of the token to go on with; past the end if nothing fits.
    """
    stuck, starters = i, tables().starters
    while i < len(tokens):
        if (i > stuck or tokens[i].type in starters) and _boundary(tokens, i) and machine.unwind(tokens[i].type):
            return i
        i += 1
    return i


def _boundary(tokens: list[Token], i: int) -> bool:
    return tokens[i].type in tables().starters or tokens[i].type in ("RBRACE", END) or tokens[i + 1].type == "COLON"
