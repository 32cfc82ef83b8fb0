"""Replaces idioms of other languages that no spec can contain, before the text is parsed.

Each is reported once, with what to write instead, and the rest of the text is parsed as if that had been written.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from itertools import pairwise

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source, Span
from wmspec.lang.parse.lexer import Token, text_of
from wmspec.lang.parse.repair_candidates import Repair
from wmspec.lang.parse.tables import tables

_HEXADECIMAL = re.compile(r"#([0-9a-fA-F]{6}|[0-9a-fA-F]{3})(?!\w)")
_CLOSING = {"LPAR": "RPAR", "LSQB": "RSQB", "LBRACE": "RBRACE"}
_LOOPS = ("for", "foreach", "while", "loop", "repeat")
_FUNCTIONS = ("def", "fn", "func", "function", "lambda")
_OUTPUT = ("print", "console", "echo", "printf")


def hexadecimal_color(digits: str) -> str:
    """Return a hexadecimal colour as `rgb(...)`."""
    parts = re.findall("..", digits) if len(digits) == 6 else [digit * 2 for digit in digits]
    return f"rgb({', '.join(f'{round(int(part, 16) / 2.55)} %' for part in parts)})"


def color_in_comment(tokens: Sequence[Token]) -> tuple[int, str] | None:
    """Return the index and the colour of a comment that begins with one, after a colon or in a list; or None."""
    for i, (before, comment) in enumerate(pairwise(tokens), 1):
        color = _HEXADECIMAL.match(comment.text) if comment.type == "COMMENT" else None
        if color and before.type in ("COLON", "LSQB", "COMMA", "EQUAL") and before.end_line == comment.line:
            return i, color[0]
    return None


def replace_idioms(source: Source, tokens: list[Token], report: Report) -> list[Token]:
    """Return the tokens with idioms replaced; each is reported."""
    i = 0
    while i < len(tokens):
        found = next((idiom for one in _IDIOMS if (idiom := one(tokens, i)) is not None), None)
        if found is None:
            i += 1
            continue
        last = tokens[max(found.start, found.stop - 1)]
        report.add("WMS101", found.message, Span(source, tokens[found.start].start, last.end), found.help)
        tokens = [*tokens[: found.start], *found.words, *tokens[found.stop :]]
        i = found.start + len(found.words)
    return tokens


# ---------------------------------------------------------------- signs


def _power(tokens: Sequence[Token], i: int) -> Repair | None:
    """`n ** 2`, `n ^ 2`."""
    double = [t.text for t in tokens[i : i + 2]] == ["*", "*"] and tokens[i].end == tokens[i + 1].start
    if not double and tokens[i].text != "^":
        return None
    first, stop = _operand_before(tokens, i), i + 1 + double
    if first is None or stop >= len(tokens):
        return None
    base = text_of(tokens[first:i])
    square = tokens[stop].text == "2"
    help = f"write `{base} * {base}`" if square else "write a product, or `sqrt(...)` for a root"
    words = (tokens[i]._replace(type="TIMES", text="*"), *tokens[first:i])
    return Repair(i, stop + 1, words, "there is no sign for powers", help)


def _remainder(tokens: Sequence[Token], i: int) -> Repair | None:
    """`n % 2`."""
    if tokens[i].type != "STRAY" or tokens[i].text != "%":
        return None
    first = _operand_before(tokens, i)
    if first is None or i + 1 >= len(tokens) or tokens[i + 1].type not in ("NUMBER", "NAME"):
        return None
    a, b = text_of(tokens[first:i]), tokens[i + 1].text
    return Repair(i, i + 2, (), "there is no sign for the remainder", f"write `mod({a}, {b})`")


def _equal(tokens: Sequence[Token], i: int) -> Repair | None:
    """`n === 2`, `tone is red`, `start += 2 cm`."""
    word, after = tokens[i], tokens[i + 1 : i + 2]
    if word.text in ("==", "!=") and after and after[0].type == "EQUAL" and after[0].start == word.end:
        return Repair(i, i + 2, (word,), f"`{word.text}=` is unexpected here", f"write `{word.text}`")
    if word.type in ("PLUS", "MINUS", "TIMES") and after and after[0].type == "EQUAL" and after[0].start == word.end:
        return Repair(i, i + 2, (after[0],), f"`{word.text}=` changes a value, and values never change", "write `=`")
    between = i and after and tokens[i - 1].type in tables().value_ends and tokens[i - 1].line == word.line
    if word.text == "is" and word.type == "NAME" and between and after[0].type in ("NAME", "NUMBER", "STRING", "NOT"):
        many, sign = (2, "!=") if after[0].type == "NOT" else (1, "==")
        words = (word._replace(type="COMPARE", text=sign),)
        return Repair(i, i + many, words, "`is` is unexpected here", f"write `{sign}`")
    return None


def _holdout(tokens: Sequence[Token], i: int) -> Repair | None:
    """`holdout shape x color in ...`, `holdout shape, color in ...`, `holdout color == red`."""
    if tokens[i].type != "HOLDOUT" or [t.type for t in tokens[i + 1 : i + 2]] != ["NAME"]:
        return None
    names, after = [tokens[i + 1]], i + 2
    while [t.type for t in tokens[after + 1 : after + 2]] == ["NAME"] and tokens[after].text in ("x", ",", "*", "and"):
        names.append(tokens[after + 1])
        after += 2
    sign = tokens[after] if after < len(tokens) else None
    if sign is None:
        return None
    written = ", ".join(name.text for name in names)
    if len(names) > 1 and sign.type == "IN":
        opened, comma, closed = (
            sign._replace(type=kind, text=text) for kind, text in (("LPAR", "("), ("COMMA", ","), ("RPAR", ")"))
        )
        listed = [token for name in names for token in (comma, name)][1:]
        help = f"write `holdout ({written}) in [(LEVEL, LEVEL)]`"
        return Repair(i + 1, after, (opened, *listed, closed), "several factors of a hold-out are in parentheses", help)
    if len(names) == 1 and sign.text in ("==", "=") and after + 1 < len(tokens):
        value = tokens[after + 1]
        inside = sign._replace(type="IN", text="in"), sign._replace(type="LSQB", text="[")
        words = (*inside, value, value._replace(type="RSQB", text="]"))
        return Repair(
            after, after + 2, words, "a hold-out lists levels", f"write `holdout {written} in [{value.text}]`"
        )
    return None


def _braces(tokens: Sequence[Token], i: int) -> Repair | None:
    """A list in braces: `in {red, blue}`."""
    if tokens[i].type != "LBRACE" or not i or tokens[i - 1].type not in ("IN", "EQUAL", "COLON", "OF"):
        return None
    end = _closing(tokens, i)
    inner = tokens[i + 1 : end] if end is not None else ()
    if end is None or not inner or any(t.type in ("COLON", "LBRACE") or t.line != tokens[i].line for t in inner):
        return None
    opened, closed = tokens[i]._replace(type="LSQB", text="["), tokens[end]._replace(type="RSQB", text="]")
    help = f"write `[{text_of(inner)}]`"
    return Repair(i, end + 1, (opened, *inner, closed), "a list stands in square brackets", help)


def _hyphen_range(tokens: Sequence[Token], i: int) -> Repair | None:
    """A domain with a hyphen: `factor pace in 0.6 - 0.9 m/s`."""
    words = tokens[i : i + 7]
    if len(words) < 7 or [t.type for t in words[1:3]] != ["NAME", "IN"] or words[0].type not in ("FACTOR", "NUISANCE"):
        return None
    low, minus, high, after = words[3:]
    numbers = low.type in ("NUMBER", "QUANTITY") and high.type in ("NUMBER", "QUANTITY") and minus.type == "MINUS"
    if not numbers or after.line == high.line:
        return None
    unit = high.text.lstrip("0123456789.eE+") if high.type == "QUANTITY" and low.type == "NUMBER" else ""
    first = low._replace(type="QUANTITY", text=f"{low.text}{unit}") if unit else low
    made: tuple[Token, ...] = (first, minus._replace(type="RANGE", text=".."), high)
    written = f"{first.text} .. {high.text}"
    if words[0].type == "FACTOR":
        written += " in 3"
        made += (minus._replace(type="IN", text="in"), minus._replace(type="NUMBER", text="3"))
    return Repair(i + 3, i + 6, made, "`-` subtracts, and a range has two points", f"write `{written}`")


# ---------------------------------------------------------------- statements


def _sets(tokens: Sequence[Token], i: int) -> Repair | None:
    """`action push[n] = ...`, `actions push = ...`, `objects dots { ... }`."""
    words = tokens[i : i + 3]
    if len(words) < 3 or words[1].type != "NAME" or not _begins_line(tokens, i):
        return None
    name = words[1].text
    if words[0].type == "ACTION" and words[2].type == "LSQB" and (end := _closing(tokens, i + 2)) is not None:
        help = f"write `actions {name}{text_of(tokens[i + 2 : end + 1])} = ...`"
        return Repair(i, end + 1, (words[0], words[1]), "this declares a set of actions", help)
    if words[0].type == "FACTOR" and words[2].type == "LSQB" and (end := _closing(tokens, i + 2)) is not None:
        help = f"write `nuisance {name}{text_of(tokens[i + 2 : end + 1])}`, or a factor for each"
        message = "a factor has one value, and a nuisance may have one for each member of a set"
        return Repair(i, end + 1, (words[0], words[1]), message, help)
    if words[0].type == "ACTIONS" and words[2].type == "EQUAL":
        made = words[0]._replace(type="ACTION", text="action")
        help = f"write `action {name}`, or `actions {name}[NUMBER]` for a set"
        return Repair(i, i + 2, (made, words[1]), "a set of actions has a number", help)
    if words[0].type in ("OBJECTS", "JOINTS") and words[2].type in ("LBRACE", "COLON"):
        single = words[0].text[:-1]
        made = words[0]._replace(type=single.upper(), text=single)
        help = f"write `{words[0].text} {name}[NUMBER]`, or `{single} {name}` for one"
        return Repair(i, i + 2, (made, words[1]), f"a set of {words[0].text} has a number", help)
    return None


def _condition(tokens: Sequence[Token], i: int) -> Repair | None:
    """`action push = if n == 2 then launch(...)`, `action push = launch(...) if n == 2`, `answer a if b`."""
    if tokens[i].type != "IF" or not i:
        return None
    stop = _statement_end(tokens, i)
    rest = [t.type for t in tokens[i + 1 : stop]]
    start = _statement_start(tokens, i)
    action = tokens[start].type == "ACTION"
    if "ELSE" in rest:
        return None
    if action and "THEN" in rest and tokens[i - 1].type == "EQUAL":
        then = i + 1 + rest.index("THEN")
        verb, condition = text_of(tokens[then + 1 : stop]), text_of(tokens[i + 1 : then])
        help = f"write `{text_of(tokens[start:i])} {verb} when {condition}`"
        return Repair(i, then + 1, (), "a condition follows the verb", help)
    if "THEN" in rest or tokens[i - 1].type not in tables().value_ends:
        return None
    if action:
        made = tokens[i]._replace(type="WHEN", text="when")
        help = f"write `when {text_of(tokens[i + 1 : stop])}`"
        return Repair(i, i + 1, (made,), "the condition of an action begins with `when`", help)
    help = "write `if CONDITION then A else B`; what an instance must meet is `ensure CONDITION`"
    return Repair(i, stop, (), "this `if` has no `else`", help)


def _cause(tokens: Sequence[Token], i: int) -> Repair | None:
    """`cause of toppled(tower)`, without candidates."""
    if tokens[i].type != "CAUSE" or i + 1 >= len(tokens) or tokens[i + 1].type != "OF":
        return None
    stop = _statement_end(tokens, i)
    after = tokens[stop].type if stop < len(tokens) else ""
    if after == "AMONG" or any(token.type == "AMONG" for token in tokens[i:stop]):
        return None
    help = f"write `{text_of(tokens[i:stop])} among [a, b]`, of which one is the answer"
    return Repair(i, i + 2, (), "a cause is one of several candidates", help)


def _change(tokens: Sequence[Token], i: int) -> Repair | None:
    """`under push.speed: 1 m/s`, without the kind of change."""
    if [t.type for t in tokens[i : i + 3]] != ["UNDER", "NAME", "DOT"]:
        return None
    stop = _statement_end(tokens, i)
    written = text_of(tokens[i + 1 : stop])
    help = f"write `under action {written}` for an argument of an action, `under state {written}` for a property"
    return Repair(i, stop, (), "a change begins with `action` or `state`", help)


def _block(tokens: Sequence[Token], i: int) -> Repair | None:
    """A loop or a condition around statements: `for i in range(3) {`, `if n == 2 {`."""
    word = tokens[i]
    if word.text not in (*_LOOPS, "if") or not _begins_line(tokens, i):
        return None
    line = [k for k in range(i, len(tokens)) if tokens[k].line == word.line]
    opened = next((k for k in line if tokens[k].type == "LBRACE"), None)
    end = _closing(tokens, opened) if opened is not None else None
    if opened is None or end is None or tokens[end].line == word.line or any(tokens[k].type == "THEN" for k in line):
        return None
    if word.text == "if":
        help = f"give objects `present: {text_of(tokens[i + 1 : opened])}`, and actions `when ...`"
        return Repair(i, end + 1, tuple(tokens[opened + 1 : end]), "statements have no conditions around them", help)
    variable = tokens[i + 1].text if word.text in ("for", "foreach") else ""
    inner = () if word.text in ("while", "loop", "repeat") else tokens[opened + 1 : end]
    made = tuple(t._replace(type="NUMBER", text="0") if t.text == variable else t for t in inner)
    help = "declare a set: `objects NAME[NUMBER] { ... }`, with `index` for the number of each member"
    return Repair(i, end + 1, made, "there are no loops", help)


def _function(tokens: Sequence[Token], i: int) -> Repair | None:
    """`def half(x) = x / 2`, `print(n)`."""
    word, after = tokens[i], tokens[i + 1 : i + 3]
    if word.type != "NAME" or len(after) < 2 or not _begins_line(tokens, i):
        return None
    stop = _line_end(tokens, i)
    if word.text in _FUNCTIONS and after[1].type == "LPAR":
        help = f"name a value: `let {after[0].text} = ...`; `template` is for objects alike"
        return Repair(i, stop, (), "functions cannot be defined", help)
    if word.text in _OUTPUT and after[0].type in ("LPAR", "DOT"):
        help = "`wmspec list` prints the values of instances, and `wmspec watch` shows their pictures"
        return Repair(i, stop, (), "nothing is printed from a spec", help)
    return None


def _quotes_in_braces(tokens: Sequence[Token], i: int) -> Repair | None:
    """`"The {if a == "b" then "c" else "d"} ball"`: a text within the braces of a text."""
    text, stop = tokens[i].text if tokens[i].type == "STRING" else "", i + 1
    while stop < len(tokens) and tokens[stop].line == tokens[i].line and text.count("{") > text.count("}"):
        text, stop = text + tokens[stop].text, stop + 1
    if stop == i + 1 or tokens[stop - 1].type != "STRING" or text.count("{") != text.count("}"):
        return None
    whole = tokens[i]._replace(text='"' + text[1:-1].replace('"', "").partition("{")[0] + '"')
    message = "a text cannot be quoted within the braces of another text"
    return Repair(i, stop, (whole,), message, "name the value above, as in `let NAME = ...`, and write `{NAME}`")


_IDIOMS: tuple[Callable[[Sequence[Token], int], Repair | None], ...] = (
    _holdout,
    _quotes_in_braces,
    _power,
    _remainder,
    _equal,
    _braces,
    _hyphen_range,
    _sets,
    _block,
    _condition,
    _cause,
    _change,
    _function,
)


# ---------------------------------------------------------------- where things are


def _begins_line(tokens: Sequence[Token], i: int) -> bool:
    return i == 0 or tokens[i - 1].end_line < tokens[i].line


def _line_end(tokens: Sequence[Token], i: int) -> int:
    """Return the index of the first token after the line of token `i`."""
    return next((k for k in range(i, len(tokens)) if tokens[k].line > tokens[i].end_line), len(tokens))


def _statement_start(tokens: Sequence[Token], i: int) -> int:
    """Return the index of the token that begins the line of token `i`."""
    return next(k for k in range(i, -1, -1) if _begins_line(tokens, k))


def _statement_end(tokens: Sequence[Token], i: int) -> int:
    """Return the index after the value that token `i` is in: the end of its line or block."""
    deep = 0
    for k in range(i, _line_end(tokens, i)):
        deep += (tokens[k].type in _CLOSING) - (tokens[k].type in _CLOSING.values())
        if deep < 0:
            return k
    return _line_end(tokens, i)


def _closing(tokens: Sequence[Token], i: int) -> int | None:
    """Return the index of the bracket that closes the one at `i`, or None."""
    deep, opening = 0, tokens[i].type
    for k in range(i, len(tokens)):
        deep += (tokens[k].type == opening) - (tokens[k].type == _CLOSING[opening])
        if deep == 0:
            return k
    return None


def _operand_before(tokens: Sequence[Token], i: int) -> int | None:
    """Return where the operand before token `i` begins: a name, a number, or brackets with the name before them."""
    if not i or tokens[i - 1].type not in tables().value_ends:
        return None
    k, deep = i - 1, 0
    while k >= 0:
        deep += (tokens[k].type in _CLOSING.values()) - (tokens[k].type in _CLOSING)
        if deep == 0:
            break
        k -= 1
    called = k > 0 and tokens[k].type in ("LPAR", "LSQB") and tokens[k - 1].type == "NAME"
    return max(k - called, 0)
