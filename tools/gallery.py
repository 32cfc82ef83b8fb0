"""Write the tables of examples in docs/gallery.md and of objects in docs/worlds.md from the specs.

python tools/gallery.py            writes the pages
python tools/gallery.py --check    exits with 1 if a page is not current
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

from wmspec.lang.parse.files import read_source

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
#: Libraries of everyday objects.
LIBRARIES = ("kitchenware", "food", "toys", "household", "furniture")
DESCRIPTION = re.compile(r'\A"""(.*?)"""', re.DOTALL)


def gallery() -> Iterator[str]:
    """Yield a table with the picture, the spec and the description of each example."""
    yield "| picture | spec | question |\n|---|---|---|"
    for path in sorted((ROOT / "specs/gallery").glob("*.wms")):
        picture = f"![{path.stem}](images/gallery/{path.stem}.jpg)"
        yield f"| {picture} | `specs/gallery/{path.name}` | {description(path)[0]} |"


def paradigms() -> Iterator[str]:
    """Yield the description, the source and the picture of each paradigm."""
    for path in sorted((ROOT / "specs/paradigms").glob("*.wms")):
        summary, source = description(path)
        yield f"{summary} *{source}* `specs/paradigms/{path.name}`\n"
        yield f"![{path.stem.replace('_', ' ')}](images/paradigms/{path.stem}.jpg)\n"


def things() -> Iterator[str]:
    """Yield a table of the templates of each library of objects."""
    yield "| library | things |\n|---|---|"
    for name in LIBRARIES:
        templates = re.findall(r"^template (\w+)", read_source(ROOT / f"specs/library/{name}.wms").text, re.MULTILINE)
        yield f"| `{name}` | {', '.join(f'`{template}`' for template in templates)} |"


def description(path: Path) -> tuple[str, str]:
    """Return the first paragraph of a spec's description, with its title in bold, and the paragraph of its source."""
    found = DESCRIPTION.match(read_source(path).text)
    assert found, path
    first, *others = (" ".join(paragraph.split()) for paragraph in found[1].split("\n\n"))
    title, _, rest = first.partition(": ")
    source = next((text.removeprefix("Source: ") for text in others if text.startswith("Source: ")), "")
    return f"**{title}**: {rest}", source


def pages() -> Iterator[tuple[Path, str]]:
    """Yield each page and its current text."""
    for name, parts in (
        ("gallery", (("gallery", gallery()), ("paradigms", paradigms()))),
        ("worlds", (("things", things()),)),
    ):
        path = DOCS / f"{name}.md"
        text = path.read_text(encoding="utf-8")
        for mark, lines in parts:
            text = _with_part(text, mark, "\n".join(lines).strip())
        yield path, text


def _with_part(text: str, mark: str, made: str) -> str:
    """Return the text with the part between the comments of a mark replaced."""
    begin, end = f"<!-- {mark} -->\n", f"<!-- /{mark} -->"
    head, _, rest = text.partition(begin)
    _, found, tail = rest.partition(end)
    assert found, f"{begin.strip()} or {end} is missing"
    return f"{head}{begin}\n{made}\n\n{end}{tail}"


if __name__ == "__main__":
    for page, new in pages():
        if "--check" not in sys.argv:
            page.write_text(new, encoding="utf-8")
        elif page.read_text(encoding="utf-8") != new:
            sys.exit(f"{page} is not current")
