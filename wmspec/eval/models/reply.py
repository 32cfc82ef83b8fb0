"""What a reply chooses: the one parser of replies, for every model and every tool. Standard library only.

Options have places from 0 in the order in which they are shown. A reply is read by the first rule that finds exactly
one option in it (`docs/evaluate.md` has examples):

1. the reply is nothing but an option's label, its place or its words;
2. it announces one: "the answer is (B)", "I choose the third option"; the last announcement counts;
3. it begins with one: "B. the red cube", "No, they do not";
4. it mentions one label only, in parentheses or as a capital that stands alone;
5. it has the words of one option only.

What is denied ("not B") is not chosen. Where options have letters, "picture 2" is none of them. What is thought aloud
in <think> is not the reply. Nothing is guessed: a reply that no rule reads has no option.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

#: Told with every result: replies read by another version of these rules may be read otherwise.
VERSION = 1
#: What is looked at of a reply, in characters.
LONGEST = 65_536

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")
_SHORT = ("1st", "2nd", "3rd", "4th", "5th", "6th", "7th", "8th")
_COUNTED = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")

#: SI unit -> the units of the same quantity, without the s of the plural, and their sizes in it.
_SIZES: dict[str, dict[str, float]] = {
    "m": {"m": 1, "metre": 1, "meter": 1, "km": 1e3, "dm": 0.1, "cm": 0.01, "centimetre": 0.01, "centimeter": 0.01}
    | {
        "mm": 1e-3,
        "millimetre": 1e-3,
        "millimeter": 1e-3,
        "inch": 0.0254,
        "inche": 0.0254,
        "foot": 0.3048,
        "feet": 0.3048,
    },
    "s": {"s": 1, "sec": 1, "second": 1, "ms": 1e-3, "millisecond": 1e-3, "min": 60, "minute": 60},
    "rad": {"rad": 1, "radian": 1, "°": math.pi / 180, "deg": math.pi / 180, "degree": math.pi / 180},
    "m/s": {"m/s": 1, "cm/s": 0.01, "mm/s": 1e-3, "km/h": 1 / 3.6},
    "rad/s": {"rad/s": 1, "°/s": math.pi / 180, "deg/s": math.pi / 180},
    "kg": {"kg": 1, "kilogram": 1, "g": 1e-3, "gram": 1e-3},
    "": {"%": 0.01, "percent": 0.01},
}
_UNITS = {name: (unit, size) for unit, sizes in _SIZES.items() for name, size in sizes.items()}


@dataclass(frozen=True)
class Mark:
    """What a reply came to: the place that it chooses (as shown) or its number, None if unread; and if it is right."""

    place: int | None
    number: float | None
    right: bool

    @property
    def parsed(self) -> bool:
        """Whether the reply could be read."""
        return self.place is not None or self.number is not None


def mark(
    text: str,
    options: Sequence[str | None],
    labels: str = "letters",
    answer: int | None = None,
    number: float | None = None,
    unit: str | None = None,
    within: float | None = None,
) -> Mark:
    """Read a reply and hold it against the truth.

    `options` are the words of each as shown, None for a picture; `answer` the place of the true one as shown. Without
    options the question is open, and right is what is `within` of `number` (SI `unit`).
    """
    if options:
        place = choice(text, options, labels)
        return Mark(place, None, place is not None and place == answer)
    value = number_in(text, unit or "")
    right = value is not None and number is not None and near(value, number, within or 0.0, unit or "")
    return Mark(None, value, right)


def near(value: float, truth: float, within: float, unit: str = "") -> bool:
    """Whether a number is right; of angles (rad) the shorter way round counts."""
    apart = abs(math.remainder(value - truth, math.tau)) if unit == "rad" else abs(value - truth)
    return apart <= within * (1 + 1e-9)


# ---------------------------------------------------------------- options


@dataclass(frozen=True)
class _Shown:
    """The options as they were shown: their words, none for pictures; and whether they had letters or numbers."""

    words: tuple[str, ...]
    numbered: bool

    def label(self, text: str) -> int | None:
        """The place that a label or number names. A letter and a number are both understood, if they mean one thing."""
        if len(text) == 1 and text.upper() in LETTERS:
            place = LETTERS.index(text.upper())
        elif text.isdecimal() and len(text) < 4 and (self.numbered or not any(re.search(r"\d", w) for w in self.words)):
            place = int(text) - 1
        else:
            return None
        return place if 0 <= place < len(self.words) else None

    def ordinal(self, text: str) -> int | None:
        """The place that an ordinal names."""
        if text == "last":
            return len(self.words) - 1
        place = next((names.index(text) for names in (ORDINALS, _SHORT) if text in names), len(self.words))
        return place if place < len(self.words) else None


def choice(text: str, options: Sequence[str | None], labels: str = "letters") -> int | None:
    """The place of the option that a reply chooses, None if no rule of this file reads it.

    `labels` says what the options were shown with: "letters" or "numbers".
    """
    reply = cleaned(text)
    shown = _Shown(tuple(_plain(words or "") for words in options), labels == "numbers")
    if not shown.numbered and not any(_SHOWN_PICTURE.search(words) for words in shown.words):
        reply = _SHOWN_PICTURE.sub(" ", reply)
    for rule in _RULES:
        places = rule(reply, shown)
        if len(places) == 1:
            return places.pop()
    return None


def cleaned(text: str) -> str:
    """A reply without what was thought aloud, without markup, in ordinary characters."""
    reply = unicodedata.normalize("NFKC", text[-LONGEST:])
    reply = re.sub(r"(?is)^.*</think(?:ing)?>", "", reply)
    reply = re.sub(r"(?is)<think(?:ing)?>.*", "", reply)
    marked = re.findall(r"(?is)<answer>(.{0,500}?)</answer>", reply) or re.findall(r"\\boxed\{([^{}]{0,500})\}", reply)
    reply = marked[-1] if marked else reply
    reply = re.sub(r"\\(?:text|mathrm|mathbf)\{([^{}]*)\}", r"\1", reply)
    return re.sub(r"[*`$#“”\"]|\\[()\[\]]", "", reply).replace("’", "'").replace("−", "-").strip()


def _plain(words: str) -> str:
    """Words without case, article, and marks around them."""
    return re.sub(r"^(?:the|an?)\s+", "", re.sub(r"\s+", " ", words.casefold()).strip(" .,:;!?()'[]{}"))


_NOUN = r"(?:option|choice|answer|candidate|picture|image|number|one)"
_ORDINAL = rf"(?P<ordinal>{'|'.join((*ORDINALS, *_SHORT, 'last'))})"
# Where options have letters, a numbered picture is one of those shown with the question.
_SHOWN_PICTURE = re.compile(rf"(?i)\b(?:the\s+)?(?:(?:picture|image)s?\s*#?\s*\d+|{_ORDINAL}\s+(?:picture|image))\b")
# A label that is not the beginning of a word or number. A lone "a" (and "A", "I") before a word is none.
_LABEL = (
    r"(?:[(\[]\s*(?P<inside>[A-Za-z]|\d{1,3})\s*[)\]]"
    r"|(?P<bare>[B-HJ-Zb-hj-z]|[AaIi](?!\s+(?!(?:is|because|since|as|or|and|nor|but)\b)[a-z])|\d{1,3})(?![\w'%°]|\.\d|[-/]\w))"
)


def _alone(reply: str, shown: _Shown) -> set[int]:
    """The reply is nothing but an option."""
    return _named(reply, shown) if len(reply) < 500 else set()


def _named(reply: str, shown: _Shown) -> set[int]:
    plain = _plain(reply)
    if shown.numbered and (place := shown.label(plain)) is not None:
        return {place}
    same = {place for place, words in enumerate(shown.words) if words and words == plain}
    if same:
        return same
    bare = re.sub(rf"^{_NOUN}\s*[:#]?\s*", "", plain).strip(" .()[]")
    label = shown.label(bare)
    if label is None and (match := re.fullmatch(rf"{_ORDINAL}(?:\s+{_NOUN})?", plain)):
        label = shown.ordinal(match["ordinal"])
    return set() if label is None else {label}


def _leading(reply: str, shown: _Shown) -> set[int]:
    """The reply begins with an option: its label, a mark and a space, or its words and a mark."""
    match = re.match(r"(?:[(\[](\w{1,3})[)\]]|(\w{1,3})(?:[).:,;](?=\s|$)|\s*\n|\s*[-–—=]+>?\s))", reply)
    label = (match[1] or match[2]) if match else ""
    listed = label.isdecimal() and re.search(r"\n\s*2[.)]", reply)  # "1. ..., 2. ...": steps, not options
    if label and not listed and (shown.numbered or not label.isdecimal()) and (place := shown.label(label)) is not None:
        return {place}
    return set() if listed else _named(re.split(r"[.,:;!?\n]|\s[-–—]", reply, maxsplit=1)[0], shown)


_ANNOUNCED = re.compile(
    r"(?i:\b(?:answer|choose|chose|select|pick|go with|going with"
    r"|(?:choice|option|candidate|picture|image)(?=\s*(?:is|:)))\b"
    r"(?:\s*(?:is|was|be|would|should|must|to|:|=|-))*)"
    rf"\s*(?:(?i:the|{_NOUN})\s+)*(?:{_LABEL}|(?i:{_ORDINAL})\b|(?P<words>[^\n.;!?]{{1,200}}))"
)
_CONFIRMED = re.compile(rf"{_LABEL}\s+(?i:is|seems|looks)\s+(?i:the\s+)?(?i:right|correct|true|best|most likely)\b")
_DENIED = re.compile(
    r"(?i:\b(?:not|isn't|cannot be|can't be|rather than|instead of|unlike|except|exclude|excluding|rule out)\s+)"
    rf"(?:(?i:the|{_NOUN})\s+)*{_LABEL}"
)
_MENTIONED = re.compile(rf"(?<![\w.'-])(?:(?i:{_NOUN})\s+(?P<after>[A-Z])\b|{_LABEL})")


def _announced(reply: str, shown: _Shown) -> set[int]:
    """The last announcement of an answer."""
    last: tuple[int, int] | None = None
    for match in (*_ANNOUNCED.finditer(reply), *_CONFIRMED.finditer(reply)):
        place = _place(match, shown)
        if place is not None and (last is None or match.start() >= last[0]):
            last = (match.start(), place)
    return set() if last is None else {last[1]}


def _place(match: re.Match[str], shown: _Shown) -> int | None:
    groups = match.groupdict()
    if label := groups["inside"] or groups["bare"]:
        return shown.label(label)
    if ordinal := groups.get("ordinal"):
        return shown.ordinal(ordinal.casefold())
    places = _worded(groups.get("words") or "", shown)
    return places.pop() if len(places) == 1 else None


def _mentioned(reply: str, shown: _Shown) -> set[int]:
    """Labels in parentheses, or capitals (in a numbered list: numbers) that stand alone and are not denied."""
    kept = _DENIED.sub(" ", reply)
    labels = [match["inside"] or match["bare"] or match["after"] for match in _MENTIONED.finditer(kept)]
    wanted = [s for s in labels if s.isdecimal() == shown.numbered and (s.isupper() or s.isdecimal())]
    return {place for s in wanted if (place := shown.label(s)) is not None}


def _worded(reply: str, shown: _Shown) -> set[int]:
    """Options whose words occur and are not denied; words within longer ones of another option do not count."""
    text = re.sub(r"\s+", " ", reply.casefold())
    places, taken = set(), text
    for place, words in sorted(enumerate(shown.words), key=lambda each: -len(each[1])):
        if not words:
            continue
        # "no" and "yes" are words of other sentences too: a mark or the end must follow.
        end = r"(?=\s*(?:[.,:;!?)\n]|$))" if words in {"yes", "no", "true", "false"} else r"(?!\w|\.\d)"
        pattern = rf"(?<![\w.])(?<!not )(?<!not the ){re.escape(words)}{end}"
        if re.search(pattern, taken):
            places.add(place)
        taken = re.sub(pattern, " ", taken)
    return places


_RULES: tuple[Callable[[str, _Shown], set[int]], ...] = (_alone, _announced, _leading, _mentioned, _worded)


# ---------------------------------------------------------------- numbers

_UNIT = r"\s*(?P<unit>[a-zA-Z°%]+(?:/[a-z]+)?)?(?!\w)"
_NUMBER = re.compile(
    rf"(?i)(?<![\w.])(?P<value>[-+]?(?:\d{{1,3}}(?:,\d{{3}})+|\d+)(?:\.\d+)?(?:e[-+]?\d{{1,3}})?|[-+]?\.\d+){_UNIT}"
)
_IN_WORDS = re.compile(rf"(?i)\b(?P<value>{'|'.join(_COUNTED)})\b{_UNIT}")


def number_in(text: str, unit: str = "") -> float | None:
    """The number that a reply gives, in the SI `unit` asked for; None if it gives none, several, or another quantity.

    What follows the last "answer" counts, if there is a number; else the only number of the reply.
    """
    reply = cleaned(text)
    after = re.split(r"(?i)\banswer\b", reply)[-1]
    told = list(_values(after, unit)) if after != reply else []
    values = told[:1] or list(_values(reply, unit))
    return values[0] if len({f"{value:.9g}" for value in values}) == 1 else None


def _values(text: str, unit: str) -> Iterator[float]:
    """The numbers of a text that may be of this unit; those in words only if there are none in digits."""
    matches = list(_NUMBER.finditer(text)) or list(_IN_WORDS.finditer(text))
    for match in matches:
        digits = match["value"].casefold().replace(",", "")
        value = float(_COUNTED.index(digits)) if digits in _COUNTED else float(digits)
        if not math.isfinite(value):
            continue
        name = match["unit"] or ""
        known = _UNITS.get(name) or _UNITS.get(name.casefold().removesuffix("s"))
        if known is None:
            yield value  # "3 balls": no unit at all
        elif known[0] == unit:
            yield value * known[1]
