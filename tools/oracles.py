"""Measure every engine against analytic answers and write docs/benchmarks/oracles.md. Takes a minute or two.

python -m tools.oracles
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.engines import ENGINES
from tests.physics.oracles.table import ORACLES, Oracle
from tools.reference import table
from wmspec.runtime.engines.registry import engine_version

PAGE = Path(__file__).parent.parent / "docs/benchmarks/oracles.md"
MARK = "<!-- measured -->\n"
SPECS = "tests/physics/oracles"


def measured() -> Iterator[str]:
    """Yield the lines of the tables."""
    engines = [f"{name} {engine_version(name)}" for name in ENGINES]
    yield from table(("scene", "what", "analytic", "unit", *engines), (row(oracle) for oracle in ORACLES))


def row(oracle: Oracle) -> tuple[str, ...]:
    """Return an oracle with the errors of each engine."""
    return f"`{oracle.spec}`", oracle.what, oracle.answer, oracle.unit, *(cell(oracle, engine) for engine in ENGINES)


def cell(oracle: Oracle, engine: str) -> str:
    """Return the error and its bound; bold if the engine exceeds it."""
    error, bar = oracle.measure(engine), oracle.bar(engine)
    text = f"{error:.{len(bar.partition('.')[2]) + 1}f}"
    return f"{text if oracle.meets(engine, error) else f'**{text}**'} / {bar}"


def main() -> None:
    """Rewrite the page."""
    head, mark, _ = PAGE.read_text(encoding="utf-8").partition(MARK)
    PAGE.write_text(head + mark + "\n" + "\n".join(measured()), encoding="utf-8")


if __name__ == "__main__":
    main()
