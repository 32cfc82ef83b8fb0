"""The parsing tables of the grammar: made by Lark once, then kept in the user's cache."""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from contextlib import suppress
from importlib.resources import files
from pathlib import Path

import lark
from lark import Lark


def grammar() -> str:
    """The text of the grammar."""
    return files("wmspec").joinpath("grammar/wms.lark").read_text(encoding="utf-8")


def lark_parser() -> Lark:
    """Lark's parser for the grammar, from the cache if it was made before for this grammar, Lark and Python."""
    text = grammar()
    path = _cache_file(text)
    # Whatever is wrong with the cache (a read-only home, a file cut short), the tables are made anew.
    with suppress(Exception), path.open("rb") as file:
        return Lark.load(file)
    parser = Lark(text, parser="lalr", lexer="basic", start=["start", "expr"], propagate_positions=True)
    with suppress(OSError):
        _keep(parser, path)
    return parser


def _cache_file(text: str) -> Path:
    root = os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()
    made_for = hashlib.sha256("\0".join((text, lark.__version__, sys.version)).encode()).hexdigest()
    return Path(root, "wmspec", f"grammar-{made_for[:16]}.tables")


def _keep(parser: Lark, path: Path) -> None:
    """Write the tables whole or not at all: another process may read them at any time."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            parser.save(file)
        Path(name).replace(path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise
