"""Mending: when a word cannot stand where it does, what was most likely meant.

Words are put in, left out or changed around that place, and what lets most of what follows be read is taken, of equals
what is likelier. So a mistake is told once, with the change that mends it, and reading goes on as if it had been made.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain

from wmspec.lang.parse.foreign_syntax import elsewhere
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.machine import Machine
from wmspec.lang.parse.repair_candidates import Place, Repair, guesses, hyphenated
from wmspec.lang.parse.tables import tables

#: How many words before the one that cannot stand there are looked at, and how many are read after it to compare.
BACK, AHEAD = 14, 24
#: How many must be read after it for a change to be worth it, unless it costs less than so much.
LEAST, LIKELY = 3, 2.5
#: What each word further back makes a change less likely.
_FAR = 0.15


def repair(start: str, words: Sequence[Token], stuck: int, own: Repair | None = None) -> Repair | None:
    """The change that lets most be read of the words around the one that cannot be read; None if none helps much.

    `own` is a guess that the caller has.
    """
    stacks = _stacks(start, words, stuck)
    best, merit = None, (0, 0.0)
    for one in chain(() if own is None else (own,), _guesses(start, words, stuck, stacks)):
        if one.start not in stacks:
            continue
        machine = Machine(start)
        machine.states = list(stacks[one.start])
        reached = _reach(machine, one, words, stuck)
        worth = reached >= LEAST or stuck + reached >= len(words) or (reached > 0 and one.cost < LIKELY)
        if (reached, -one.cost) > merit and worth:
            best, merit = one, (reached, -one.cost)
    return best


def repaired(change: Repair, words: Sequence[Token]) -> list[Token]:
    """The words with the change."""
    rest = list(words[change.stop :])
    if change.closes is not None:
        last = words[change.closes]
        rest.insert(change.closes - change.stop, Token("RBRACE", "", last.start, last.line))
    made = [*words[: change.start], *change.words, *rest]
    if not change.hyphenated:
        return made
    written, (name,) = [t.text for t in words[change.start : change.stop]], change.words
    i = 0
    while i < len(made):
        end = i + len(written)
        if [t.text for t in made[i:end]] == written and hyphenated(made, i) == end:
            made[i:end] = [made[i]._replace(type="NAME", text=name.text)]
        i += 1
    return made


def sure(change: Repair, words: Sequence[Token]) -> bool:
    """Whether no name may be missing, or be another one, with the change."""
    names = [t for t in words[change.start : change.stop] if t.type == "NAME"]
    guessed = any(t.type in tables().starters for t in change.words) and change.start == change.stop
    return not change.hyphenated and not guessed and (bool(change.words) or not names)


def _guesses(start: str, words: Sequence[Token], stuck: int, stacks: dict[int, list[int]]) -> Iterator[Repair]:
    for i, states in stacks.items():
        machine = Machine(start)
        machine.states = states
        place = Place(words, i, machine.accepted())
        for one in (*guesses(place, stuck), *elsewhere(place)):
            yield replace(one, cost=one.cost + _FAR * (stuck - i))


def _stacks(start: str, words: Sequence[Token], stuck: int) -> dict[int, list[int]]:
    """What the machine remembers before each of the words up to the one that cannot be read."""
    machine, stacks = Machine(start), {}
    for i in range(stuck + 1):
        if i >= stuck - BACK:
            stacks[i] = list(machine.states)
        if i < stuck:
            machine.follow(words[i].type)
    return stacks


def _reach(machine: Machine, change: Repair, words: Sequence[Token], stuck: int) -> int:
    """How many words can be read from the stuck one on, if the change is made."""
    if not all(machine.follow(word.type) for word in change.words):
        return 0
    most = min(len(words), stuck + AHEAD)
    for i in range(change.stop, most):
        if not machine.follow(words[i].type):
            return max(0, i - stuck)
    return most - stuck
