"""Repairs of syntax from other languages: imports, `?:`, decimal commas, colons after keywords."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from wmspec.lang.parse.lexer import Token, text_of
from wmspec.lang.parse.repair_candidates import COMMON_UNITS, Repair, RepairSite
from wmspec.lang.parse.tables import tables

#: Keywords of other languages and their equivalents; the first that fits the place applies.
KEYWORD_ALIASES: dict[str, tuple[str, ...]] = {
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
#: Keywords that occur inside values.
_INNER = frozenset({"AND", "OR", "NOT", "TRUE", "FALSE"})
#: Maximum number of tokens of a rewritten value.
_MAX_TOKENS = 40


def foreign_candidates(place: RepairSite) -> Iterator[Repair]:
    """All that may have been meant, if this is written as in another language."""
    for guess in (
        _keyword_alias,
        _import,
        _colon,
        _quoted_name,
        _file_extension,
        _choice,
        _decimal,
        _needless_brackets,
        _shared_unit,
        _chain,
        _membership,
    ):
        yield from guess(place)


def _keyword_alias(place: RepairSite) -> Iterator[Repair]:
    """Foreign keywords: `import room`, `elif`."""
    text = place.word.text
    for written in KEYWORD_ALIASES.get(text, ()):
        kinds = tables().keywords
        made = tuple(place.word._replace(type=kinds[w], text=w) for w in written.split())
        if made[0].type in place.accepted:
            yield place.instead(*made, message=f"`{text}` is unexpected here", help=f"write `{written}`", cost=0.7)


def _import(place: RepairSite) -> Iterator[Repair]:
    """Python imports: `from room import *`."""
    word, line = place.word, [t for t in place.words[place.i : place.i + _MAX_TOKENS] if t.line == place.word.line]
    if word.text == "from" and "USE" in place.accepted and [t.text for t in line[2:3]] == ["import"]:
        made = (word._replace(type="USE", text="use"), line[1])
        help = f"write `use {line[1].text}`; `use {line[1].text} only [a, b]` takes some of it"
        yield place.instead(*made, message="`from` is unexpected here", help=help, cost=0.5, of=len(line))


def _colon(place: RepairSite) -> Iterator[Repair]:
    """A colon after a keyword: `at: 0.2 s`."""
    kind = tables().keywords.get(place.word.text, "")
    if place.after.type == "COLON" and kind in place.accepted - {"NAME"}:
        made, help = place.word._replace(type=kind), f"write `{place.word.text}`"
        yield place.instead(made, message=f"`{place.word.text}` has no colon here", help=help, cost=1.0, of=2)


def _quoted_name(place: RepairSite) -> Iterator[Repair]:
    """A name in quotes: `use "room"`."""
    name = place.word.text.strip('"').removesuffix(".wms")
    name_expected = "NAME" in place.accepted and "STRING" not in place.accepted
    if place.word.type == "STRING" and name_expected and name.isidentifier():
        made = place.word._replace(type="NAME", text=name)
        yield place.instead(made, message="a name has no quotes", help=f"write `{name}`", cost=0.5)


def _file_extension(place: RepairSite) -> Iterator[Repair]:
    """A file extension: `use room.wms`."""
    if (place.word.type, place.after.text) == ("DOT", "wms"):
        yield place.instead(message="a library is named without `.wms`", help="remove it", cost=0.5, of=2)


def _decimal(place: RepairSite) -> Iterator[Repair]:
    """A decimal comma: `2,5 s`."""
    if place.i and (made := merge_decimal(*place.words[place.i - 1 : place.i + 2])) is not None:
        message, help = "a number has a point, no comma", f"write `{made.text}`"
        yield Repair(place.i - 1, place.i + 2, (made,), message, help, 0.5)


def merge_decimal(*words: Token) -> Token | None:
    """Return the number that adjacent number, comma and number tokens may stand for, or None."""
    if [w.type for w in words[:2]] != ["NUMBER", "COMMA"] or words[-1].type not in ("NUMBER", "QUANTITY"):
        return None
    touch = len(words) == 3 and words[0].end == words[1].start and words[1].end == words[2].start
    whole, _, rest = words
    text = f"{whole.text}.{rest.text}"
    return rest._replace(text=text, start=whole.start) if touch and "." not in whole.text + rest.text else None


def _needless_brackets(place: RepairSite) -> Iterator[Repair]:
    """Needless brackets around names: `orbit of [tone, size]`."""
    if place.word.type not in ("LPAR", "LSQB") or place.word.type in place.accepted or "NAME" not in place.accepted:
        return
    end = _find_outside_brackets(place.words, place.i + 1, lambda t: t.type in _CLOSING)
    inner = place.words[place.i + 1 : end]
    if end is not None and inner and all(t.type == ("COMMA" if k % 2 else "NAME") for k, t in enumerate(inner)):
        names = ", ".join(t.text for t in inner[::2])
        message, help = "names stand without brackets here", f"write `{names}`"
        yield Repair(place.i, end + 1, tuple(inner), message, help, 0.6)


def _shared_unit(place: RepairSite) -> Iterator[Repair]:
    """One unit for a tuple: `(1, 2, 3) cm`."""
    if place.word.text not in COMMON_UNITS or place.before.type != "RPAR":
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


def _chain(place: RepairSite) -> Iterator[Repair]:
    """A chain of comparisons: `1 < n < 4`."""
    if place.word.type != "COMPARE" or place.word.type in place.accepted:
        return
    start = _value_start(place.words, place.i)
    first = next((k for k in range(start, place.i) if place.words[k].type == "COMPARE"), None)
    middle = place.words[first + 1 : place.i] if first is not None else ()
    if first is None or not middle:
        return
    low, high = text_of(place.words[start : place.i]), place.words[place.i + 1 : _value_end(place.words, place.i + 1)]
    help = f"write `{low} and {text_of(middle)} {place.word.text} {text_of(high)}`"
    made = (_word("and", place), *middle, place.word)
    yield place.instead(*made, message="comparisons form no chain", help=help, cost=0.2)


def _membership(place: RepairSite) -> Iterator[Repair]:
    """Membership: `n in [2, 3]`."""
    if place.word.type != "IN" or place.word.type in place.accepted or place.after.type != "LSQB":
        return
    start, stop = _value_start(place.words, place.i), _value_end(place.words, place.i + 1)
    value, items = place.words[start : place.i], place.words[place.i + 2 : stop - 1]
    if not value or not items or any(t.type in _OPENING for t in items):
        return
    made, sign = [], place.word._replace(type="COMPARE", text="==")
    for k, item in enumerate(t for t in items if t.type != "COMMA"):
        made += [*([_word("or", place), *value] if k else []), sign, item]
    help = f"write `{text_of(value)} {' '.join(t.text for t in made)}`"
    yield Repair(place.i, stop, tuple(made), "`in` is unexpected here", help, 0.2)


def _value_end(words: Sequence[Token], i: int) -> int:
    """Return the index after the value that begins at token `i`, on its line."""
    ends = {"COMMA", "RPAR", "RSQB", "RBRACE", "COMPARE"} | _keywords()
    deep = 0
    for k in range(i, min(len(words), i + _MAX_TOKENS)):
        if deep == 0 and k > i and (words[k].type in ends or words[k].line > words[i].line):
            return k
        deep += (words[k].type in _OPENING) - (words[k].type in _CLOSING)
        if deep == 0 and words[k].type in _CLOSING:
            return k + 1
    return min(len(words), i + _MAX_TOKENS)


# ---------------------------------------------------------------- choices


def _choice(place: RepairSite) -> Iterator[Repair]:
    """Conditionals: `A if C else B`, `C ? A : B`, `if C: A else: B`."""
    words, i = place.words, place.i
    sign = place.word.text
    if sign not in ("if", "?", ":"):
        return
    middle = _find_outside_brackets(words, i + 1, lambda t: t.type == ("COLON" if sign == "?" else "ELSE"))
    if middle is None:
        return
    start, after = _value_start(words, i), words[i + 1 : middle]
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
    last = _find_outside_brackets(words, stop + 1, lambda t: t.type in ends or t.line > words[middle].line) or stop + 1
    condition, then, otherwise = (text_of(part) for part in (first, second, words[stop:last]))
    if condition and then and otherwise:
        made = [_word("if", place), *first, _word("then", place), *_merge_units(second), _word("else", place)]
        help = f"write `if {condition} then {then} else {otherwise}`"
        yield Repair(start, stop, tuple(made), "a choice begins with its condition", help, 0.6)


def _word(keyword: str, place: RepairSite) -> Token:
    return Token(tables().keywords[keyword], keyword, place.word.start, place.word.line)


def _find_outside_brackets(words: Sequence[Token], i: int, is_it: Callable[[Token], bool]) -> int | None:
    """Return the first matching index from `i` on, outside nested brackets; None past the enclosing bracket."""
    deep = 0
    for k in range(i, min(len(words), i + _MAX_TOKENS)):
        if deep == 0 and is_it(words[k]):
            return k
        deep += (words[k].type in _OPENING) - (words[k].type in _CLOSING)
        if deep < 0:
            return None
    return None


def _value_start(words: Sequence[Token], i: int) -> int:
    """Return the index at which the value before token `i` begins."""
    deep = 0
    for k in range(i - 1, -1, -1):
        kind = words[k].type
        deep += (kind in _CLOSING) - (kind in _OPENING)
        if deep < 0 or (deep == 0 and kind in ("COMMA", "COLON", "EQUAL", *_keywords())):
            return k + 1
    return 0


def _keywords() -> frozenset[str]:
    return frozenset(tables().keywords.values()) - _INNER


def _merge_units(words: Sequence[Token]) -> list[Token]:
    """Return the tokens with numbers and units merged; a colon after a unit had kept them apart."""
    made: list[Token] = []
    for word in words:
        if made and made[-1].type == "NUMBER" and word.text in COMMON_UNITS:
            made[-1] = made[-1]._replace(type="QUANTITY", text=f"{made[-1].text} {word.text}")
        else:
            made.append(word)
    return made
