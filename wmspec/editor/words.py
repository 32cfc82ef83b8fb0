"""The words of the language by what they are, for those who colour it: read off the grammar and the tables."""

from __future__ import annotations

import re
from functools import cache

from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS
from wmspec.lang.check.tables.vocabulary import JOINTS, WORDS
from wmspec.lang.parse.tables import grammar, tables

#: Keywords that join expressions; all others begin or part statements.
_JOINING = ("and", "or", "not", "if", "then", "else", "true", "false", "in", "by", "of", "as", "at", "for", "after",
            "with", "apart", "unless", "only")  # fmt: skip
#: The settings, which the grammar has as one word.
_SETTING = re.search(r"^SETTING\S*: /\((\S+)\)", grammar(), re.MULTILINE)


def keywords() -> tuple[str, ...]:
    """All keywords, the settings of a task too, in the order of the alphabet."""
    settings = _SETTING[1].split("|") if _SETTING else []
    return tuple(sorted({*tables().keywords, *settings}))


def statements() -> tuple[str, ...]:
    """The keywords that begin a statement or clause, or part one."""
    return tuple(word for word in keywords() if word not in _JOINING)


def joining() -> tuple[str, ...]:
    """The keywords within statements."""
    return tuple(word for word in keywords() if word in _JOINING)


@cache
def constants() -> frozenset[str]:
    """The words for values."""
    return frozenset({*(word for words in WORDS.values() for word in words), *JOINTS, "end", "index"})


def functions() -> tuple[str, ...]:
    """Verbs and functions."""
    robots = {verb for verbs in ROBOTS.values() for verb in verbs}
    return tuple(sorted({*FUNCTIONS, *VERBS, *robots}))


#: Keywords that may also be names.
SOFT = frozenset(re.findall(r'"(\w+)"', grammar().partition("!name:")[2].partition("\n\n")[0]))
