"""s-RE of raters with known weaknesses, over the designs of the catalogue."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("statsmodels")

from tests.language.specs import task_of
from tests.worlds.test_catalogue import CATALOGUE
from wmspec.compile.design.design import Design
from wmspec.compile.design.dimension import dimension
from wmspec.eval.report.entanglement import Entanglement, entanglement
from wmspec.eval.report.intervals import seeded_generator
from wmspec.eval.report.questions import Questions
from wmspec.eval.report.replies import replies
from wmspec.runtime.questions.ask import groups

#: Of about 15 factors, at most two are significant by chance: more are in one of 2,000 tasks.
CHANCE = 2
QUICK = ("collide", "color", "drive", "count")
TASKS = [path if path.stem in QUICK else pytest.param(path, marks=pytest.mark.slow) for path in CATALOGUE]


def results(path: Path, weak: frozenset[int], count: int = 400) -> tuple[Entanglement, ...]:
    """s-RE of a rater who is right in 30 % at some levels of a factor about colour, and else in 90 %."""
    spec = task_of(path)
    design = Design(spec, 3)
    instances = [design[i] for i in sorted(design.sample(count))]
    about = {factor.name: dimension(spec, factor) for factor in spec.factors}
    names = list(instances[0].factors)
    colored = max((n for n in names if about[n] == "color"), key=lambda n: len({i.factors[n] for i in instances}))
    levels = sorted({i.factors[colored] for i in instances}, key=str)
    ids = pd.Index([f"{spec.name}/{i.index}" for i in instances], name="id")
    table = pd.DataFrame(
        {"task": spec.name, "question": 0, "engine": "mujoco", "truth": "", "difference": np.nan, "query": False}, ids
    )
    known = Questions(
        table,
        {spec.name: pd.DataFrame([i.factors for i in instances], ids).astype(object)},
        {spec.name: pd.DataFrame([groups(i) for i in instances], ids)},
        {spec.name: about},
    )
    random = seeded_generator("catalogue", spec.name)
    chances = [0.3 if levels.index(i.factors[colored]) in weak else 0.9 for i in instances]
    answered = pd.DataFrame({
        "id": ids, "task": spec.name, "dimension": spec.dimension, "question_name": "", "engine": "mujoco",
        "index": [i.index for i in instances], "group": [f"{spec.name}/{i.block}" for i in instances],
        "model": "weak", "prompt": "default", "ablation": "", "permutation": 0, "sample": 0,
        "order": [[0, 1]] * len(ids), "right": random.random(len(ids)) < chances, "status": "answered",
    })  # fmt: skip
    return entanglement(replies(answered, known))


def beyond(found: Entanglement) -> float:
    """How far s-RE is beyond its null band, in widths of the band."""
    return (found.value - found.bound) / max(found.bound - found.least, 1e-9)


def significant(found: Iterable[Entanglement]) -> int:
    """How many factors have an s-RE that shuffled levels reach in less than 1 %."""
    return sum(each.p < 0.01 for each in found)


@pytest.mark.parametrize("path", TASKS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_a_weakness_for_certain_colors_appears_under_color_alone(path: Path) -> None:
    found = results(path, frozenset({0, 2, 4}))
    color = max((e for e in found if e.dimension == "color"), key=beyond)
    others = [e for e in found if e.dimension != "color"]
    assert color.low is not None
    assert color.low > color.bound
    assert {e.dimension for e in others} >= {"position"}
    assert all(beyond(e) < beyond(color) / 3 for e in others), "it would be mistaken for another weakness"
    assert significant(others) <= CHANCE


def test_without_a_weakness_nothing_appears() -> None:
    assert significant(results(CATALOGUE[0], frozenset())) <= CHANCE
