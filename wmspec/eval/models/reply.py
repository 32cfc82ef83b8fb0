"""The parser of replies, shared by all models and exported tools. Standard library only.

Options have positions from 0 in the order shown. A reply is parsed by the first rule that finds exactly one option in
it (`docs/evaluate.md` has examples):

1. the reply is only an option's label, position or words;

2. it announces one: "the answer is (B)", "I choose the third option"; the last announcement counts;

3. it begins with one: "B. the red cube", "No, they do not";

4. it mentions one label only, in parentheses or as an isolated capital;

5. it contains the words of one option only.

A negated option ("not B") is not chosen. Where options have letters, "picture 2" is not an option. Reasoning inside
<think> is ignored. Nothing is guessed: if no rule applies, the reply has no option.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

#: Version of these rules, recorded with every result.
PARSER_VERSION = 1
#: Maximum number of characters of a reply that are parsed.
MAX_REPLY_LENGTH = 65_536

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")
_SHORT_ORDINALS = ("1st", "2nd", "3rd", "4th", "5th", "6th", "7th", "8th")
_NUMBER_WORDS = (
    "zero",
    "one",
    "two",
    "three",
    "four",
    "five",
    "six",
    "seven",
    "eight",
    "nine",
    "ten",
    "eleven",
    "twelve",
)

#: SI unit -> singular names of the units of its quantity, and their sizes in the SI unit.
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
    """A scored reply: the chosen position (as shown) or number, None if unparsed, and whether it is right."""

    place: int | None
    number: float | None
    right: bool

    @property
    def parsed(self) -> bool:
        """Whether the reply could be parsed."""
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
    """Parse and score a reply.

    `options` are the words of each option as shown, None for a picture; `answer` is the position of the true one as
    shown. Without options the question is open, and a number `within` of `number` (SI `unit`) is right.
    """
    if options:
        place = choice(text, options, labels)
        return Mark(place, None, place is not None and place == answer)
    value = number_in(text, unit or "")
    right = value is not None and number is not None and is_near(value, number, within or 0.0, unit or "")
    return Mark(None, value, right)


def is_near(value: float, truth: float, within: float, unit: str = "") -> bool:
    """Whether a number is right; for angles (rad) the shorter way round counts."""
    apart = abs(math.remainder(value - truth, math.tau)) if unit == "rad" else abs(value - truth)
    return apart <= within * (1 + 1e-9)


# ---------------------------------------------------------------- options


@dataclass(frozen=True)
class _ShownOptions:
    """The options as shown: their words (empty for pictures), and whether labels are letters or numbers."""

    words: tuple[str, ...]
    numbered: bool

    def label(self, text: str) -> int | None:
        """Return the position of a label. Letters and numbers are both accepted if unambiguous."""
        if len(text) == 1 and text.upper() in LETTERS:
            place = LETTERS.index(text.upper())
        elif text.isdecimal() and len(text) < 4 and (self.numbered or not any(re.search(r"\d", w) for w in self.words)):
            place = int(text) - 1
        else:
            return None
        return place if 0 <= place < len(self.words) else None

    def ordinal(self, text: str) -> int | None:
        """Return the position of an ordinal."""
        if text == "last":
            return len(self.words) - 1
        place = next((names.index(text) for names in (ORDINALS, _SHORT_ORDINALS) if text in names), len(self.words))
        return place if place < len(self.words) else None


def choice(text: str, options: Sequence[str | None], labels: str = "letters") -> int | None:
    """Return the position of the chosen option, None if no rule applies.

    `labels` are those shown with the options: "letters" or "numbers".
    """
    reply = normalize(text)
    shown = _ShownOptions(tuple(_plain(words or "") for words in options), labels == "numbers")
    if not shown.numbered and not any(_SHOWN_PICTURE.search(words) for words in shown.words):
        reply = _SHOWN_PICTURE.sub(" ", reply)
    for rule in _RULES:
        places = rule(reply, shown)
        if len(places) == 1:
            return places.pop()
    return None


def normalize(text: str) -> str:
    """Return a reply without reasoning and markup, with normalized characters."""
    reply = unicodedata.normalize("NFKC", text[-MAX_REPLY_LENGTH:])
    reply = re.sub(r"(?is)^.*</think(?:ing)?>", "", reply)
    reply = re.sub(r"(?is)<think(?:ing)?>.*", "", reply)
    marked = re.findall(r"(?is)<answer>(.{0,500}?)</answer>", reply) or re.findall(r"\\boxed\{([^{}]{0,500})\}", reply)
    reply = marked[-1] if marked else reply
    reply = re.sub(r"\\(?:text|mathrm|mathbf)\{([^{}]*)\}", r"\1", reply)
    return re.sub(r"[*`$#“”\"]|\\[()\[\]]", "", reply).replace("’", "'").replace("−", "-").strip()


def _plain(words: str) -> str:
    """Return words in lower case, without article and surrounding marks."""
    return re.sub(r"^(?:the|an?)\s+", "", re.sub(r"\s+", " ", words.casefold()).strip(" .,:;!?()'[]{}"))


_NOUN = r"(?:option|choice|answer|candidate|picture|image|number|one)"
_ORDINAL = rf"(?P<ordinal>{'|'.join((*ORDINALS, *_SHORT_ORDINALS, 'last'))})"
# If options have letters, a numbered picture is a context picture.
_SHOWN_PICTURE = re.compile(rf"(?i)\b(?:the\s+)?(?:(?:picture|image)s?\s*#?\s*\d+|{_ORDINAL}\s+(?:picture|image))\b")
# A label that does not begin a word or number. A lone "a" (and "A", "I") before a word is not a label.
_LABEL = (
    r"(?:[(\[]\s*(?P<inside>[A-Za-z]|\d{1,3})\s*[)\]]"
    r"|(?P<bare>[B-HJ-Zb-hj-z]|[AaIi](?!\s+(?!(?:is|because|since|as|or|and|nor|but)\b)[a-z])|\d{1,3})(?![\w'%°]|\.\d|[-/]\w))"
)


def _only_option(reply: str, shown: _ShownOptions) -> set[int]:
    """The reply is only an option."""
    return _find_label(reply, shown) if len(reply) < 500 else set()


def _find_label(reply: str, shown: _ShownOptions) -> set[int]:
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


def _leading_option(reply: str, shown: _ShownOptions) -> set[int]:
    """The reply begins with an option: its label, a mark and a space, or its words and a mark."""
    match = re.match(r"(?:[(\[](\w{1,3})[)\]]|(\w{1,3})(?:[).:,;](?=\s|$)|\s*\n|\s*[-–—=]+>?\s))", reply)
    label = (match[1] or match[2]) if match else ""
    listed = label.isdecimal() and re.search(r"\n\s*2[.)]", reply)  # "1. ..., 2. ..." are steps, not options
    if label and not listed and (shown.numbered or not label.isdecimal()) and (place := shown.label(label)) is not None:
        return {place}
    return set() if listed else _find_label(re.split(r"[.,:;!?\n]|\s[-–—]", reply, maxsplit=1)[0], shown)


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


def _last_announcement(reply: str, shown: _ShownOptions) -> set[int]:
    """The last announcement of an answer."""
    last: tuple[int, int] | None = None
    for match in (*_ANNOUNCED.finditer(reply), *_CONFIRMED.finditer(reply)):
        place = _place(match, shown)
        if place is not None and (last is None or match.start() >= last[0]):
            last = (match.start(), place)
    return set() if last is None else {last[1]}


def _place(match: re.Match[str], shown: _ShownOptions) -> int | None:
    groups = match.groupdict()
    if label := groups["inside"] or groups["bare"]:
        return shown.label(label)
    if ordinal := groups.get("ordinal"):
        return shown.ordinal(ordinal.casefold())
    places = _quoted_options(groups.get("words") or "", shown)
    return places.pop() if len(places) == 1 else None


def _mentioned_labels(reply: str, shown: _ShownOptions) -> set[int]:
    """Labels in parentheses, or isolated capitals (in a numbered list: numbers) that are not negated."""
    kept = _DENIED.sub(" ", reply)
    labels = [match["inside"] or match["bare"] or match["after"] for match in _MENTIONED.finditer(kept)]
    usable = [s for s in labels if s.isdecimal() == shown.numbered and (s.isupper() or s.isdecimal())]
    return {place for s in usable if (place := shown.label(s)) is not None}


def _quoted_options(reply: str, shown: _ShownOptions) -> set[int]:
    """Options whose words occur and are not negated; words inside longer ones of another option do not count."""
    text = re.sub(r"\s+", " ", reply.casefold())
    places, taken = set(), text
    for place, words in sorted(enumerate(shown.words), key=lambda each: -len(each[1])):
        if not words:
            continue
        # "no" and "yes" also occur in other sentences, so a mark or the end must follow.
        end = r"(?=\s*(?:[.,:;!?)\n]|$))" if words in {"yes", "no", "true", "false"} else r"(?!\w|\.\d)"
        pattern = rf"(?<![\w.])(?<!not )(?<!not the ){re.escape(words)}{end}"
        if re.search(pattern, taken):
            places.add(place)
        taken = re.sub(pattern, " ", taken)
    return places


_RULES: tuple[Callable[[str, _ShownOptions], set[int]], ...] = (
    _only_option,
    _last_announcement,
    _leading_option,
    _mentioned_labels,
    _quoted_options,
)


# ---------------------------------------------------------------- numbers

_UNIT = r"\s*(?P<unit>[a-zA-Z°%]+(?:/[a-z]+)?)?(?!\w)"
_NUMBER = re.compile(
    rf"(?i)(?<![\w.])(?P<value>[-+]?(?:\d{{1,3}}(?:,\d{{3}})+|\d+)(?:\.\d+)?(?:e[-+]?\d{{1,3}})?|[-+]?\.\d+){_UNIT}"
)
_IN_WORDS = re.compile(rf"(?i)\b(?P<value>{'|'.join(_NUMBER_WORDS)})\b{_UNIT}")


def number_in(text: str, unit: str = "") -> float | None:
    """Return the number in a reply, in the SI `unit`; None if there is none, several, or another quantity.

    A number after the last "answer" counts; otherwise the only number of the reply.
    """
    reply = normalize(text)
    after = re.split(r"(?i)\banswer\b", reply)[-1]
    answers = list(_values(after, unit)) if after != reply else []
    values = answers[:1] or list(_values(reply, unit))
    return values[0] if len({f"{value:.9g}" for value in values}) == 1 else None


def _values(text: str, unit: str) -> Iterator[float]:
    """Yield the numbers of a text that may have this unit; those in words only if there are none in digits."""
    matches = list(_NUMBER.finditer(text)) or list(_IN_WORDS.finditer(text))
    for match in matches:
        digits = match["value"].casefold().replace(",", "")
        value = float(_NUMBER_WORDS.index(digits)) if digits in _NUMBER_WORDS else float(digits)
        if not math.isfinite(value):
            continue
        name = match["unit"] or ""
        known = _UNITS.get(name) or _UNITS.get(name.casefold().removesuffix("s"))
        if known is None:
            yield value  # "3 balls": not a unit
        elif known[0] == unit:
            yield value * known[1]
