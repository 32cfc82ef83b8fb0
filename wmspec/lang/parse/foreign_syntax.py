"""What is written as in other languages: an import, a choice with `?`, a comma in a number, a colon after a keyword."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

from wmspec.lang.parse.lexer import Token
from wmspec.lang.parse.repair_candidates import UNITS, Place, Repair
from wmspec.lang.parse.tables import tables

#: What statements and words are called elsewhere; of several, what fits the place.
OTHERWISE: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("import", "include", "using"), ("use",)),
    **dict.fromkeys(("const", "var", "define", "def", "set"), ("let",)),
    **dict.fromkeys(("assert", "constraint", "where"), ("require", "ensure")),
    **dict.fromkeys(("elif", "elsif", "elseif"), ("else if",)),
    **dict.fromkeys(("body", "entity", "thing", "actor"), ("object", "objects")),
    **dict.fromkeys(("param",), ("parameter",)),
    **dict.fromkeys(("vary", "variable"), ("factor",)),
    **dict.fromkeys(("ask",), ("question",)),
    **dict.fromkeys(("show", "view", "watch", "record"), ("observe",)),
    **dict.fromkeys(("choices",), ("options",)),
    **dict.fromkeys(("duration",), ("horizon",)),
}
_OPENING, _CLOSING = ("LPAR", "LSQB", "LBRACE"), ("RPAR", "RSQB", "RBRACE")
#: Keywords that stand within a value.
_INNER = frozenset({"AND", "OR", "NOT", "TRUE", "FALSE"})
#: So many words a value has at most that is turned round.
_LONG = 40


def elsewhere(place: Place) -> Iterator[Repair]:
    """All that may have been meant, if this is written as in another language."""
    for guess in (_otherwise, _import, _colon, _quoted, _ending, _choice, _decimal, _bracketed, _shared_unit):
        yield from guess(place)


def _otherwise(place: Place) -> Iterator[Repair]:
    """`import room`, `elif`."""
    text = place.word.text
    for written in OTHERWISE.get(text, ()):
        kinds = tables().keywords
        made = tuple(place.word._replace(type=kinds[w], text=w) for w in written.split())
        if made[0].type in place.accepted:
            yield place.instead(*made, told=f"`{text}` is unexpected here", help=f"write `{written}`", cost=0.7)


def _import(place: Place) -> Iterator[Repair]:
    """`from room import *`."""
    word, line = place.word, [t for t in place.words[place.i : place.i + _LONG] if t.line == place.word.line]
    if word.text == "from" and "USE" in place.accepted and [t.text for t in line[2:3]] == ["import"]:
        made = (word._replace(type="USE", text="use"), line[1])
        help = f"write `use {line[1].text}`; `use {line[1].text} only [a, b]` takes some of it"
        yield place.instead(*made, told="`from` is unexpected here", help=help, cost=0.5, of=len(line))


def _colon(place: Place) -> Iterator[Repair]:
    """`at: 0.2 s`: a colon after a keyword."""
    kind = tables().keywords.get(place.word.text, "")
    if place.after.type == "COLON" and kind in place.accepted - {"NAME"}:
        made, help = place.word._replace(type=kind), f"write `{place.word.text}`"
        yield place.instead(made, told=f"`{place.word.text}` has no colon here", help=help, cost=1.0, of=2)


def _quoted(place: Place) -> Iterator[Repair]:
    """`use "room"`: a name in quotes."""
    name = place.word.text.strip('"').removesuffix(".wms")
    wanted = "NAME" in place.accepted and "STRING" not in place.accepted
    if place.word.type == "STRING" and wanted and name.isidentifier():
        made = place.word._replace(type="NAME", text=name)
        yield place.instead(made, told="a name has no quotes", help=f"write `{name}`", cost=0.5)


def _ending(place: Place) -> Iterator[Repair]:
    """`use room.wms`."""
    if (place.word.type, place.after.text) == ("DOT", "wms"):
        yield place.instead(told="a library is named without `.wms`", help="remove it", cost=0.5, of=2)


def _decimal(place: Place) -> Iterator[Repair]:
    """`2,5 s`."""
    if place.i and (made := decimal(*place.words[place.i - 1 : place.i + 2])) is not None:
        told, help = "a number has a point, no comma", f"write `{made.text}`"
        yield Repair(place.i - 1, place.i + 2, (made,), told, help, 0.5)


def decimal(*words: Token) -> Token | None:
    """The number that a number, a comma and a number may be meant for, if nothing is between them."""
    if [w.type for w in words[:2]] != ["NUMBER", "COMMA"] or words[-1].type not in ("NUMBER", "QUANTITY"):
        return None
    touch = len(words) == 3 and words[0].end == words[1].start and words[1].end == words[2].start
    whole, _, rest = words
    text = f"{whole.text}.{rest.text}"
    return rest._replace(text=text, start=whole.start) if touch and "." not in whole.text + rest.text else None


def _bracketed(place: Place) -> Iterator[Repair]:
    """`orbit of [tone, size]`: brackets around names that need none."""
    if place.word.type not in ("LPAR", "LSQB") or place.word.type in place.accepted or "NAME" not in place.accepted:
        return
    end = _first(place.words, place.i + 1, lambda t: t.type in _CLOSING)
    inner = place.words[place.i + 1 : end]
    if end is not None and inner and all(t.type == ("COMMA" if k % 2 else "NAME") for k, t in enumerate(inner)):
        names = ", ".join(t.text for t in inner[::2])
        told, help = "names stand without brackets here", f"write `{names}`"
        yield Repair(place.i, end + 1, tuple(inner), told, help, 0.6)


def _shared_unit(place: Place) -> Iterator[Repair]:
    """`(1, 2, 3) cm`: one unit for a tuple."""
    if place.word.text not in UNITS or place.before.type != "RPAR":
        return
    i, end = place.i, place.i + 1
    while (
        end + 1 < len(place.words)
        and place.words[end].type == "TIMES"
        and place.words[end].start == place.words[end - 1].end
    ):
        end += 2
    unit = "".join(t.text for t in place.words[i:end])
    opened = next((k for k in range(i - 2, -1, -1) if place.words[k].type == "LPAR"), None)
    inner = place.words[opened + 1 : i - 1] if opened is not None else ()
    if opened is not None and inner and all(t.type in ("NUMBER", "COMMA", "MINUS") for t in inner):
        made = [t._replace(type="QUANTITY", text=f"{t.text} {unit}") if t.type == "NUMBER" else t for t in inner]
        help = f"write `({', '.join(t.text for t in made if t.type == 'QUANTITY')})`"
        words = (place.words[opened], *made, place.before)
        yield Repair(opened, end, words, "a tuple has no unit of its own, as a list has", help, 0.6)


# ---------------------------------------------------------------- choices


def _choice(place: Place) -> Iterator[Repair]:
    """`A if C else B`, `C ? A : B`, `if C: A else: B`."""
    words, i = place.words, place.i
    sign = place.word.text
    if sign not in ("if", "?", ":"):
        return
    middle = _first(words, i + 1, lambda t: t.type == ("COLON" if sign == "?" else "ELSE"))
    if middle is None:
        return
    start, after = _begin(words, i), words[i + 1 : middle]
    stop = middle + 1
    if sign == ":":
        if "THEN" not in place.accepted:
            return
        stop += words[stop].type == "COLON"
        made = [_word("then", place), *after, _word("else", place)]
        yield Repair(i, stop, tuple(made), "`:` is unexpected here", "write `then`, and `else` without a colon", 0.6)
        return
    first, second = (after, words[start:i]) if sign == "if" else (words[start:i], after)
    ends = {"COMMA", "RPAR", "RSQB", "RBRACE"} | (_keywords() - {"IF", "THEN", "ELSE"})
    last = _first(words, stop + 1, lambda t: t.type in ends or t.line > words[middle].line) or stop + 1
    condition, then, otherwise = (_text(part) for part in (first, second, words[stop:last]))
    if condition and then and otherwise:
        made = [_word("if", place), *first, _word("then", place), *_united(second), _word("else", place)]
        help = f"write `if {condition} then {then} else {otherwise}`"
        yield Repair(start, stop, tuple(made), "a choice begins with its condition", help, 0.6)


def _word(keyword: str, place: Place) -> Token:
    return Token(tables().keywords[keyword], keyword, place.word.start, place.word.line)


def _first(words: Sequence[Token], i: int, is_it: Callable[[Token], bool]) -> int | None:
    """The first such word from the `i`-th on, but for what is in brackets; None after what closes these here."""
    deep = 0
    for k in range(i, min(len(words), i + _LONG)):
        if deep == 0 and is_it(words[k]):
            return k
        deep += (words[k].type in _OPENING) - (words[k].type in _CLOSING)
        if deep < 0:
            return None
    return None


def _begin(words: Sequence[Token], i: int) -> int:
    """Where the value before the `i`-th word begins."""
    deep = 0
    for k in range(i - 1, -1, -1):
        kind = words[k].type
        deep += (kind in _CLOSING) - (kind in _OPENING)
        if deep < 0 or (deep == 0 and kind in ("COMMA", "COLON", "EQUAL", *_keywords())):
            return k + 1
    return 0


def _keywords() -> frozenset[str]:
    return frozenset(tables().keywords.values()) - _INNER


def _united(words: Sequence[Token]) -> list[Token]:
    """The words with numbers and units together: a colon after a unit keeps them apart."""
    made: list[Token] = []
    for word in words:
        if made and made[-1].type == "NUMBER" and word.text in UNITS:
            made[-1] = made[-1]._replace(type="QUANTITY", text=f"{made[-1].text} {word.text}")
        else:
            made.append(word)
    return made


def _text(words: Sequence[Token]) -> str:
    """The words as they stand in the text, on one line."""
    gaps = [" " * (b.start > a.end) for a, b in pairwise(words)]
    return "".join(t.text + gap for t, gap in zip(words, [*gaps, ""], strict=False))
