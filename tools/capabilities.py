"""Write the capability matrix in docs/stage.md from the capabilities that engines declare.

python tools/capabilities.py            rewrites it
python tools/capabilities.py --check    exits with 1 if it is not current
"""

from __future__ import annotations

import sys
from pathlib import Path

from wmspec.runtime.engines.registry import info, names
from wmspec.sim.scene.capability import APPROXIMATE, capability_table

PAGE = Path(__file__).parent.parent / "docs/stage.md"
START, STOP = "<!-- capabilities -->\n", "<!-- /capabilities -->\n"


def current(page: str) -> str:
    """Return the page with the current table."""
    before, start, rest = page.partition(START)
    _, stop, after = rest.partition(STOP)
    assert start
    assert stop
    return before + start + "\n" + "\n".join(lines()) + "\n\n" + stop + after


def lines() -> list[str]:
    """Return the table in Markdown."""
    engines = [info(name) for name in names()]
    head = f"| | {' | '.join(engine.title for engine in engines)} | otherwise |"
    rows = capability_table({engine.name: engine.lacks for engine in engines})
    shown = [f"| {name} | {' | '.join(cells(row))} |" for name, row in rows]
    return [head, "|---|" + "---|" * (len(engines) + 1), *shown]


def cells(row: dict[str, str]) -> list[str]:
    """Return a mark for each engine, and the reasons."""
    marks = ["≈" if reason.startswith(APPROXIMATE) else "—" if reason else "✓" for reason in row.values()]
    return [*marks, "; ".join(dict.fromkeys(filter(None, row.values())))]


def main() -> None:
    """Rewrite or check the page."""
    text = PAGE.read_text()
    if "--check" in sys.argv:
        sys.exit(text != current(text))
    PAGE.write_text(current(text))


if __name__ == "__main__":
    main()
