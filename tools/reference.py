"""The tables of docs/language.md, made from what the checker knows.

python tools/reference.py            rewrites them
python tools/reference.py --check    exits with 1 if they are not current
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from wmspec.check.functions import FUNCTIONS
from wmspec.check.units import EXAMPLES, UNITS
from wmspec.check.verbs import VERBS
from wmspec.check.vocabulary import PROPERTIES, SETTINGS, WORDS, Slot
from wmspec.parse.diagnostics import CODES

PAGE = Path(__file__).parent.parent / "docs/language.md"
MARK = "<!-- reference -->\n"


def current(page: str) -> str:
    """The page with its tables as they should be."""
    tour, mark, _ = page.partition(MARK)
    return tour + mark + "\n" + "\n".join(reference())


def reference() -> Iterator[str]:
    """The lines of the reference."""
    yield "### Properties\n"
    for kind, slots in PROPERTIES.items():
        yield f"Of {'the world' if kind == 'world' else f'{article(kind)} {kind}'}:\n"
        yield from table(
            ("property", "takes", "left out", "meaning"), (row(name, slot) for name, slot in slots.items())
        )
    yield "### Verbs\n"
    for name, verb in VERBS.items():
        arguments = ", ".join(verb.arguments)
        yield f"`{name}({arguments})`{' for TIME' if verb.lasts else ''} {verb.meaning}.\n"
        slots = verb.arguments.items()
        yield from table(("argument", "takes", "left out", "meaning"), (row(n, slot) for n, slot in slots))
    yield "### Functions\n"
    for measured in (False, True):
        told = "Measured on the executed episode, in `answer`, `ensure` and `margin`:" if measured else "Anywhere:"
        yield f"{told}\n"
        chosen = ((n, f) for n, f in FUNCTIONS.items() if f.measured == measured)
        rows = ((f"`{n}({', '.join(map(str, f.parameters))})`", str(f.result), f.meaning) for n, f in chosen)
        yield from table(("function", "gives", "meaning"), rows)
    yield "### Settings\n"
    yield "Of a task, each once: " + ", ".join(f"`{name}` ({kind})" for name, kind in SETTINGS.items()) + ".\n"
    yield "### Words\n"
    for vocabulary, words in WORDS.items():
        yield f"- **{vocabulary}**: {', '.join(f'`{word}`' for word in words)}"
    yield "\n### Units\n"
    units = (
        (f"`{name}`", str(dimension), f"{scale:.6g} {dimension.symbol}".strip())
        for name, (scale, dimension) in UNITS.items()
    )
    yield from table(("unit", "of", "in SI"), units)
    yield "They combine: " + ", ".join(f"{dimension} `{text}`" for dimension, text in EXAMPLES.items()) + ".\n"
    yield "### Codes\n"
    yield from table(("code", "meaning"), ((f"`{code}`", meaning) for code, meaning in CODES.items()))


def row(name: str, slot: Slot) -> tuple[str, ...]:
    """A property or argument as a row of its table."""
    kinds = " or ".join(str(kind) for kind in slot.kinds)
    left_out = f"`{slot.default}`" if slot.default is not None else "—" if slot.optional else "must be given"
    return f"`{name}`", kinds + bounds(slot), left_out, slot.meaning


def bounds(slot: Slot) -> str:
    """What a slot's values are limited to, as it is said after their kind."""
    if slot.least is not None and slot.most is not None:
        return f", {slot.least:g} to {slot.most:g}"
    limits = (("more than", slot.above), ("at least", slot.least), ("at most", slot.most))
    return "".join(f", {word} {bound:g}" for word, bound in limits if bound is not None)


def article(noun: str) -> str:
    """A or an."""
    return "an" if noun[0] in "aeio" else "a"


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    """A Markdown table and an empty line."""
    yield f"| {' | '.join(head)} |"
    yield f"|{'---|' * len(head)}"
    for cells in rows:
        yield f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"
    yield ""


def main() -> None:
    """Rewrite the page, or tell whether it is current."""
    page = PAGE.read_text(encoding="utf-8")
    made = current(page)
    if "--check" in sys.argv:
        sys.exit(made != page)
    PAGE.write_text(made, encoding="utf-8")


if __name__ == "__main__":
    main()
