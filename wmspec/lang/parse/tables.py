"""LALR tables: generated from the grammar by Lark once, then cached in the user's cache folder.

Parsing needs the tables only. Importing Lark takes longer than checking a spec.
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
#: Rules at which parsing can continue after an error.
STATEMENTS = ("task", "use", "variant", "_statement", "_clause")


@dataclass(frozen=True)
class Rule:
    """A rule of the grammar: its number of symbols, and the node that it builds.

    `kept` lists the node's children: the position of a part (None: an omitted part), and whether that part's own
    children are spliced in. A node with one child is replaced by it if `collapses`; it is always spliced if `passes`.
    """

    name: str
    origin: str
    size: int
    kept: tuple[tuple[int | None, bool], ...]
    collapses: bool
    passes: bool


@dataclass(frozen=True)
class Tables:
    """Lexer and parser tables.

    `pattern` matches one token, in the group named by its type. `keywords` maps words that look like names to their
    types. In a state, the next symbol leads to that state or, if negative, completes the rule `~number`. `starters` are
    the token types that begin a statement or clause; `value_ends` are those that end a value.
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
    """Return the tables of the grammar, cached by grammar, code and Python version."""
    text = grammar()
    path = _cache_file(text)
    # The tables are generated again after any problem with the cache (a read-only home, a truncated file).
    with suppress(Exception), path.open("rb") as file:
        kept = pickle.load(file)  # noqa: S301  the user's cache folder
        if isinstance(kept, Tables):
            return kept
    made = _build_tables(lark_parser(text))
    with suppress(OSError):
        _store(made, path)
    return made


def grammar() -> str:
    """Return the text of the grammar."""
    return resource("grammar/wms.lark").read_text(encoding="utf-8")


def lark_parser(text: str) -> Lark:
    """Return Lark's parser for the grammar."""
    from lark import Lark

    return Lark(text, parser="lalr", lexer="basic", start=list(STARTS))


# ---------------------------------------------------------------- the cache


def _cache_file(text: str) -> Path:
    root = os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()
    this = Path(__file__).read_text(encoding="utf-8")
    made_for = hashlib.sha256("\0".join((text, this, sys.version)).encode()).hexdigest()
    return Path(root, "wmspec", f"grammar-{made_for[:16]}.tables")


def _store(made: Tables, path: Path) -> None:
    """Write the tables atomically: another process may read them at any time."""
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


def _build_tables(lark: Lark) -> Tables:
    pattern, keywords = _words(lark)
    ways = {start: lark.parse_interactive("", start=start).parser_state.parse_conf for start in STARTS}
    table: dict[int, dict[str, Any]] = ways[STARTS[0]].parse_table.states
    number = {state: i for i, state in enumerate(table)}
    rules = {rule: i for i, rule in enumerate(lark.rules)}

    def action(kind: Any, target: Any) -> int:
        return number[target] if kind.name == "Shift" else ~rules[target]

    return Tables(
        pattern=pattern,
        keywords=keywords,
        rules=tuple(map(_rule, lark.rules)),
        states=tuple({str(name): action(*pair) for name, pair in actions.items()} for actions in table.values()),
        first={start: number[way.start_state] for start, way in ways.items()},
        last={start: number[way.end_state] for start, way in ways.items()},
        starters=frozenset().union(*(_edge_terminals(lark, part, 0) for part in STATEMENTS)),
        value_ends=_edge_terminals(lark, "expr", -1),
    )


def _edge_terminals(lark: Lark, origin: str, edge: int) -> frozenset[str]:
    """Return the token types that a rule can begin with (`edge` 0) or end with (-1). No rule is empty."""
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
    """Return the token pattern, and the keywords that look like names."""
    name = next(t.pattern.to_regexp() for t in lark.terminals if t.name == "NAME")
    fixed = {t.pattern.value: t.name for t in lark.terminals if t.pattern.type == "str" and t.priority == 0}
    keywords = {word: kind for word, kind in fixed.items() if re.fullmatch(name, word)}
    others = [t for t in lark.terminals if t.name not in keywords.values()]
    # Lark's order: by priority, then by maximum length.
    others.sort(key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name))
    return "|".join(f"(?P<{t.name}>{t.pattern.to_regexp()})" for t in others), keywords


def _rule(rule: Any) -> Rule:
    """Return the rule with its children: tokens without a value are dropped, `[...]` leaves gaps."""
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
