"""Generate the grammars for syntax highlighting in editors from the words of the language.

python tools/grammars.py            rewrites the files in editors/
python tools/grammars.py --check    exits with 1 if they are not current
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from wmspec.editor.words import constants, functions, joining, statements
from wmspec.lang.check.types.units import UNITS

EDITORS = Path(__file__).parent.parent / "editors"
NUMBER = r"(?<![\w.])\d+(\.\d+)?([eE][+-]?\d+)?"


def files() -> dict[Path, str]:
    """Return the current text of every generated file."""
    grammar = json.dumps(textmate(), indent=2) + "\n"
    return {
        EDITORS / "vscode/syntaxes/wms.tmLanguage.json": grammar,
        EDITORS / "textmate/wms.tmLanguage.json": grammar,
        EDITORS / "vim/syntax/wms.vim": vim(),
        EDITORS / "vim/ftdetect/wms.vim": "autocmd BufRead,BufNewFile *.wms setfiletype wms\n",
    }


def textmate() -> dict[str, object]:
    """Return the TextMate grammar for VS Code, Sublime Text, TextMate and others."""
    units = "|".join(sorted((unit for unit in UNITS if unit.isalpha()), key=len, reverse=True))
    unit = rf"(?:{units})(?:\^-?\d+)?"
    hole = {"begin": r"(?<!\\)\{", "end": r"\}", "name": "meta.interpolation.wms", "patterns": [{"include": "$self"}]}
    escape = {"match": r"\\.", "name": "constant.character.escape.wms"}
    patterns: list[dict[str, object]] = [
        {"match": r"#.*$", "name": "comment.line.number-sign.wms"},
        {"begin": '"""', "end": '"""', "name": "string.quoted.triple.wms comment.block.documentation.wms"},
        {"begin": '"', "end": r'"|$', "name": "string.quoted.double.wms", "patterns": [escape, hole]},
        {"match": r"\b[A-Za-z_]\w*(?=[ \t]*:)", "name": "variable.parameter.wms"},
        {"match": rf"{NUMBER}(?:[ \t]*(?:%|{unit}(?:[*/]{unit})*)(?!\w))?", "name": "constant.numeric.wms"},
        {"match": rf"\b({'|'.join(functions())})(?=\()", "name": "support.function.wms"},
        {"match": rf"\b({'|'.join(statements())})\b", "name": "keyword.control.wms"},
        {"match": rf"\b({'|'.join(joining())})\b", "name": "keyword.operator.wms"},
        {"match": rf"\b({'|'.join(sorted(constants()))})\b", "name": "constant.language.wms"},
        {"match": r"==|!=|<=|>=|<|>|\.\.|[-+*/=]", "name": "keyword.operator.wms"},
    ]
    return {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "wmspec",
        "scopeName": "source.wms",
        "fileTypes": ["wms"],
        "patterns": patterns,
    }


def vim() -> str:
    """Return the syntax file of Vim and Neovim."""
    alternatives = r"\|".join(functions())
    lines = [
        '" Made by tools/grammars.py from the tables of the language.',
        "if exists('b:current_syntax')",
        "  finish",
        "endif",
        f"syntax keyword wmsStatement {' '.join(statements())}",
        f"syntax keyword wmsOperator {' '.join(joining())}",
        f"syntax keyword wmsConstant {' '.join(sorted(constants()))}",
        f"syntax match wmsFunction /\\<\\({alternatives}\\)\\ze(/",
        r"syntax match wmsProperty /\<[A-Za-z_]\w*\ze\s*:/",
        r"syntax match wmsNumber /\<\d\+\(\.\d\+\)\?\([eE][+-]\?\d\+\)\?\(\s*\(%\|[A-Za-z]\+\(\^-\?\d\+\)\?\([*\/][A-Za-z]\+\(\^-\?\d\+\)\?\)*\>\(\s*:\)\@!\)\)\?/ contains=wmsStatement,wmsOperator",
        r'syntax region wmsText start=/"/ skip=/\\./ end=/"\|$/ contains=wmsHole',
        r"syntax region wmsHole start=/{/ end=/}/ contained contains=TOP",
        r'syntax region wmsDoc start=/"""/ end=/"""/',
        "syntax match wmsComment /#.*$/",
        "highlight default link wmsStatement Statement",
        "highlight default link wmsOperator Operator",
        "highlight default link wmsConstant Constant",
        "highlight default link wmsFunction Function",
        "highlight default link wmsProperty Identifier",
        "highlight default link wmsNumber Number",
        "highlight default link wmsText String",
        "highlight default link wmsHole Special",
        "highlight default link wmsDoc Comment",
        "highlight default link wmsComment Comment",
        "setlocal commentstring=#\\ %s",
        "let b:current_syntax = 'wms'",
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Rewrite or check the files."""
    stale = [path for path, text in files().items() if not path.is_file() or path.read_text(encoding="utf-8") != text]
    if "--check" in sys.argv:
        sys.exit(bool(stale))
    for path in stale:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(files()[path], encoding="utf-8")


if __name__ == "__main__":
    main()
