"""Error repair: the most likely intended text where a token cannot follow.

Tokens around the error are inserted, deleted or replaced. The candidate that lets the parser read furthest wins; among
equals, the likeliest. Each error is thus reported once, with its correction, and parsing continues as if it had been
applied.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

from wmspec.lang.parse.foreign_syntax import foreign_candidates
from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.lr_parser import LRParser
from wmspec.lang.parse.repair_candidates import Repair, RepairSite, end_of_hyphenated, repair_candidates
from wmspec.lang.parse.tables import tables

#: Tokens before the rejected one that may change, and tokens after it that are read to compare candidates.
MAX_TOKENS_BACK, MAX_TOKENS_AHEAD = 14, 24
#: A change is accepted if this many tokens can be read after it, or one if its cost is lower than this.
MIN_TOKENS_READ, LIKELY_COST = 3, 2.5
#: Extra cost for each token that a change lies further back.
_DISTANCE_COST = 0.15


def repair(start: str, words: Sequence[Token], stuck: int, own: Repair | None = None) -> Repair | None:
    """Return the change after which most tokens around the error can be parsed, or None if none helps much.

    `own` is a further candidate.
    """
    stacks = _stacks(start, words, stuck)
    furthest = min(len(words) - stuck, MAX_TOKENS_AHEAD)
    best, merit = None, (0, 0.0)
    machine = LRParser(start)
    for one, cost in chain(() if own is None else ((own, own.cost),), _candidates(start, words, stuck, stacks)):
        if one.start not in stacks or (furthest, -cost) <= merit:
            continue
        machine.states = list(stacks[one.start])
        reached = _reach(machine, one, words, stuck)
        worth = reached >= MIN_TOKENS_READ or stuck + reached >= len(words) or (reached > 0 and cost < LIKELY_COST)
        if (reached, -cost) > merit and worth:
            best, merit = one, (reached, -cost)
    return best


def apply_repair(change: Repair, words: Sequence[Token]) -> list[Token]:
    """Return the tokens with the change applied."""
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
        if [t.text for t in made[i:end]] == written and end_of_hyphenated(made, i) == end:
            made[i:end] = [made[i]._replace(type="NAME", text=name.text)]
        i += 1
    return made


def keeps_names(change: Repair, words: Sequence[Token]) -> bool:
    """Whether the change cannot hide or alter a name."""
    names = [t for t in words[change.start : change.stop] if t.type == "NAME"]
    guessed = any(t.type in tables().starters for t in change.words) and change.start == change.stop
    return not change.hyphenated and not guessed and (bool(change.words) or not names)


def _candidates(
    start: str, words: Sequence[Token], stuck: int, stacks: dict[int, list[int]]
) -> Iterator[tuple[Repair, float]]:
    """Yield the candidates with their costs, which grow with the distance."""
    for i, states in stacks.items():
        machine = LRParser(start)
        machine.states = states
        place = RepairSite(words, i, machine.accepted())
        for one in (*repair_candidates(place, stuck), *foreign_candidates(place)):
            yield one, one.cost + _DISTANCE_COST * (stuck - i)


def _stacks(start: str, words: Sequence[Token], stuck: int) -> dict[int, list[int]]:
    """Return the parser's state stack before each token up to the rejected one."""
    machine, stacks = LRParser(start), {}
    for i in range(stuck + 1):
        if i >= stuck - MAX_TOKENS_BACK:
            stacks[i] = list(machine.states)
        if i < stuck:
            machine.shift(words[i].type)
    return stacks


def _reach(machine: LRParser, change: Repair, words: Sequence[Token], stuck: int) -> int:
    """Return how many tokens from the rejected one on can be read after the change."""
    if not all(machine.shift(word.type) for word in change.words):
        return 0
    most = min(len(words), stuck + MAX_TOKENS_AHEAD)
    for i in range(change.stop, most):
        if not machine.shift(words[i].type):
            return max(0, i - stuck)
    return most - stuck
