"""Measure engines against analytic answers and write their columns of docs/benchmarks/oracles.md.

python -m tools.oracles [ENGINE]...

Without names it measures the engines that wmspec brings, which takes a few minutes of processor time; Newton takes half
an hour. Columns of other engines stay.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from tests.engines import ENGINES
from tests.physics.oracles.table import ORACLES, Oracle
from tools.reference import table
from wmspec.runtime.engines.registry import engine_version

PAGE = Path(__file__).parent.parent / "docs/benchmarks/oracles.md"
MARK = "<!-- measured -->\n"
NOT_MEASURED = "—"

#: Engine and version -> spec and what is compared -> error and bar.
Columns = dict[str, dict[tuple[str, str], str]]


def rewritten(page: str, engines: Sequence[str]) -> str:
    """Return the page with the columns of `engines` measured now and those of other engines as they are."""
    head, mark, text = page.partition(MARK)
    columns = {name: cells for name, cells in read(text).items() if name.partition(" ")[0] not in engines}
    for engine in engines:
        columns[f"{engine} {engine_version(engine)}"] = {key(oracle): cell(oracle, engine) for oracle in ORACLES}
    ordered = sorted(columns, key=lambda name: (name.partition(" ")[0] not in ENGINES, name))
    return head + mark + "\n" + "\n".join(lines({name: columns[name] for name in ordered}))


def read(text: str) -> Columns:
    """Return the columns of a written table."""
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    names = rows[0][4:] if rows else []
    return {name: {(row[0], row[1]): row[4 + i] for row in rows[1:]} for i, name in enumerate(names)}


def lines(columns: Columns) -> Iterator[str]:
    """Yield the lines of the table."""
    rows = ((*key(o), o.answer, o.unit, *(of.get(key(o), NOT_MEASURED) for of in columns.values())) for o in ORACLES)
    yield from table(("spec", "quantity", "analytic answer", "unit", *columns), rows)


def key(oracle: Oracle) -> tuple[str, str]:
    """Return the first two cells of a row."""
    return f"`{oracle.spec}`", oracle.what


def cell(oracle: Oracle, engine: str) -> str:
    """Return the error and its bound; bold if the engine exceeds it."""
    error, bar = oracle.measure(engine), oracle.bar(engine)
    print(f"{engine}, {oracle.spec}: {oracle.what}: {error:.3g} {oracle.unit}", file=sys.stderr, flush=True)
    text = f"{error:.{len(bar.partition('.')[2]) + 1}f}"
    return f"{text if oracle.meets(engine, error) else f'**{text}**'} / {bar}"


def main() -> None:
    """Rewrite the page."""
    PAGE.write_text(rewritten(PAGE.read_text(encoding="utf-8"), sys.argv[1:] or ENGINES), encoding="utf-8")


if __name__ == "__main__":
    main()
