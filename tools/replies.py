"""Write `docs/benchmarks/replies.md`: how the reader of replies does on replies that were labelled by hand.

python tools/replies.py            writes it
python tools/replies.py --check    exits with 1 if it is not current
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from wmspec.eval.replies import LETTERS, PARSER_VERSION, choice, number_in

ROOT = Path(__file__).parent.parent
CORPUS, PAGE = ROOT / "tests/data/replies", ROOT / "docs/benchmarks/replies.md"
LANGUAGES = {
    "en": "English", "zh": "Chinese", "ja": "Japanese", "de": "German", "fr": "French", "es": "Spanish",
}  # fmt: skip
_FIRST = re.compile(r"^# First reading: (\d+) false and (\d+) unread\.$", re.MULTILINE)


@dataclass(frozen=True)
class Labelled:
    """A reply, its language and options as in the file, and its label: a letter, position or number, '-' for none."""

    file: str
    language: str
    options: str
    label: str
    text: str

    def read(self) -> str:
        """Return the label that the reader gives."""
        if self.options.startswith("="):
            return self._number()
        numbered = self.options.startswith("#")
        count = self.options.removeprefix("#")
        options = (None,) * int(count) if count.isdecimal() else tuple(self.options.split("|"))
        place = choice(self.text, options, "numbers" if numbered else "letters")
        return "-" if place is None else str(place + 1) if numbered else LETTERS[place]

    def _number(self) -> str:
        value = number_in(self.text, self.options[1:])
        if value is None:
            return "-"
        near = self.label != "-" and math.isclose(value, float(self.label), rel_tol=1e-4)
        return self.label if near else f"{value:g}"

    @property
    def is_false(self) -> bool:
        """Whether the reader takes an answer that a careful reader does not."""
        return self.read() not in {self.label, "-"}

    @property
    def is_unread(self) -> bool:
        """Whether the reader misses an answer."""
        return self.label != "-" and self.read() == "-"


def corpus() -> list[Labelled]:
    """Return all labelled replies."""
    return [reply for path in sorted(CORPUS.glob("*.tsv")) for reply in _file(path)]


def _file(path: Path) -> Iterator[Labelled]:
    for line in path.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            language, options, label, text = line.split("\t")
            yield Labelled(path.stem, language, options, label, text.replace("\\n", "\n").replace("\\\\", "\\"))


def page(replies: list[Labelled]) -> str:
    """Return the page."""
    kinds: dict[str, Callable[[Labelled], bool]] = {
        "pictures, by letters": lambda r: r.options.isdecimal(),
        "words, by letters": lambda r: not r.options.isdecimal() and r.options[0] not in "#=",
        "pictures, by numbers": lambda r: r.options.startswith("#"),
        "no options: a number with its unit": lambda r: r.options.startswith("="),
    }
    lines = [_line(name, [r for r in replies if r.language == code]) for code, name in LANGUAGES.items()]
    lines += [_line(name, [r for r in replies if of_kind(r)]) for name, of_kind in kinds.items()]
    first = [_first_reading(path) for path in sorted(CORPUS.glob("*.tsv"))]
    return f"""# Reading replies

A model answers in free text, and wmspec finds the chosen option in this text by rules (`wmspec/eval/replies`). This
page measures how often the rules, version {PARSER_VERSION}, read a reply wrongly. `python tools/replies.py` writes it.

The test replies in `tests/data/replies` were written for this measurement. Each has a label that was given by hand:
the option that a careful reader finds in the reply, or none if it contains no answer.

A *false read* is a reply in which the rules find an answer that is not its label. An *unread* reply has an answer that
the rules do not find. The percentages of false reads are shares of all replies. The percentages of unread replies are
shares of the replies that have an answer.

| language, or kind of options | replies | replies with an answer | false reads | unread replies |
|---|---|---|---|---|
{_line("**all**", replies)}
{chr(10).join(lines)}

These rates are too good for new replies, because the rules were changed until they read these replies well. The next
table is a fairer estimate. Each of its files was written when the rules already existed. The rules first read it as
they then were, and the table counts the mistakes of this reading. Only then were the rules improved with this file.
All but one of the false reads in the table are of replies without an answer. Such replies are frequent in these files
and rare in practice.

| file | replies | replies with an answer | false reads at this reading | unread replies at this reading |
|---|---|---|---|---|
{chr(10).join(row for row in first if row)}

The table omits two files. `first.tsv` was written together with the rules. The 12 replies of `fifth.tsv` are only about
tasks in which *right* is a direction; at first, the rules had 3 false reads and no unread reply in it.
"""


def _line(name: str, replies: list[Labelled]) -> str:
    readable = sum(r.label != "-" for r in replies)
    false, unread = sum(r.is_false for r in replies), sum(r.is_unread for r in replies)
    return f"| {name} | {len(replies)} | {readable} | {_rate(false, len(replies))} | {_rate(unread, readable)} |"


def _first_reading(path: Path) -> str:
    found = _FIRST.search(path.read_text(encoding="utf-8"))
    if found is None:
        return ""
    replies = list(_file(path))
    readable = sum(r.label != "-" for r in replies)
    false, unread = _rate(int(found[1]), len(replies)), _rate(int(found[2]), readable)
    return f"| `{path.name}` | {len(replies)} | {readable} | {false} | {unread} |"


def _rate(count: int, total: int) -> str:
    return f"{count} ({count / max(total, 1):.1%})"


def main() -> None:
    """Write the page, or check it."""
    written = page(corpus())
    if "--check" not in sys.argv[1:]:
        PAGE.write_text(written, encoding="utf-8")
    elif PAGE.read_text(encoding="utf-8") != written:
        sys.exit(f"{PAGE.relative_to(ROOT)} is not current; python tools/replies.py writes it")


if __name__ == "__main__":
    main()
