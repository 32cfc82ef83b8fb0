"""The prediction tasks of physics: closed sets of options, groups, four tiers, companion questions."""

from __future__ import annotations

from pathlib import Path

import pytest

import wmspec
from tests.engines import installed
from tests.language.specs import task_of
from wmspec.compile.design.depend import dependencies
from wmspec.lang.check.expressions.measured import is_measured
from wmspec.lang.check.ir.evaluate import subexpressions
from wmspec.lang.check.ir.ir import Choices, Expr, Interpolation, Question, Ref, TaskSpec, Value
from wmspec.lang.parse.files import catalogue_folders

FOLDER = next(folder for folder in catalogue_folders() if folder.name == "prediction")
PHYSICS = sorted(
    path for path in FOLDER.rglob("*.wms") if "use places" in path.read_text() and "orbit of" in path.read_text()
)


def test_there_are_the_papers_and_six_more() -> None:
    papers = {"slide", "drop", "collide", "two_balls"}
    assert {path.stem for path in PHYSICS} >= papers | {"roll", "support", "contain", "topple", "domino_row", "hidden"}


@pytest.mark.parametrize("path", PHYSICS, ids=lambda path: path.stem)
def test_groups_tiers_and_questions(path: Path) -> None:
    assert wmspec.load(path).groups >= 100
    task = task_of(path)
    assert task.name == path.stem
    foreseen, *seen = task.questions
    assert {question.name for question in seen} == {"seen_state", "seen_action"}
    assert len(foreseen.orbit) == 2, "a state and an action"
    assert foreseen.difference is not None
    strength = foreseen.difference.value
    assert isinstance(strength, Ref)
    tiers = next(factor for factor in task.factors if factor.name == strength.name)
    assert isinstance(tiers.domain, Choices)
    assert len(tiers.domain.values) == 4


@pytest.mark.parametrize("path", PHYSICS, ids=lambda path: path.stem)
def test_questions_ask_for_the_varied_factors_without_naming_them(path: Path) -> None:
    task = task_of(path)
    varied = {orbit.factor for orbit in task.questions[0].orbit}
    probed = [varied & decisive(task, question) for question in task.questions[1:]]
    assert all(probed), "about the mover, and not about something else"
    assert set().union(*probed) == varied
    for question in task.questions:
        inserted = [part.value for part in question.text if isinstance(part, Interpolation)]
        assert not varied & {value.name for value in inserted if isinstance(value, Ref)}


def decisive(task: TaskSpec, question: Question) -> set[str]:
    """The factors of the answer, and of what moves the objects that it measures."""
    depend = dependencies(task)
    factors = set(depend.expression(question.answer))
    if is_measured(task, question.answer):
        measured = named(question.answer)
        for action in (thing for thing in task.things if thing.kind == "action"):
            if measured & named(action.properties["object"].value):
                factors.update(*(depend.source(f"{action.name}.{name}") for name in action.properties))
    return factors


def named(expression: Expr) -> set[object]:
    """The names and words in an expression."""
    parts = list(subexpressions(expression))
    return {p.name for p in parts if isinstance(p, Ref)} | {p.value for p in parts if isinstance(p, Value)}


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("path", PHYSICS, ids=lambda path: path.stem)
def test_each_gives_questions(path: Path, tmp_path: Path) -> None:
    installed("mujoco")
    made = wmspec.generate(path, tmp_path / "out", backend="mujoco", per_task=40, size=256, workers=0)
    assert made.rows >= 0.9 * (made.rows + sum(made.rejected.values()))
