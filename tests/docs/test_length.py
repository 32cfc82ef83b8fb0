"""The documentation that people write is short enough for people to read."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: Largest number of words of all pages together.
MAX_WORDS = 35_000
#: Folders of pages that generators write.
GENERATED = ("docs/reference", "docs/benchmarks")
#: Code, parts of pages that generators write, and directives.
NOT_PROSE = re.compile(
    r"^ *(```|~~~)[^\n]*\n.*?^ *\1|<!-- (\w+) -->.*?<!-- /\2 -->|^::: [^\n]*\n(?:    [^\n]*\n|\n(?=    ))*",
    re.MULTILINE | re.DOTALL,
)


def words(text: str) -> int:
    """Return the number of words: whatever is between spaces and has a letter or a digit, outside code."""
    return sum(any(map(str.isalnum, word)) for word in NOT_PROSE.sub("", text).split())


def test_the_pages_are_short() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    written = [page for page in pages if not page.relative_to(ROOT).as_posix().startswith(GENERATED)]
    assert sum(words(page.read_text()) for page in written) <= MAX_WORDS


def test_only_words_outside_code_count() -> None:
    table, code = "# Two words\n\n| a | `b c` |\n|---|---|\n", "\n```sh\nnot these\n```\n"
    text = f"{table}{code}\n::: x.y\n    options:\n      heading: y\n\nlast"
    assert words(text) == 6
    assert words("one <!-- made -->\nnot these\n<!-- /made --> two") == 2
