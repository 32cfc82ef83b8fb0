"""The words of the language by category, for syntax highlighting: from the grammar and the tables."""

from __future__ import annotations

import re
from functools import cache

from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.tables.verbs import ROBOTS, VERBS
from wmspec.lang.check.tables.vocabulary import JOINTS, WORDS
from wmspec.lang.parse.tables import grammar, tables

#: Keywords within expressions; all others begin or divide statements.
_JOINING = ("and", "or", "not", "if", "then", "else", "true", "false", "in", "by", "of", "as", "at", "for", "after",
            "with", "when", "under", "among", "apart", "unless", "only", "about")  # fmt: skip
#: The settings, a single terminal of the grammar.
_SETTING = re.search(r"^SETTING\S*: /\((\S+)\)", grammar(), re.MULTILINE)


def keywords() -> tuple[str, ...]:
    """Return all keywords and the settings of a task, sorted."""
    settings = _SETTING[1].split("|") if _SETTING else []
    return tuple(sorted({*tables().keywords, *settings}))


def statements() -> tuple[str, ...]:
    """Return the keywords that begin or divide a statement."""
    return tuple(word for word in keywords() if word not in _JOINING)


def joining() -> tuple[str, ...]:
    """Return the keywords within statements."""
    return tuple(word for word in keywords() if word in _JOINING)


@cache
def constants() -> frozenset[str]:
    """Return the words for values."""
    return frozenset({*(word for words in WORDS.values() for word in words), *JOINTS, "end", "index"})


def functions() -> tuple[str, ...]:
    """Return the names of verbs and functions."""
    robots = {verb for verbs in ROBOTS.values() for verb in verbs}
    return tuple(sorted({*FUNCTIONS, *VERBS, *robots}))


#: Keywords that may also be names.
SOFT = frozenset(re.findall(r'"(\w+)"', grammar().partition("!name:")[2].partition("\n\n")[0]))
