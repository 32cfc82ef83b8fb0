"""The audit fails a task if one question is not legible, and says so if that was not measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import pytest

from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.legibility import legibility_finding
from wmspec.dataset.audit.model import Finding
from wmspec.runtime.questions.legibility.bounds import entry


def audited(rows: Sequence[dict[str, float] | None]) -> Finding:
    """The finding on a question with these measures, one row each; None without the column."""
    cases = []
    for index, measures in enumerate(rows):
        column = None if measures is None else [asdict(entry(name, value)) for name, value in measures.items()]
        cases.append(Case({"index": index, "engine": "mujoco", "legibility": column}, (), ()))
    return legibility_finding(Unit("t", tuple(cases), ("mujoco",)))


LEGIBLE = {"step": 12.0, "path": 40.0, "number": 30.0}


@pytest.mark.parametrize(
    ("rows", "verdict", "words"),
    [
        ([LEGIBLE] * 3, "holds", "3 of 3 questions are legible (100 %)"),
        ([{}] * 3, "holds", "3 of 3"),
        ([LEGIBLE] * 999 + [{**LEGIBLE, "step": 11.9}], "fails", "999 of 1,000 questions are legible (99 %)"),
        ([LEGIBLE, {"number": 31.0}], "fails", "`number` in 1 (worst 31, at most 30)"),
        ([LEGIBLE, {"step": 1.5}, {"step": 3.0}], "fails", "`step` in 2 (worst 1.5, at least 12 px)"),
        ([None] * 3, "reported", "not measured"),
    ],
)
def test_the_verdict(rows: list[dict[str, float] | None], verdict: str, words: str) -> None:
    found = audited(rows)
    assert found.verdict == verdict
    assert words in found.what
