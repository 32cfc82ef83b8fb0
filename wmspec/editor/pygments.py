"""A Pygments lexer for specs in documentation, based on the parser's tokens."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from pygments.lexer import Lexer
from pygments.token import (
    Comment,
    Error,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Text,
    Whitespace,
    _TokenType,
)

from wmspec.editor.words import SOFT, constants
from wmspec.lang.parse.lexer import Token, tokenize
from wmspec.lang.parse.tables import tables

_PLAIN: dict[str, _TokenType] = {
    "WHITE": Whitespace,
    "COMMENT": Comment.Single,
    "LONG_STRING": String.Doc,
    "STRING": String,
    "OPEN_STRING": String,
    "NUMBER": Number,
    "QUANTITY": Number,
    "LIST_UNIT": Number,
    "COMPARE": Operator,
    "PLUS": Operator,
    "MINUS": Operator,
    "TIMES": Operator,
    "STRAY": Error,
}


class WmsLexer(Lexer):
    """Lexer for the language of wmspec."""

    name = "wmspec"
    aliases: ClassVar[list[str]] = ["wms"]
    filenames: ClassVar[list[str]] = ["*.wms"]
    mimetypes: ClassVar[list[str]] = []

    def get_tokens_unprocessed(self, text: str) -> Iterator[tuple[int, _TokenType, str]]:
        """Yield every token with its offset and kind."""
        tokens = list(tokenize(text))
        after: str = ""
        for token, following in zip(tokens, [*tokens[1:], Token("WHITE", "", 0, 0)], strict=True):
            yield token.start, _kind(token, after, following), token.text
            after = after if token.type in ("WHITE", "COMMENT") else token.type


def _kind(token: Token, after: str, following: Token) -> _TokenType:
    if token.type in _PLAIN:
        return _PLAIN[token.type]
    word = token.text
    if following.text == ":" and after != "COLON":
        return Name.Attribute
    if following.text == "(":
        return Name.Function
    if word in tables().keywords and not (word in SOFT and after in ("COLON", "DOT")):
        return Keyword
    if token.type == "NAME" or word in tables().keywords:
        return Name.Constant if word in constants() else Name
    return Punctuation if token.text.strip() else Text
