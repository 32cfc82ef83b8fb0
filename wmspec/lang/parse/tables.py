"""The tables that text is read with: worked out from the grammar by Lark once, then kept in the user's cache.

Reading needs the tables alone, and not Lark, which takes longer to import than a spec to check.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import re
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wmspec.core.resources import resource

if TYPE_CHECKING:
    from lark import Lark

STARTS = ("start", "expr")
#: The rules of what reading can go on with after a mistake.
STATEMENTS = ("task", "use", "variant", "_statement", "_clause")


@dataclass(frozen=True)
class Rule:
    """A rule of the grammar: what it makes of how many parts, and the node that comes of it.

    `kept` says what the children of the node are: the part at a position (None: a part that was left out), or that
    part's own children. A node with one child is that child if it `collapses`; it `passes` what it has if it always is.
    """

    name: str
    origin: str
    size: int
    kept: tuple[tuple[int | None, bool], ...]
    collapses: bool
    passes: bool


@dataclass(frozen=True)
class Tables:
    """How text is read.

    `pattern` matches one word, in the group of its type; `keywords` are the types of what is otherwise a name. In a
    state, what comes next leads to the state of that number, or, if it is negative, completes the rule `~number`.
    `starters` are the types of words that begin a statement or clause, `value_ends` of those that end a value.
    """

    pattern: str
    keywords: dict[str, str]
    rules: tuple[Rule, ...]
    states: tuple[dict[str, int], ...]
    first: dict[str, int]
    last: dict[str, int]
    starters: frozenset[str]
    value_ends: frozenset[str]


@cache
def tables() -> Tables:
    """The tables of the grammar, from the cache if they were made before for this grammar, code and Python."""
    text = grammar()
    path = _cache_file(text)
    # Whatever is wrong with the cache (a read-only home, a file cut short), the tables are made anew.
    with suppress(Exception), path.open("rb") as file:
        kept = pickle.load(file)  # noqa: S301  the user's own cache
        if isinstance(kept, Tables):
            return kept
    made = _made(lark_parser(text))
    with suppress(OSError):
        _keep(made, path)
    return made


def grammar() -> str:
    """The text of the grammar."""
    return resource("grammar/wms.lark").read_text(encoding="utf-8")


def lark_parser(text: str) -> Lark:
    """Lark's parser for the grammar."""
    from lark import Lark

    return Lark(text, parser="lalr", lexer="basic", start=list(STARTS))


# ---------------------------------------------------------------- the cache


def _cache_file(text: str) -> Path:
    root = os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()
    this = Path(__file__).read_text(encoding="utf-8")
    made_for = hashlib.sha256("\0".join((text, this, sys.version)).encode()).hexdigest()
    return Path(root, "wmspec", f"grammar-{made_for[:16]}.tables")


def _keep(made: Tables, path: Path) -> None:
    """Write the tables whole or not at all: another process may read them at any time."""
    import tempfile

    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            pickle.dump(made, file)
        Path(name).replace(path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise


# ---------------------------------------------------------------- from Lark


def _made(lark: Lark) -> Tables:
    pattern, keywords = _words(lark)
    ways = {start: lark.parse_interactive("", start=start).parser_state.parse_conf for start in STARTS}
    table: dict[int, dict[str, Any]] = ways[STARTS[0]].parse_table.states
    number = {state: i for i, state in enumerate(table)}
    rules = {rule: i for i, rule in enumerate(lark.rules)}

    def action(kind: Any, what: Any) -> int:
        return number[what] if kind.name == "Shift" else ~rules[what]

    return Tables(
        pattern=pattern,
        keywords=keywords,
        rules=tuple(map(_rule, lark.rules)),
        states=tuple({str(name): action(*what) for name, what in actions.items()} for actions in table.values()),
        first={start: number[way.start_state] for start, way in ways.items()},
        last={start: number[way.end_state] for start, way in ways.items()},
        starters=frozenset().union(*(_at_the_edge(lark, part, 0) for part in STATEMENTS)),
        value_ends=_at_the_edge(lark, "expr", -1),
    )


def _at_the_edge(lark: Lark, origin: str, edge: int) -> frozenset[str]:
    """The types of the words with which what a rule makes can begin (`edge` 0) or end (-1). No rule makes nothing."""
    words, origins, waiting = set[str](), {origin}, [origin]
    while waiting:
        one = waiting.pop()
        for symbol in (rule.expansion[edge] for rule in lark.rules if rule.origin.name == one):
            if symbol.is_term:
                words.add(str(symbol.name))
            elif symbol.name not in origins:
                origins.add(symbol.name)
                waiting.append(symbol.name)
    return frozenset(words)


def _words(lark: Lark) -> tuple[str, dict[str, str]]:
    """The expression for a word, and the words of the language that are written like names."""
    name = next(t.pattern.to_regexp() for t in lark.terminals if t.name == "NAME")
    fixed = {t.pattern.value: t.name for t in lark.terminals if t.pattern.type == "str" and t.priority == 0}
    keywords = {word: kind for word, kind in fixed.items() if re.fullmatch(name, word)}
    others = [t for t in lark.terminals if t.name not in keywords.values()]
    # As Lark does: by priority, and then what may be longer first.
    others.sort(key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name))
    return "|".join(f"(?P<{t.name}>{t.pattern.to_regexp()})" for t in others), keywords


def _rule(rule: Any) -> Rule:
    """What becomes of a rule's parts: words without a meaning of their own go, and `[...]` leaves gaps."""
    options = rule.options
    gaps = options.empty_indices or (False,) * len(rule.expansion)
    kept: list[tuple[int | None, bool]] = []
    parts = iter(enumerate(rule.expansion))
    for gap in gaps:
        if gap:
            kept.append((None, False))
            continue
        position, symbol = next(parts)
        if options.keep_all_tokens or not (symbol.is_term and symbol.filter_out):
            kept.append((position, not symbol.is_term and symbol.name.startswith("_")))
    collapses = options.expand1 and not rule.alias
    return Rule(
        name=str(rule.alias or rule.origin.name),
        origin=str(rule.origin.name),
        size=len(rule.expansion),
        kept=tuple(kept),
        collapses=collapses,
        passes=collapses and len(rule.expansion) == 1 and kept == [(0, False)],
    )
