"""What may have been meant at a word that cannot stand where it does: guesses of many sorts, with their costs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from wmspec.core.spelling import slips
from wmspec.lang.parse.lexer import Token, read
from wmspec.lang.parse.machine import END
from wmspec.lang.parse.tables import tables

#: Signs that may be missing or too many.
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
#: Signs of which one may be written for another.
_ALIKE = (
    {"LBRACE", "LPAR", "LSQB"},
    {"RBRACE", "RPAR", "RSQB"},
    {"COLON", "EQUAL", "COMMA", "DOT", "RANGE", "COMPARE", "MINUS"},
    {"STRAY", "COMMA"},
)
#: The keywords of statements that are written most often, those of a task, then those of a question.
_OFTEN = (
    *("use", "factor", "let", "object", "objects", "action", "observe", "question", "task", "require", "horizon"),
    *("answer", "options", "counterfactual", "ensure"),
)
#: Words that may be missing between two others.
_BETWEEN = {
    "ELSE": "else",
    "IN": "in",
    "AT": "at",
    "FOR": "for",
    "BY": "by",
    "THEN": "then",
    "APART": "apart by",
}
_NUMBER = re.compile(r"\d+(\.\d+)?")
#: Units that follow a number.
UNITS = ("mm", "cm", "m", "s", "ms", "deg", "kg", "g", "N", "rad")


@dataclass(frozen=True)
class Repair:
    """Other words in place of those from `start` to `stop`, and what is told of it.

    `cost`: the lower, the likelier. What is `missing` is told after the word before. A name that is `hyphenated` is so
    wherever it is used. A block that is opened `closes` before another word.
    """

    start: int
    stop: int
    words: tuple[Token, ...]
    message: str
    help: str
    cost: float
    missing: bool = False
    hyphenated: bool = False
    closes: int | None = None


class Place(NamedTuple):
    """A word among others, and the types of words that could stand in its place or before it."""

    words: Sequence[Token]
    i: int
    accepted: set[str]

    @property
    def word(self) -> Token:
        """The word itself."""
        return self.words[self.i]

    @property
    def before(self) -> Token:
        """The word before it; before the first an empty one."""
        return self.words[self.i - 1] if self.i else Token("", "", 0, 0)

    @property
    def after(self) -> Token:
        """The word after it; after the last an empty one."""
        return self.words[self.i + 1] if self.i + 1 < len(self.words) else Token("", "", 0, 0)

    def instead(self, *words: Token, told: str, help: str, cost: float, of: int = 1) -> Repair:
        """Words instead of this one, or instead of so many."""
        return Repair(self.i, self.i + of, words, told, help, cost)

    def missing(self, *kinds: str, told: str, help: str, cost: float) -> Repair:
        """Words of these types that are missing before this one."""
        text = {"STRING": '""', **{kind: word for word, kind in _keywords().items()}}
        words = tuple(Token(kind, text.get(kind, ""), self.word.start, self.word.line) for kind in kinds)
        return Repair(self.i, self.i, words, told, help, cost, missing=True)


def guesses(place: Place, stuck: int) -> Iterator[Repair]:
    """All that may have been meant, where reading is stuck at this word or soon after it."""
    for guess in (_keyword, _unit, _name, _hyphens, _text, _sign, _inches, _number, _no_sign, _no_word, _no_statement):
        yield from guess(place)
    if place.i == stuck or place.word.type in SIGNS:
        yield from _too_many(place)


def hyphenated(words: Sequence[Token], i: int) -> int:
    """Where a name with hyphens that begins here ends: words and hyphens that touch."""
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


# ---------------------------------------------------------------- another word


def _keyword(place: Place) -> Iterator[Repair]:
    """A misspelled keyword. Of two letters, it is rather something else; one that stands for a name is well spelled."""
    text = place.word.text
    if text.isidentifier() and not ("NAME" in place.accepted and text in tables().keywords):
        for keyword, kind, apart in _near(text):
            if kind in place.accepted and kind != place.word.type:
                cost = (0.8 if len(text) > 2 or apart == 0 else 2.0) + 0.5 * apart
                made = place.word._replace(type=kind, text=keyword)
                told = f"`{text}` is unexpected here"
                yield place.instead(made, told=told, help=f"did you mean `{keyword}`?", cost=cost)


def _unit(place: Place) -> Iterator[Repair]:
    """`3 yb 5`: what was taken for a unit is a misspelled keyword."""
    word = place.word
    number = word.text.split()[0] if word.type == "QUANTITY" else ""
    unit = word.text[len(number) :]
    if not number or not unit[:1].isspace() or not unit.strip().isidentifier():
        return
    first = Token("NUMBER", number, word.start, word.line)
    (second,) = (t for t in read(unit, word.start + len(number)) if t.type != "WHITE")
    for keyword, kind, apart in _near(second.text):
        made = second._replace(type=kind, text=keyword)
        told, help = f"`{second.text}` is no unit", f"did you mean `{keyword}`?"
        yield place.instead(first, made, told=told, help=help, cost=0.9 + 0.5 * apart)


def _name(place: Place) -> Iterator[Repair]:
    """A keyword where a name is wanted."""
    text = place.word.text
    if text.isidentifier() and "NAME" in place.accepted and place.word.type != "NAME":
        told = f"`{text}` is a word of the language and no name"
        made = place.word._replace(type="NAME")
        yield place.instead(made, told=told, help=f"say for instance `{text}_1`", cost=3.6)


def _hyphens(place: Place) -> Iterator[Repair]:
    """`red-ball`."""
    end = hyphenated(place.words, place.i)
    if end > place.i + 1 and "NAME" in place.accepted:
        name = "".join(t.text for t in place.words[place.i : end]).replace("-", "_")
        made = (place.word._replace(type="NAME", text=name),)
        yield Repair(place.i, end, made, "a name has no hyphens", f"write `{name}`", 1.0, hyphenated=True)


def _text(place: Place) -> Iterator[Repair]:
    """`question \"\"\"...\"\"\"`: what only describes a task."""
    if place.word.type == "LONG_STRING" and "STRING" in place.accepted:
        made = place.word._replace(type="STRING")
        told, help = "a text in three quotes describes a task", 'write `"..."`, a long text as several: `"..." "..."`'
        yield place.instead(made, told=told, help=help, cost=0.5)


def _sign(place: Place) -> Iterator[Repair]:
    """One sign for another. A closing bracket that touches the word before it is rather that than one too many.

    After the first word in brackets, or after a comma, `=` is rather that of a named argument elsewhere.
    """
    word, touches = place.word, place.before.end == place.word.start and place.i > 0
    means = "means nothing here" if word.type == "STRAY" else "is unexpected here"
    argues = word.type == "EQUAL" and place.i > 1 and place.words[place.i - 2].type in ("LPAR", "COMMA")
    for kind, sign in SIGNS.items():
        if kind in place.accepted and kind != word.type and any({kind, word.type} <= alike for alike in _ALIKE):
            cost = 2.4 if word.text in ")]}" and touches and sign != "}" else 2.9
            cost = 1.9 if argues and sign == ":" else cost
            made = word._replace(type=kind, text=sign)
            yield place.instead(made, told=f"`{word.text}` {means}", help=f"write `{sign}`", cost=cost)
    if word.type == "EQUAL" and "COMPARE" in place.accepted:
        made = word._replace(type="COMPARE", text="==")
        yield place.instead(made, told="`=` does not compare", help="write `==`", cost=2.0)


def _inches(place: Place) -> Iterator[Repair]:
    """`6 in`: a keyword, not a unit."""
    if place.word.type == "NUMBER" and place.after.type == "IN":
        metric = f"{float(place.word.text) * 2.54:.6g} cm"
        made = place.word._replace(type="QUANTITY", text=metric)
        yield place.instead(made, told="there are no inches here", help=f"write `{metric}`", cost=2.9, of=2)


def _number(place: Place) -> Iterator[Repair]:
    """`1O cm`: a letter among the digits; `1.5.5`: two points."""
    text = place.word.text
    if place.word.type == "DOT" and place.before.type == "NUMBER" and place.after.type in ("NUMBER", "QUANTITY"):
        told, help = f"`{place.before.text}.{place.after.text}` is no number", "write one decimal point"
        yield Repair(place.i - 1, place.i + 2, (place.after,), told, help, 1.0)
    number = _NUMBER.match(text) if place.word.type == "QUANTITY" else None
    if number and text[number.end()].isalpha() and place.after.text in UNITS:
        made = place.word._replace(text=f"{number[0]} {place.after.text}")
        told = f"`{text}` is no number"
        yield place.instead(made, told=told, help="write digits, and then the unit", cost=1.0, of=2)


# ---------------------------------------------------------------- what is missing


def _no_sign(place: Place) -> Iterator[Repair]:
    """A sign that is missing."""
    for kind, sign in SIGNS.items():
        if kind in place.accepted and kind not in ("RANGE", "DOT"):
            cost = 2.5 if kind in ("COMMA", "COLON", "EQUAL", "LBRACE") else 2.8
            if kind in ("LPAR", "LSQB") and place.before.type in ("MINUS", "PLUS", "TIMES"):
                cost += 1.0  # rather before all that is added up
            if kind == "COLON" and "COMMA" in place.accepted:
                cost += -0.1 if _of_argument(place) else 0.1
            yield place.missing(kind, told=f"`{sign}` is missing here", help=f"write `{sign}`", cost=cost)


def _no_word(place: Place) -> Iterator[Repair]:
    """A keyword within a statement, a name, a value or a text that is missing."""
    for kind, keyword in _BETWEEN.items():
        if kind in place.accepted:
            kinds = ("APART", "BY") if kind == "APART" else (kind,)
            yield place.missing(*kinds, told=f"`{keyword}` is missing here", help=f"write `{keyword}`", cost=3.0)
    remedy = "write `if CONDITION then A else B`"
    if "ELSE" in place.accepted:
        yield place.missing("ELSE", "NAME", told="this `if` has no `else`", help=remedy, cost=3.1)
    if "THEN" in place.accepted and place.word.type != "ELSE":
        yield place.missing("THEN", "NAME", "ELSE", "NAME", told="this `if` has no `then`", help=remedy, cost=4.2)
    if "NAME" in place.accepted:
        what = "a value" if "NUMBER" in place.accepted else "a name"
        yield place.missing("NAME", told=f"{what} is missing here", help=f"write {what}", cost=4.0)
    elif "STRING" in place.accepted:
        remedy = 'write one in quotes: `"..."`'
        yield place.missing("STRING", told="a text is missing here", help=remedy, cost=4.0)


def _no_statement(place: Place) -> Iterator[Repair]:
    """The keyword with which a statement begins: rather that where a line begins, and rather a frequent one."""
    begins = place.before.end_line < place.word.line and place.word.type not in tables().starters
    cost = 2.7 if begins else 6.0
    starters = {w: kind for w, kind in _keywords().items() if kind in place.accepted & tables().starters}
    first = "action" if _acts(place) else "horizon" if place.word.type == "QUANTITY" else "let"
    ordered = [w for w in dict.fromkeys((first, *_OFTEN, *sorted(starters))) if w in starters]
    for rank, keyword in enumerate(ordered):
        made = Token(starters[keyword], keyword, place.word.start, place.word.line)
        help = f"write before `{shown(place.word)}` what it is, such as `{keyword}`"
        told = "a statement begins with its keyword"
        yield Repair(place.i, place.i, (made,), told, help, cost + 0.001 * rank)


def _acts(place: Place) -> bool:
    """Whether a name is made of a call: `push = launch(...)`, `reach = arm.push(...)`."""
    kinds = [t.type for t in place.words[place.i : place.i + 6]]
    return kinds[:4] == ["NAME", "EQUAL", "NAME", "LPAR"] or kinds == ["NAME", "EQUAL", "NAME", "DOT", "NAME", "LPAR"]


def _of_argument(place: Place) -> bool:
    """Whether what is missing between two words is rather the colon of an argument than a comma."""
    deep = 0
    for token in reversed(place.words[: place.i]):
        deep += (token.type in ("RPAR", "RSQB")) - (token.type in ("LPAR", "LSQB"))
        if deep < 0:
            break
        if deep == 0 and token.type == "COLON":
            return True
    return place.word.type in ("NUMBER", "QUANTITY")


# ---------------------------------------------------------------- what is too many


def _too_many(place: Place) -> Iterator[Repair]:
    """A sign or word too many; rather a sign that is there twice."""
    word = place.word
    if word.type == END:
        return
    cost = 3.0 if word.type in SIGNS or word.type == "STRAY" else 5.0
    if word.type in SIGNS and place.before.type == word.type:
        cost = 2.2
    why = "means nothing here" if word.type == "STRAY" else "is unexpected here"
    yield place.instead(told=f"`{shown(word)}` {why}", help="remove it", cost=cost)


def shown(word: Token) -> str:
    """A word on one short line."""
    text = " ".join(word.text.split())
    return text if len(text) <= 30 else f"{text[:27]}..."


def _near(text: str) -> Iterator[tuple[str, str, int]]:
    """Keywords close to a word, with their types and how many slips apart they are."""
    for keyword, kind in _keywords().items():
        apart = slips(text.lower(), keyword, 4)
        if apart <= max(1, (len(keyword) + 1) // 3) and (len(text) > 1 or apart == 0):
            yield keyword, kind, apart


def _keywords() -> dict[str, str]:
    """The words of the language, with their types."""
    return tables().keywords | dict.fromkeys(("title", "license", "source"), "SETTING")
