"""What colours specs is made of the words of the language, and colours them."""

from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
from pygments.lexers import get_lexer_by_name
from pygments.token import Comment, Error, Keyword, Name, Number

from tools.grammars import files, textmate
from wmspec.editor.pygments import WmsLexer
from wmspec.editor.words import joining, keywords, statements
from wmspec.lang.parse.files import library_folder

ROOT = Path(__file__).parents[2]
SPECS = sorted(library_folder().parent.rglob("*.wms"))


def test_the_files_are_those_that_the_tables_make() -> None:
    stale = [path.name for path, text in files().items() if path.read_text(encoding="utf-8") != text]
    assert not stale, "run `make generate`"
    assert {*statements(), *joining()} == {*keywords()} >= {"task", "in", "title"}


def test_the_patterns_are_expressions() -> None:
    patterns = textmate()["patterns"]
    assert isinstance(patterns, list)
    for pattern in patterns:
        for key in ("match", "begin", "end"):
            re.compile(pattern.get(key, ""))


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_pygments_keeps_every_character_and_knows_every_word(path: Path) -> None:
    text = path.read_text()
    tokens = list(WmsLexer().get_tokens_unprocessed(text))
    assert "".join(word for _, _, word in tokens) == text
    assert not [word for _, kind, word in tokens if kind in Error]


def test_words_have_their_kinds() -> None:
    kinds = {
        word: kind for _, kind, word in WmsLexer().get_tokens_unprocessed("factor x in [6 cm] # so\nlet y = min(x)")
    }
    assert (kinds["factor"], kinds["6 cm"], kinds["# so"]) == (Keyword, Number, Comment.Single)
    assert kinds["min"] == Name.Function


@pytest.mark.build
def test_the_lexer_is_found_where_wmspec_is_installed() -> None:
    try:
        found = get_lexer_by_name("wms")
    except ValueError:
        pytest.skip("this environment was made before the lexer; `make setup` renews it")
    assert isinstance(found, WmsLexer)


@pytest.mark.slow
@pytest.mark.build
def test_the_extension_is_packaged(tmp_path: Path) -> None:
    if shutil.which("npm") is None:
        pytest.skip("there is no node here; on Debian: sudo apt-get install npm")
    out = tmp_path / "wmspec.vsix"
    done = subprocess.run([ROOT / "tools/extension.sh", out], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    names = set(zipfile.ZipFile(out).namelist())
    assert {"extension/dist/extension.js", "extension/syntaxes/wms.tmLanguage.json"} <= names
