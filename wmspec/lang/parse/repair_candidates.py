"""Candidates for repairing a token that cannot follow, with their costs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import NamedTuple

from wmspec.core.spelling import edit_distance
from wmspec.lang.parse.lexer import Token, tokenize
from wmspec.lang.parse.lr_parser import END
from wmspec.lang.parse.tables import tables

#: Signs that may be missing or surplus.
SIGNS = {
    "LBRACE": "{",
    "RBRACE": "}",
    "LPAR": "(",
    "RPAR": ")",
    "LSQB": "[",
    "RSQB": "]",
    "COLON": ":",
    "COMMA": ",",
    "EQUAL": "=",
    "RANGE": "..",
    "DOT": ".",
}
#: Signs that are confused with each other.
_CONFUSED_SIGNS = (
    {"LBRACE", "LPAR", "LSQB"},
    {"RBRACE", "RPAR", "RSQB"},
    {"COLON", "EQUAL", "COMMA", "DOT", "RANGE", "COMPARE", "MINUS"},
    {"STRAY", "COMMA"},
)
#: Statement keywords by frequency: first those of a task, then those of a question.
_FREQUENT_KEYWORDS = (
    *("use", "factor", "let", "object", "objects", "action", "observe", "question", "task", "require", "horizon"),
    *("answer", "options", "counterfactual", "ensure"),
)
#: Keywords that may be missing between two tokens.
INNER_KEYWORDS = {kind: kind.lower() for kind in ("ELSE", "IN", "AT", "FOR", "BY", "THEN")} | {"APART": "apart by"}
_NUMBER = re.compile(r"\d+(\.\d+)?")
#: Units that follow a number.
COMMON_UNITS = ("mm", "cm", "m", "s", "ms", "deg", "kg", "g", "N", "rad")


@dataclass(frozen=True)
class Repair:
    """Replacement of the tokens from `start` to `stop`, with its message.

    `cost`: lower is likelier. A `missing` token is reported after the previous token. A `hyphenated` name is replaced
    wherever it is used. A block that the change opens `closes` before that token.
    """

    start: int
    stop: int
    words: tuple[Token, ...]
    message: str
    help: str
    cost: float = 0.0
    missing: bool = False
    hyphenated: bool = False
    closes: int | None = None


class RepairSite(NamedTuple):
    """A token in its context, and the token types that could replace or precede it."""

    words: Sequence[Token]
    i: int
    accepted: set[str]

    @property
    def word(self) -> Token:
        """The token itself."""
        return self.words[self.i]

    @property
    def before(self) -> Token:
        """The previous token; an empty one before the first."""
        return self.words[self.i - 1] if self.i else Token("", "", 0, 0)

    @property
    def after(self) -> Token:
        """The next token; an empty one after the last."""
        return self.words[self.i + 1] if self.i + 1 < len(self.words) else Token("", "", 0, 0)

    def instead(self, *words: Token, message: str, help: str, cost: float, of: int = 1) -> Repair:
        """Return the replacement of `of` tokens from this one on."""
        return Repair(self.i, self.i + of, words, message, help, cost)

    def missing(self, *kinds: str, message: str, help: str, cost: float) -> Repair:
        """Return the insertion of tokens of these types before this one."""
        text = {"STRING": '""', **{kind: word for word, kind in _keywords().items()}}
        words = tuple(Token(kind, text.get(kind, ""), self.word.start, self.word.line) for kind in kinds)
        return Repair(self.i, self.i, words, message, help, cost, missing=True)


def repair_candidates(place: RepairSite, stuck: int) -> Iterator[Repair]:
    """Yield all candidates at this token; the parser is stuck here or soon after."""
    for guess in (
        _keyword,
        _unit,
        _name,
        _hyphens,
        _text,
        _sign,
        _inches,
        _number,
        _missing_sign,
        _missing_word,
        _missing_statement_keyword,
    ):
        yield from guess(place)
    if place.i == stuck or place.word.type in SIGNS:
        yield from _surplus(place)


def end_of_hyphenated(words: Sequence[Token], i: int) -> int:
    """Return the end of a name with hyphens that begins at token `i`: adjacent words and hyphens."""
    if words[i].type != "NAME":
        return i
    end = i + 1
    while (
        end + 1 < len(words)
        and words[end].type == "MINUS"
        and words[end].start == words[end - 1].end
        and words[end + 1].text.isidentifier()
        and words[end + 1].start == words[end].end
    ):
        end += 2
    return end


# ---------------------------------------------------------------- replacements


def _keyword(place: RepairSite) -> Iterator[Repair]:
    """A misspelled keyword. Two-letter words are unlikely ones, and so are words in place of a name."""
    text = place.word.text
    if text.isidentifier() and not ("NAME" in place.accepted and text in tables().keywords):
        for keyword, kind, apart in _similar_keywords(text):
            if kind in place.accepted and kind != place.word.type:
                cost = (0.8 if len(text) > 2 or apart == 0 else 2.0) + 0.5 * apart
                made = place.word._replace(type=kind, text=keyword)
                message = f"`{text}` is unexpected here"
                yield place.instead(made, message=message, help=f"did you mean `{keyword}`?", cost=cost)


def _unit(place: RepairSite) -> Iterator[Repair]:
    """`3 yb 5`: a misspelled keyword in place of a unit."""
    word = place.word
    number = word.text.split()[0] if word.type == "QUANTITY" else ""
    unit = word.text[len(number) :]
    if not number or not unit[:1].isspace() or not unit.strip().isidentifier():
        return
    first = Token("NUMBER", number, word.start, word.line)
    (second,) = (t for t in tokenize(unit, word.start + len(number)) if t.type != "WHITE")
    for keyword, kind, apart in _similar_keywords(second.text):
        made = second._replace(type=kind, text=keyword)
        message, help = f"`{second.text}` is no unit", f"did you mean `{keyword}`?"
        yield place.instead(first, made, message=message, help=help, cost=0.9 + 0.5 * apart)


def _name(place: RepairSite) -> Iterator[Repair]:
    """A keyword in place of a name."""
    text = place.word.text
    if text.isidentifier() and "NAME" in place.accepted and place.word.type != "NAME":
        message = f"`{text}` is a word of the language and no name"
        made = place.word._replace(type="NAME")
        yield place.instead(made, message=message, help=f"say for instance `{text}_1`", cost=3.6)


def _hyphens(place: RepairSite) -> Iterator[Repair]:
    """`red-ball`."""
    end = end_of_hyphenated(place.words, place.i)
    if end > place.i + 1 and "NAME" in place.accepted:
        name = "".join(t.text for t in place.words[place.i : end]).replace("-", "_")
        made = (place.word._replace(type="NAME", text=name),)
        yield Repair(place.i, end, made, "a name has no hyphens", f"write `{name}`", 1.0, hyphenated=True)


def _text(place: RepairSite) -> Iterator[Repair]:
    """A docstring in place of the text of a question."""
    if place.word.type == "LONG_STRING" and "STRING" in place.accepted:
        made = place.word._replace(type="STRING")
        message, help = (
            "a text in three quotes describes a task",
            'write `"..."`, a long text as several: `"..." "..."`',
        )
        yield place.instead(made, message=message, help=help, cost=0.5)


def _sign(place: RepairSite) -> Iterator[Repair]:
    """One sign in place of another. A closing bracket that touches the previous token is rather confused than surplus.

    After the first token in brackets, or after a comma, `=` is rather the named argument of another language.
    """
    word, touches = place.word, place.before.end == place.word.start and place.i > 0
    means = "means nothing here" if word.type == "STRAY" else "is unexpected here"
    argues = word.type == "EQUAL" and place.i > 1 and place.words[place.i - 2].type in ("LPAR", "COMMA")
    for kind, sign in SIGNS.items():
        if (
            kind in place.accepted
            and kind != word.type
            and any({kind, word.type} <= signs for signs in _CONFUSED_SIGNS)
        ):
            cost = 2.4 if word.text in ")]}" and touches and sign != "}" else 2.9
            cost = 1.9 if argues and sign == ":" else cost
            made = word._replace(type=kind, text=sign)
            yield place.instead(made, message=f"`{word.text}` {means}", help=f"write `{sign}`", cost=cost)
    if word.type == "EQUAL" and "COMPARE" in place.accepted:
        made = word._replace(type="COMPARE", text="==")
        yield place.instead(made, message="`=` does not compare", help="write `==`", cost=2.0)


def _inches(place: RepairSite) -> Iterator[Repair]:
    """`6 in`: a keyword, not a unit."""
    if place.word.type == "NUMBER" and place.after.type == "IN":
        metric = f"{float(place.word.text) * 2.54:.6g} cm"
        made = place.word._replace(type="QUANTITY", text=metric)
        yield place.instead(made, message="there are no inches here", help=f"write `{metric}`", cost=2.9, of=2)


def _number(place: RepairSite) -> Iterator[Repair]:
    """`1O cm`: a letter among digits; `1.5.5`: two points."""
    text = place.word.text
    if place.word.type == "DOT" and place.before.type == "NUMBER" and place.after.type in ("NUMBER", "QUANTITY"):
        message, help = f"`{place.before.text}.{place.after.text}` is no number", "write one decimal point"
        yield Repair(place.i - 1, place.i + 2, (place.after,), message, help, 1.0)
    number = _NUMBER.match(text) if place.word.type == "QUANTITY" else None
    if number and text[number.end()].isalpha() and place.after.text in COMMON_UNITS:
        made = place.word._replace(text=f"{number[0]} {place.after.text}")
        message = f"`{text}` is no number"
        yield place.instead(made, message=message, help="write digits, and then the unit", cost=1.0, of=2)


# ---------------------------------------------------------------- insertions


def _missing_sign(place: RepairSite) -> Iterator[Repair]:
    """A missing sign."""
    for kind, sign in SIGNS.items():
        if kind in place.accepted and kind not in ("RANGE", "DOT"):
            cost = 2.5 if kind in ("COMMA", "COLON", "EQUAL", "LBRACE") else 2.8
            if kind in ("LPAR", "LSQB") and place.before.type in ("MINUS", "PLUS", "TIMES"):
                cost += 1.0  # likelier before the whole sum
            if kind == "COLON" and "COMMA" in place.accepted:
                cost += -0.1 if _is_argument_colon(place) else 0.1
            yield place.missing(kind, message=f"`{sign}` is missing here", help=f"write `{sign}`", cost=cost)


def _missing_word(place: RepairSite) -> Iterator[Repair]:
    """A missing keyword within a statement, or a missing name, value or text."""
    for kind, keyword in INNER_KEYWORDS.items():
        if kind in place.accepted:
            kinds = ("APART", "BY") if kind == "APART" else (kind,)
            yield place.missing(*kinds, message=f"`{keyword}` is missing here", help=f"write `{keyword}`", cost=3.0)
    remedy = "write `if CONDITION then A else B`"
    if "ELSE" in place.accepted:
        yield place.missing("ELSE", "NAME", message="this `if` has no `else`", help=remedy, cost=3.1)
    if "THEN" in place.accepted and place.word.type != "ELSE":
        yield place.missing("THEN", "NAME", "ELSE", "NAME", message="this `if` has no `then`", help=remedy, cost=4.2)
    if "NAME" in place.accepted:
        noun = "a value" if "NUMBER" in place.accepted else "a name"
        yield place.missing("NAME", message=f"{noun} is missing here", help=f"write {noun}", cost=4.0)
    elif "STRING" in place.accepted:
        remedy = 'write one in quotes: `"..."`'
        yield place.missing("STRING", message="a text is missing here", help=remedy, cost=4.0)


def _missing_statement_keyword(place: RepairSite) -> Iterator[Repair]:
    """A missing statement keyword; likelier at the start of a line, and likelier for frequent keywords."""
    begins = place.before.end_line < place.word.line and place.word.type not in tables().starters
    cost = 2.7 if begins else 6.0
    kinds = place.accepted & tables().starters
    starters = {w: kind for w, kind in _keywords().items() if kind in kinds} if kinds else {}
    first = "action" if _is_call_assignment(place) else "horizon" if place.word.type == "QUANTITY" else "let"
    ordered = [w for w in dict.fromkeys((first, *_FREQUENT_KEYWORDS, *sorted(starters))) if w in starters]
    for rank, keyword in enumerate(ordered):
        made = Token(starters[keyword], keyword, place.word.start, place.word.line)
        help = f"write before `{short_text(place.word)}` what it is, such as `{keyword}`"
        message = "a statement begins with its keyword"
        yield Repair(place.i, place.i, (made,), message, help, cost + 0.001 * rank)


def _is_call_assignment(place: RepairSite) -> bool:
    """Whether a name is assigned a call: `push = launch(...)`, `reach = arm.push(...)`."""
    kinds = [t.type for t in place.words[place.i : place.i + 6]]
    return kinds[:4] == ["NAME", "EQUAL", "NAME", "LPAR"] or kinds == ["NAME", "EQUAL", "NAME", "DOT", "NAME", "LPAR"]


def _is_argument_colon(place: RepairSite) -> bool:
    """Whether a missing sign between two tokens is rather the colon of an argument than a comma."""
    deep = 0
    for token in reversed(place.words[: place.i]):
        deep += (token.type in ("RPAR", "RSQB")) - (token.type in ("LPAR", "LSQB"))
        if deep < 0:
            break
        if deep == 0 and token.type == "COLON":
            return True
    return place.word.type in ("NUMBER", "QUANTITY")


# ---------------------------------------------------------------- deletions


def _surplus(place: RepairSite) -> Iterator[Repair]:
    """A surplus sign or word; likelier if it is doubled."""
    word = place.word
    if word.type == END:
        return
    cost = 3.0 if word.type in SIGNS or word.type == "STRAY" else 5.0
    if word.type in SIGNS and place.before.type == word.type:
        cost = 2.2
    why = "means nothing here" if word.type == "STRAY" else "is unexpected here"
    yield place.instead(message=f"`{short_text(word)}` {why}", help="remove it", cost=cost)


def short_text(word: Token) -> str:
    """Return a token's text on one short line."""
    text = " ".join(word.text.split())
    return text if len(text) <= 30 else f"{text[:27]}..."


@lru_cache(4096)
def _similar_keywords(text: str) -> tuple[tuple[str, str, int], ...]:
    """Return the keywords similar to a word, with their types and edit distance."""
    found = []
    for keyword, kind in _keywords().items():
        most = max(1, (len(keyword) + 1) // 3)
        if abs(len(keyword) - len(text)) <= most:
            apart = edit_distance(text.lower(), keyword, 4)
            if apart <= most and (len(text) > 1 or apart == 0):
                found.append((keyword, kind, apart))
    return tuple(found)


@cache
def _keywords() -> dict[str, str]:
    """Return the keywords with their token types."""
    return tables().keywords | dict.fromkeys(("title", "license", "source"), "SETTING")
