"""Confusable characters: typographic substitutes inserted by editors, and operators of other languages."""

from __future__ import annotations

from collections.abc import Generator, Iterator

from wmspec.core.diagnostics import Report
from wmspec.core.places import Source, Span
from wmspec.lang.parse.foreign_syntax import merge_decimal
from wmspec.lang.parse.lexer import Token, tokenize

#: Replacements of characters that are no tokens: token type and text.
_SIGNS = {
    **dict.fromkeys("−–—‒﹣－", ("MINUS", "-")),
    **dict.fromkeys("×∙⋅·", ("TIMES", "*")),
    **dict.fromkeys("÷∕⁄", ("TIMES", "/")),
    "≤": ("COMPARE", "<="),
    "≥": ("COMPARE", ">="),
    "≠": ("COMPARE", "!="),
    "…": ("RANGE", ".."),
    "，": ("COMMA", ","),
    "：": ("COLON", ":"),
    "（": ("LPAR", "("),
    "）": ("RPAR", ")"),
    "!": ("NOT", "not"),
    "&": ("AND", "and"),
    "|": ("OR", "or"),
}
#: Replacements of two adjacent tokens: token type and text.
_PAIRS = {
    "&&": ("AND", "and"),
    "||": ("OR", "or"),
    "<>": ("COMPARE", "!="),
    "=<": ("COMPARE", "<="),
    "=>": ("COMPARE", ">="),
}
#: Typographic opening quotes and the characters that may close them.
_QUOTES = {"“": '”"“„', "”": '”"“', "„": '“”"', "«": '»"', "»": '«"', "‘": "’'‘", "’": "’'", "'": "'’", "`": "`'"}
#: Characters after a number that denote a unit or an exponent, and their replacement.
_UNIT_SIGNS = {"°": " deg", "º": " deg", "²": "^2", "³": "^3", "µ": " um", "μ": " um"}
_SPACES = frozenset("\u00a0\u2007\u2009\u200a\u200b\u202f\u3000\ufeff")


def replace_confusables(source: Source, tokens: list[Token], report: Report) -> Iterator[Token]:
    """Yield the tokens with confusable characters replaced; each replacement is reported."""
    i = 0
    while i < len(tokens):
        one, following = tokens[i], tokens[i + 1] if i + 1 < len(tokens) else None
        pair = one.text + following.text if following is not None and following.start == one.end else ""
        if pair == "//" or (pair == "/*" and one.type == "TIMES"):
            i = _skip_comment(source, tokens, i, pair, report)
        elif one.type == "NUMBER" and (number := _decimal(tokens, i)) is not None:
            help = f"write `{number.text}`, or a unit after each number"
            report.add("WMS102", "a number has a point, no comma", _span(source, one, tokens[i + 2].end), help)
            yield number
            i += 3
        elif pair in _PAIRS:
            yield _replace(source, one, pair, *_PAIRS[pair], report)
            i += 2
        elif following is not None and following.text in _UNIT_SIGNS and one.type in ("NUMBER", "QUANTITY"):
            written = _UNIT_SIGNS[following.text]
            message = f"`{following.text}` means nothing here"
            report.add("WMS102", message, _span(source, following, following.end), f"write `{written.strip()}`")
            yield one._replace(type="QUANTITY", text=one.text + written)
            i += 2
        elif one.type == "STRAY":
            i = yield from _replace_stray(source, tokens, i, report)
        else:
            yield one
            i += 1


def _decimal(tokens: list[Token], i: int) -> Token | None:
    """Return the number of `1,4 cm`. A number and a quantity are never adjacent items, except for a unitless 0."""
    number = merge_decimal(*tokens[i : i + 3])
    return number if number is not None and number.type == "QUANTITY" and float(tokens[i].text) else None


def _replace_stray(source: Source, tokens: list[Token], i: int, report: Report) -> Generator[Token, None, int]:
    """Yield the replacement of a stray character; return the index of the next token."""
    one = tokens[i]
    if one.text in _QUOTES:
        return (yield from _replace_quotes(source, tokens, i, report))
    if one.text in _SIGNS:
        yield _replace(source, one, one.text, *_SIGNS[one.text], report)
    elif one.text in _SPACES:
        report.add("WMS102", "this is an unusual space", _span(source, one, one.end), "write an ordinary one")
    elif one.text.isalpha():
        return _report_word(source, tokens, i, report)
    else:
        yield one
    return i + 1


def _report_word(source: Source, tokens: list[Token], i: int, report: Report) -> int:
    """Report a word with letters that names cannot have; return the index of the next token."""
    end = i
    while end < len(tokens) and (tokens[end].text.isalpha() and tokens[end].type in ("STRAY", "NAME")):
        end += 1
    message = f"`{tokens[i].text}` is no letter of a name"
    report.add("WMS102", message, _span(source, tokens[i], tokens[i].end), "names have the letters a to z")
    return end


def _replace(source: Source, one: Token, text: str, kind: str, written: str, report: Report) -> Token:
    message = f"`{text}` means nothing here"
    report.add("WMS102", message, _span(source, one, one.start + len(text)), f"write `{written}`")
    return one._replace(type=kind, text=written)


def _replace_quotes(source: Source, tokens: list[Token], i: int, report: Report) -> Generator[Token, None, int]:
    """Yield a text in typographic quotes, up to its closing quote on the line, or report one stray quote."""
    one, text = tokens[i], source.text
    end = text.find("\n", one.start)
    line = text[one.start : len(text) if end < 0 else end]
    close = next((k for k in range(1, len(line)) if line[k] in _QUOTES[one.text]), None)
    if close is None:
        report.add("WMS102", f"`{one.text}` means nothing here", _span(source, one, one.end), 'write `"`')
        return i + 1
    stop = one.start + close + 1
    message = f'a text stands in `"`, and this is `{one.text}`'
    report.add("WMS102", message, _span(source, one, one.end), f'write `"{line[1:close]}"`'[:60])
    yield one._replace(type="STRING", text=f'"{line[1:close]}"')
    return _resume(text, tokens, i, stop)


def _skip_comment(source: Source, tokens: list[Token], i: int, sign: str, report: Report) -> int:
    """Skip a comment in another language's syntax, up to the end of its line or its closing sign."""
    text, start = source.text, tokens[i].start
    end = text.find("\n" if sign == "//" else "*/", start)
    stop = len(text) if end < 0 else end + (2 if sign == "/*" else 0)
    remedy = "write `#`" if sign == "//" else "begin each line of it with `#`"
    report.add("WMS102", f"`{sign}` begins no comment here", _span(source, tokens[i], tokens[i + 1].end), remedy)
    return _resume(text, tokens, i, stop)


def _resume(text: str, tokens: list[Token], i: int, stop: int) -> int:
    """Return the index of the first token from an offset on; the rest of a token across it is read again."""
    while i < len(tokens) and tokens[i].start < stop:
        i += 1
    if (end := tokens[i - 1].end) > stop:
        tokens[i:i] = [t for t in tokenize(text[stop:end], stop) if t.type not in ("WHITE", "COMMENT")]
    return i


def _span(source: Source, token: Token, end: int) -> Span:
    return Span(source, token.start, end)
