"""The page of results of the catalogue, from the reports of several seeds."""

from __future__ import annotations

import datetime as dt
from typing import Any

import pytest

from tools.audits import measured, results


def report(seed: int, *summaries: dict[str, Any], findings: tuple[dict[str, Any], ...] = ()) -> dict[str, Any]:
    about = {
        "seed": seed,
        "size": [256, 256],
        "engines": ["mujoco"],
        "versions": {"mujoco": "4.0.0", "wmspec": "0.2.0"},
    }
    return {"about": about, "summaries": list(summaries), "findings": list(findings)}


def summary(task: str, verdict: str, above: float, *why: str) -> dict[str, Any]:
    numbers = {"questions": 1200, "groups": 30, "above": above, "least": 0.15, "stable": None}
    return {"task": task, "verdict": verdict, "why": list(why), "best": f"the best of {above:g}"} | numbers


def test_each_seed_has_a_column_and_the_worst_probe_of_all_counts() -> None:
    fault = {"check": "shortcut", "task": "roll q2", "verdict": "fails", "what": "from the text alone"}
    first = report(0, summary("roll", "holds", 0.02), summary("drop", "holds", 0.01))
    second = report(7, summary("roll", "fails", 0.2, "shortcut"), findings=(fault,))
    page = "\n".join(measured([second, first], dt.date(2026, 1, 2)))
    assert "2026-01-02 with mujoco 4.0.0, wmspec 0.2.0, at 256 px" in page
    assert "1 of 2 tasks pass" in page
    assert "| `drop` | pass, 1,200 |  | the best of 0.01 | 1 points | 15 points |" in page
    assert "| `roll` | pass, 1,200 | **fail**, 1,200 (shortcut) | the best of 0.2 | 20 points | 15 points |" in page
    assert "- `roll q2`, seed 7, shortcut: from the text alone" in page


def test_two_results_of_one_task_and_seed_are_an_error() -> None:
    with pytest.raises(ValueError, match=r"two reports have `roll` with seed 0"):
        results([report(0, summary("roll", "holds", 0.02))] * 2)
