"""Write the tables of docs/gallery.md from the descriptions of specs/gallery and specs/paradigms.

python tools/gallery.py            writes the page
python tools/gallery.py --check    exits with 1 if the page is not current
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

from wmspec.lang.parse.files import read_source

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs/gallery.md"
DESCRIPTION = re.compile(r'\A"""(.*?)"""', re.DOTALL)


def gallery() -> Iterator[str]:
    """Yield a table with the picture, the spec and the description of each example."""
    yield "| | spec | asks |\n|---|---|---|"
    for path in sorted((ROOT / "specs/gallery").glob("*.wms")):
        picture = f"![{path.stem}](images/gallery/{path.stem}.jpg)"
        yield f"| {picture} | `specs/gallery/{path.name}` | {description(path)[0]} |"


def paradigms() -> Iterator[str]:
    """Yield the description, the source and the picture of each paradigm."""
    for path in sorted((ROOT / "specs/paradigms").glob("*.wms")):
        summary, source = description(path)
        yield f"{summary} *{source}* `specs/paradigms/{path.name}`\n"
        yield f"![{path.stem.replace('_', ' ')}](images/paradigms/{path.stem}.jpg)\n"


def description(path: Path) -> tuple[str, str]:
    """Return the first paragraph of a spec's description, with its title in bold, and the paragraph of its source."""
    found = DESCRIPTION.match(read_source(path).text)
    assert found, path
    first, *others = (" ".join(paragraph.split()) for paragraph in found[1].split("\n\n"))
    title, _, rest = first.partition(": ")
    source = next((text.removeprefix("Source: ") for text in others if text.startswith("Source: ")), "")
    return f"**{title}**: {rest}", source


def page(text: str) -> str:
    """Return the page with current tables."""
    for name, lines in (("gallery", gallery()), ("paradigms", paradigms())):
        begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->"
        head, _, rest = text.partition(begin)
        _, found, tail = rest.partition(end)
        assert found, f"{PAGE} lacks {begin.strip()} or {end}"
        made = "\n".join(lines).strip()
        text = f"{head}{begin}\n{made}\n\n{end}{tail}"
    return text


if __name__ == "__main__":
    old = PAGE.read_text(encoding="utf-8")
    if "--check" in sys.argv:
        sys.exit(page(old) != old)
    PAGE.write_text(page(old), encoding="utf-8")
