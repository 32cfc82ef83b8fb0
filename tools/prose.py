"""Check the words of docs, docstrings, comments, messages and identifiers against `tools/prose.toml`.

`python -m tools.prose [PATH...]` prints every place with its rule and exits with 1 if there is one.
"""

from __future__ import annotations

import ast
import io
import json
import re
import subprocess
import sys
import tokenize
import tomllib
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
RULES = ROOT / "tools/prose.toml"
CODE = re.compile(r"^(```|~~~).*?^\1|`[^`\n]*`|<!--.*?-->|\]\([^)\s]*\)", re.DOTALL | re.MULTILINE)
PART = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
#: Where comments of other files begin.
COMMENTS = {".js": "//", ".lark": "//", ".sh": "#", ".toml": "#", ".wms": "#"}
#: Suffixes of the files that are checked.
KINDS = {".md", ".py", ".ipynb", *COMMENTS}
#: Not checked: lists that generators write, texts of others, and the rules themselves.
SKIPPED = ("docs/licences.md", "tools/prose.*", "tests/thirdparty/*")


class Finding(NamedTuple):
    """A word against the rules: the file, the line (from 1), the word, and the remedy."""

    path: Path
    line: int
    word: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: `{self.word}`: {self.remedy}"


class Rules:
    """The rules of a TOML file."""

    def __init__(self, file: Path = RULES) -> None:
        data = tomllib.loads(file.read_text(encoding="utf-8"))
        self.prose = [(re.compile(rf"\b(?:{rule})\b", re.IGNORECASE), remedy) for rule, remedy in data["prose"].items()]
        self.identifiers: dict[str, str] = data["identifiers"]
        self.allowed: dict[str, str] = data["allowed"]

    def permits(self, path: Path, line: str) -> bool:
        """Whether a line of a file is listed as allowed."""
        return any(fnmatch(path.as_posix(), glob) and text in line for glob, text in self.allowed.items())


def findings(path: Path, text: str, rules: Rules) -> Iterator[Finding]:
    """Yield every finding in a file: all prose of Markdown and notebooks, words and identifiers of Python, comments."""
    lines = text.splitlines()
    nodes = list(ast.walk(ast.parse(text))) if path.suffix == ".py" else []
    for first, words in _spans(path, text, nodes):
        for pattern, remedy in rules.prose:
            for match in pattern.finditer(words):
                line = first + words.count("\n", 0, match.start())
                if not rules.permits(path, lines[min(line, len(lines)) - 1]):
                    yield Finding(path, line, " ".join(match[0].split()), remedy)
    yield from _names(path, nodes, rules)


def _spans(path: Path, text: str, nodes: list[ast.AST]) -> Iterator[tuple[int, str]]:
    """The words of a file, with the lines on which they begin."""
    match path.suffix:
        case ".py":
            return _python(text, nodes)
        case ".md":
            return _markdown(text)
        case ".ipynb":
            return _notebook(text)
        case other:
            return _comments(text, COMMENTS[other])


def _comments(text: str, mark: str) -> Iterator[tuple[int, str]]:
    """What follows a mark at the start of a line or after a space."""
    for number, line in enumerate(text.splitlines(), 1):
        if found := re.search(rf"(?:^|\s){mark}(.*)", line):
            yield number, re.sub(r"`[^`]*`", "", found[1])


def _notebook(text: str) -> Iterator[tuple[int, str]]:
    """The Markdown of a notebook, with the line of the JSON on which each cell's text begins."""
    number = 1
    for cell in json.loads(text)["cells"]:
        if cell["cell_type"] == "markdown" and cell["source"]:
            first = json.dumps(cell["source"][0], ensure_ascii=False)
            number += text.split("\n", number - 1)[-1].partition(first)[0].count("\n")
            yield from ((number + line - 1, words) for line, words in _markdown("".join(cell["source"])))


def _markdown(text: str) -> Iterator[tuple[int, str]]:
    yield 1, CODE.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text)


def _python(text: str, nodes: list[ast.AST]) -> Iterator[tuple[int, str]]:
    """Comments and strings with the lines on which they begin."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], re.sub(r"`[^`\n]*`", "", token.string)
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield node.lineno, CODE.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), node.value)


def _names(path: Path, nodes: list[ast.AST], rules: Rules) -> Iterator[Finding]:
    """Names that are defined: functions, classes, arguments, variables, fields."""
    for node in nodes:
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                yield from _name(path, node.lineno, name, rules)
            case ast.arg(arg=name) | ast.Name(id=name, ctx=ast.Store()):
                yield from _name(path, node.lineno, name, rules)


def _name(path: Path, line: int, name: str, rules: Rules) -> Iterator[Finding]:
    for part in PART.findall(name):
        if remedy := rules.identifiers.get(part.lower()):
            yield Finding(path, line, name, f"no identifier contains `{part.lower()}`; write {remedy}")


def files(paths: list[str]) -> list[Path]:
    """The checked files below the paths, all by default, relative to the root."""
    command = ["git", "ls-files", "-co", "--exclude-standard", *(paths or ["*"])]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    found = [Path(p) for p in listed if Path(p).suffix in KINDS and (ROOT / p).is_file()]
    return [path for path in found if not any(fnmatch(path.as_posix(), glob) for glob in SKIPPED)]


def main() -> None:
    """Print all findings; exit with 1 if there are any."""
    rules = Rules()
    texts = ((path, (ROOT / path).read_text(encoding="utf-8")) for path in files(sys.argv[1:]))
    found = [finding for path, text in texts for finding in findings(path, text, rules)]
    print(*found, sep="\n")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
