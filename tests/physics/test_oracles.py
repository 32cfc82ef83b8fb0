"""Each engine meets the bar of every oracle, and the page about them is written from the same table."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest

from tests.engines import ENGINES, installed
from tests.examples import slow_except
from tests.physics.oracles.table import ORACLES
from tools.oracles import rewritten

PAGE = Path(__file__).parents[2] / "docs/benchmarks/oracles.md"
SPECS = tuple(dict.fromkeys(oracle.spec for oracle in ORACLES))
LONG = {(spec, engine) for spec in ("bounce", "collide", "pusher", "stack") for engine in ENGINES}
LONG |= {(spec, "sapien") for spec in ("incline", "third", "tip")}


@pytest.mark.parametrize(("spec", "engine"), slow_except({*product(SPECS, ENGINES)} - LONG, product(SPECS, ENGINES)))
def test_an_engine_meets_its_bars(spec: str, engine: str) -> None:
    installed(engine)
    for oracle in ORACLES:
        if oracle.spec == spec:
            error = oracle.measure(engine)
            assert oracle.meets(engine, error), f"{oracle.what}: {error:.4g} {oracle.unit}, bar {oracle.bar(engine)}"


def test_the_page_has_every_oracle_and_bar() -> None:
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    head = next(line for line in lines if line.startswith("| spec |"))
    engines = [cell.split()[0] for cell in head.split("|")[5:-1]]
    assert set(ENGINES) <= set(engines)
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("| `")]
    assert [tuple(row[:4]) for row in rows] == [(f"`{o.spec}`", o.what, o.answer, o.unit) for o in ORACLES]
    for row, oracle in zip(rows, ORACLES, strict=True):
        for engine, cell in zip(engines, row[4:], strict=True):
            assert cell.endswith(f" / {oracle.bar(engine)}")
            assert "**" not in cell, f"{oracle.what} in {engine} is above its bar: {cell}"


def test_columns_of_engines_that_are_not_measured_stay() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert rewritten(page, ()) == page
