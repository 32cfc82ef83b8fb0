"""The LR parser agrees with Lark, which generates its tables: same tokens, same trees."""

import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from lark import Lark
from lark import Token as LarkToken
from lark import Tree as LarkTree
from lark.exceptions import UnexpectedInput

from tests.examples import examples
from tests.language.specs import FEW, SPECS, random_text
from tests.language.trees import expressions, files, statements, written
from wmspec.lang.parse.lexer import Token, tokenize
from wmspec.lang.parse.lr_parser import END, LRParser, Tree
from wmspec.lang.parse.syntax import Expr, File, Statement
from wmspec.lang.parse.tables import grammar, lark_parser, tables


@cache
def lark() -> Lark:
    return lark_parser(grammar())


def ours(text: str) -> Any:
    machine = LRParser("start")
    tokens = [t for t in tokenize(text) if t.type not in ("WHITE", "COMMENT", "OPEN_STRING")]
    if not all(machine.read(token) for token in [*tokens, Token(END, "", len(text), 0)]):
        return "refused"
    return bare(machine.result)


def theirs(text: str) -> Any:
    try:
        return bare(lark().parse(text, start="start"))
    except UnexpectedInput:
        return "refused"


def bare(node: Any) -> Any:
    """Rules, tokens and gaps only."""
    match node:
        case Tree():
            return node.rule, [bare(child) for child in node.children]
        case LarkTree():
            return str(node.data), [bare(child) for child in node.children]
        case Token():
            return node.type, node.text
        case LarkToken():
            return node.type, str(node)
    return node


@pytest.mark.parametrize("path", SPECS[::8], ids=lambda p: f"{p.parent.stem}-{p.stem}")
def test_what_is_accepted_is_what_can_be_read(path: Path) -> None:
    """`accepted` follows token types together; one by one they come to the same."""
    machine, text = LRParser("start"), path.read_text()
    tokens = [t for t in tokenize(text) if t.type not in ("WHITE", "COMMENT")]
    kinds = {kind for state in machine.tables.states for kind in state if kind.isupper() or kind == END}
    for i, token in enumerate(tokens):
        if i % 7 == 0:
            assert machine.accepted() == {kind for kind in kinds if machine.accepts(kind)}
        assert machine.read(token)
    assert END in machine.accepted()


@pytest.mark.parametrize("path", FEW, ids=lambda p: f"{p.parent.stem}-{p.stem}")
def test_specs_are_read_as_lark_reads_them(path: Path) -> None:
    text = path.read_text()
    assert ours(text) == theirs(text) != "refused"


@given(files)
def test_trees_are_read_as_lark_reads_them(tree: File) -> None:
    assert ours(written(tree)) == theirs(written(tree)) != "refused"


@examples(20, 60, deadline=None)
@given(random_text(), files)
def test_truncated_and_shuffled_texts_fail_where_lark_fails(text: str, tree: File) -> None:
    other = written(tree)
    for mixed in (text[: len(other)], text[: len(text) // 2] + other, other[: len(other) // 2]):
        assert ours(mixed) == theirs(mixed)


# ---------------------------------------------------------------- keywords


def pattern(name: str) -> str:
    return str(next(t.pattern.value for t in lark().terminals if t.name == name))


def test_grammar_excludes_keywords_from_units() -> None:
    keywords = {*tables().keywords, *re.findall(r"\w+(?=[|)])", pattern("SETTING"))}
    (barred,) = re.findall(r"\(\?!\(([\w|]+)\)", pattern("LIST_UNIT"))
    assert set(barred.split("|")) == keywords - {"true", "false"}
    assert f"(?!({barred})" in pattern("QUANTITY")


def words(text: str) -> list[Token]:
    return [token for token in tokenize(text) if token.type not in ("WHITE", "COMMENT")]


@given(statements)
def test_recovery_resumes_at_words_that_begin_statements(statement: Statement) -> None:
    assert words(written(statement))[0].type in tables().starters


@given(expressions)
def test_values_end_with_the_words_that_make_a_minus_a_difference(value: Expr) -> None:
    assert words(written(value))[-1].type in tables().value_ends


def test_reading_can_go_on_at_all_statements_and_at_nothing_that_stands_in_one() -> None:
    parser = lark().parse_interactive("", start="start")
    assert parser.accepts() - {"$END", "LONG_STRING"} == tables().starters & parser.accepts()
    assert not tables().starters & {"NAME", "AT", "BY", "IN", "PART", "STATE", "ORDER", "WITHOUT", "RBRACE"}


# ---------------------------------------------------------------- places, and what is kept


def test_words_have_their_places() -> None:
    text = 'task a {\n  """two\nlines"""  factor b in [1, 2] cm  # end\n}\n'
    found = list(tokenize(text, 7))
    assert "".join(t.text for t in found) == text
    assert all(text[t.start - 7 : t.end - 7] == t.text for t in found)
    lines = {t.text: (t.line, t.end_line) for t in found}
    assert lines["task"] == (1, 1)
    assert lines['"""two\nlines"""'] == (2, 3)
    assert lines["factor"] == (3, 3)
    assert lines["}"] == (4, 4)


def test_broken_tables_are_generated_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = tables.__wrapped__()
    (kept,) = (tmp_path / "wmspec").iterdir()
    whole = kept.read_bytes()
    assert tables.__wrapped__() == first
    for broken in (b"", whole[:100], b"\x80\x04N."):
        kept.write_bytes(broken)
        made = tables.__wrapped__()  # Lark numbers the states as it likes
        assert (made.pattern, made.keywords, made.rules) == (first.pattern, first.keywords, first.rules)
        assert tables.__wrapped__() == made
