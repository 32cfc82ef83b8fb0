"""The number in a reply, in a unit."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from .normalize import normalize

_NUMBER_WORDS = (
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
)  # fmt: skip
#: SI unit -> names of the units of its quantity, and their sizes in the SI unit.
_SIZES: dict[str, dict[str, float]] = {
    "m": {"m": 1, "metre": 1, "meter": 1, "mètre": 1, "metro": 1, "米": 1, "メートル": 1, "km": 1e3, "dm": 0.1, "cm": 0.01}
    | {"centimetre": 0.01, "centimeter": 0.01, "zentimeter": 0.01, "centímetro": 0.01, "centimètre": 0.01, "厘米": 0.01}
    | {"センチ": 0.01, "mm": 1e-3, "millimetre": 1e-3, "millimeter": 1e-3, "毫米": 1e-3}
    | {"in": 0.0254, "inch": 0.0254, "inche": 0.0254, "ft": 0.3048, "foot": 0.3048, "feet": 0.3048},
    "s": {"s": 1, "sec": 1, "second": 1, "sekunde": 1, "sekunden": 1, "seconde": 1, "segundo": 1, "秒": 1}
    | {"ms": 1e-3, "millisecond": 1e-3, "毫秒": 1e-3, "min": 60, "minute": 60},
    "rad": {"rad": 1, "radian": 1, "°": math.pi / 180, "deg": math.pi / 180, "degree": math.pi / 180, "度": math.pi / 180}
    | {"grad": math.pi / 180, "grado": math.pi / 180, "degré": math.pi / 180},
    "m/s": {"m/s": 1, "cm/s": 0.01, "mm/s": 1e-3, "km/h": 1 / 3.6},
    "rad/s": {"rad/s": 1, "°/s": math.pi / 180, "deg/s": math.pi / 180},
    "kg": {"kg": 1, "kilogram": 1, "g": 1e-3, "gram": 1e-3},
    "": {"%": 0.01, "percent": 0.01},
}  # fmt: skip
_UNITS = {name: (unit, size) for unit, sizes in _SIZES.items() for name, size in sizes.items()}
#: Words after a number that are neither its unit nor what it counts.
_FUNCTION_WORDS = frozenset([
    "to", "and", "or", "from", "away", "for", "is", "as", "at", "on", "with", "because", "since", "apart", "so",
    "based", "between", "per", "of", "the", "about", "if", "by", "wide", "long", "high", "total", "approximately",
    "this", "that", "when", "after", "before", "along", "down", "up", "due", "und", "weil", "et", "car", "y",
    "porque", "i", "we", "it", "there"
])  # fmt: skip
_UNIT = r"\s*(?P<unit>[a-zA-ZÀ-ÿ°%]+(?:/[a-z]+)?|米|厘米|毫米|毫?秒|度|メートル|センチ)?(?![A-Za-z0-9_]|(?<=[a-z])/)"
_NUMBER = re.compile(
    rf"(?i)(?<![A-Za-z0-9_.⁄])(?P<value>\d+[/⁄]\d+|[-+]?(?:\d{{1,3}}(?:,\d{{3}})+|\d+)(?:[.,]\d+)?(?:e[-+]?\d{{1,3}}|\s*[×x]\s*10\^?[({{]?(?P<power>[-+]?\d{{1,2}})[)}}]?)?"
    rf"|[-+]?\.\d+)(?:\s*(?:±|\+/-)\s*[\d.]+)?{_UNIT}"
)
_IN_WORDS = re.compile(rf"(?i)\b(?P<value>{'|'.join(_NUMBER_WORDS)})\b{_UNIT}")
_ANNOUNCED = re.compile(r"(?i)\banswer\b|\bantwort\b|\bréponse\b|\brespuesta\b|答案|答え|正解")
_CONCLUDED = re.compile(
    r"(?i)\b(?:so|therefore|thus|hence|about|approximately|donc|also|daher|por lo tanto|entonces)\b|因此|所以|よって|[=≈≃~]"
)
_TOTAL = re.compile(r"(?i)\b(?:in total|altogether|in all|insgesamt|au total|en total)\b")
_RANGE = re.compile(r"(?i)\d\s*(?:-|–|—|to|bis|à)\s*\d|\bbetween\b|\bzwischen\b|\bentre\b|之间")


def is_near(value: float, truth: float, within: float, unit: str = "") -> bool:
    """Whether a number is right; for angles (rad) the shorter way round counts."""
    apart = abs(math.remainder(value - truth, math.tau)) if unit == "rad" else abs(value - truth)
    return apart <= within * (1 + 1e-9)


def number_in(text: str, unit: str = "") -> float | None:
    """Return the number in a reply, in the SI `unit`; None if there is none, several, or another quantity.

    A number after the last "answer" counts; then the last one that is concluded ("so 3 cm", "= 0.3 m"); then the only
    number of the reply. A range has no number.
    """
    reply = normalize(text)
    announced = _ANNOUNCED.split(reply)
    if len(announced) > 1 and (values := _first(announced[-1], unit)):
        return values[0]
    if (total := _TOTAL.search(reply)) and (values := list(_values(reply[: total.start()], unit))):
        return values[-1]
    sentences = [part for part in re.split(r"(?<=[^\d])[.!?](?:\s|$)|(?<=\d)\.(?:\s|$)|[。\n]", reply) if part.strip()]
    if _RANGE.search(reply):
        return None
    everywhere = _distinct(_values(reply, unit))
    if len(everywhere) == 1:
        return everywhere[0]
    for sentence in (sentences[-1], sentences[0]) if sentences else ():
        concluded = _CONCLUDED.split(sentence)
        values = _distinct(_values(concluded[-1], unit)) if len(concluded) > 1 else []
        if len(values) == 1:
            return values[0]
    return None


def _first(text: str, unit: str) -> list[float]:
    head = re.split(r"\n\s*\n", text.strip(" :=*\n"), maxsplit=1)[0]
    first_line = re.split(r"(?<!\d)\.\s|\n", head, maxsplit=1)[0]
    if _RANGE.search(first_line):
        return []
    last = re.split(r"[=≈]", first_line)[-1]
    return list(_values(last, unit))[:1] or list(_values(first_line, unit))[:1]


def _distinct(values: Iterator[float]) -> list[float]:
    return list({f"{value:.9g}": value for value in values}.values())


def _values(text: str, unit: str) -> Iterator[float]:
    """Yield the numbers of a text that may have this unit; those in words only if there are none in digits."""
    matches = list(_NUMBER.finditer(text)) or list(_IN_WORDS.finditer(text))
    for match in matches:
        value = _number(match)
        if value is None or not math.isfinite(value):
            continue
        size = _size(match["unit"] or "", text[match.end() :], unit)
        if size is not None:
            yield value * size


def _size(name: str, rest: str, unit: str) -> float | None:
    """Return the size of a number's unit in the SI `unit`; None if the number has another quantity."""
    if name == "in" and re.match(r"\s+[a-z]", rest):
        name = ""  # a preposition
    known = _UNITS.get(name) or _UNITS.get(name.casefold()) or _UNITS.get(name.casefold().removesuffix("s"))
    if known is not None:
        return known[1] if known[0] == unit else None
    counts = bool(name) and name.casefold() not in _FUNCTION_WORDS
    return None if counts and unit else 1.0  # "3 balls" is no length


def _number(match: re.Match[str]) -> float | None:
    written = match["value"].casefold().replace("⁄", "/")
    if written in _NUMBER_WORDS:
        return float(_NUMBER_WORDS.index(written))
    if "/" in written:
        above, below = written.split("/")
        return int(above) / int(below) if int(below) else None
    written = re.sub(r"\s*[×x]\s*10\^?[({]?([-+]?\d{1,2})[)}]?", r"e\1", written)
    if re.fullmatch(r"[-+]?(?:0,\d+|\d+,\d{1,2})(?:e.*)?", written):
        written = written.replace(",", ".")  # a decimal comma
    try:
        return float(written.replace(",", ""))
    except ValueError:
        return None
