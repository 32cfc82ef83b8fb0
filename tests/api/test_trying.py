"""A trial makes instances through all gates, counts answers, and finds questions that are useless as they are."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from tests.engines import installed
from wmspec.api.trying import try_tasks
from wmspec.cli import main
from wmspec.dataset.build.answer_counts import AnswerCounts

SPEC = """
use tabletop
task t : custom {{
  factor wing in [-1, 1]
  factor deep in [1, 2, 3, 4]
  nuisance y in -5 cm .. 5 cm
  object a {{ shape: cube  size: 8 cm  color: red  on: table at (wing * 15 cm, y) }}
  object b {{ shape: cube  size: 8 cm  color: blue  on: table at (0, 3 cm * deep - 7 cm) }}
  observe front at [0 s]
  question "Where is the red cube, seen from the front?" {{
    options [left_of, right_of]
    answer  relation(a, b)
    {more}
  }}
}}
"""


@pytest.fixture
def spec(tmp_path: Path) -> Any:
    def write(more: str = "") -> Path:
        path = tmp_path / "t.wms"
        path.write_text(SPEC.format(more=more))
        return path

    return write


def check(path: Path, *options: str) -> Any:
    return CliRunner().invoke(main, ["check", str(path), "--try=8", *options])


def test_kept_questions_are_counted_by_answer(spec: Any) -> None:
    (task,) = try_tasks(spec(), 8)
    (question,) = task.questions
    assert (task.instances, question.kept, question.rejected) == (8, 8, {})
    assert sorted(question.answers.kept.values()) == [4, 4]
    assert {m.name for m in question.measures} >= {"place", "size"}
    assert task.passed


def test_answers_of_rejected_instances_are_known_and_a_gate_that_changes_them_is_reported(spec: Any) -> None:
    path = spec("ensure position(a).x > 0 cm")
    (task,) = try_tasks(path, 8)
    (question,) = task.questions
    assert question.rejected == {"ensure": 4}
    assert sum(question.answers.rejected.values()) == 4
    assert not question.answers.rejected.keys() & question.answers.kept.keys()
    assert "the gates change the share" in AnswerCounts({"x": 20, "y": 2}, {"y": 18}).shift


def test_a_question_without_instances_fails(spec: Any) -> None:
    outcome = check(spec("ensure position(a).x > 9 m"))
    assert outcome.exit_code == 2
    assert "no instance is kept" in outcome.stderr


def test_more_instances_are_tried_while_one_answer_may_be_chance(spec: Any, tmp_path: Path) -> None:
    """Half of the instances are rejected, so 4 of them leave the answer undecided."""
    text = spec("ensure position(a).x > 0 cm").read_text().replace("factor deep", "repeat 5\n  factor deep")
    (tmp_path / "t.wms").write_text(text)
    (task,) = try_tasks(tmp_path / "t.wms", 4)
    assert task.questions[0].answers.dominant == "to the right of it"
    assert 8 < task.instances <= 32
    assert not task.passed
    assert try_tasks(spec(), 1)[0].instances <= 8


def test_a_level_of_which_nothing_is_kept_is_named(spec: Any) -> None:
    """The answers stay balanced, so nothing else shows it."""
    path = spec("ensure position(b).y > -3 cm")
    (task,) = try_tasks(path, 8)
    assert task.questions[0].kept == 6
    assert task.questions[0].lost == ("deep = 1",)
    assert "no instance with deep = 1 is kept" in check(path).stderr
    assert try_tasks(spec(), 8)[0].questions[0].lost == ()


def test_one_answer_of_all_instances_that_exist_is_a_fault(spec: Any) -> None:
    path = spec()
    path.write_text(path.read_text().replace("factor wing in [-1, 1]", "let wing = 1"))
    (task,) = try_tasks(path, 8)
    assert task.questions[0].fault == "all 4 kept instances have the answer `to the right of it`"


def test_a_gate_has_a_remedy(spec: Any) -> None:
    assert "help: change the scene so that the condition holds" in check(spec("ensure position(a).x > 9 m")).stdout


def test_engines_are_compared_or_a_hint_names_the_option(spec: Any) -> None:
    for engine in ("mujoco", "pybullet"):
        installed(engine)
    assert "`--try -b all` finds disagreement" in check(spec()).stdout
    both = check(spec(), "-b", "mujoco,pybullet").stdout
    assert "instances in mujoco, pybullet" in both
    assert "finds disagreement" not in both


def test_json_has_the_trials(spec: Any) -> None:
    outcome = check(spec(), "--json")
    assert outcome.exit_code == 0
    (trial,) = json.loads(outcome.stdout)["trials"]
    assert trial["questions"][0]["kept"] == trial["instances"] == 8


@pytest.mark.parametrize(
    ("counts", "dominant"),
    [
        (AnswerCounts({"yes": 8}, {}, 4), "yes"),
        (AnswerCounts({"yes": 8}, {}, 2), ""),
        (AnswerCounts({"yes": 7}, {}, 7), ""),
        (AnswerCounts({"yes": 8, "no": 1}, {}, 9), ""),
    ],
)
def test_one_answer_dominates(counts: AnswerCounts, dominant: str) -> None:
    assert counts.dominant == dominant


def test_gates_that_treat_answers_alike_are_not_reported() -> None:
    assert AnswerCounts({"x": 40, "y": 38}, {"x": 9, "y": 11}).shift == ""
    assert AnswerCounts({"x": 3, "y": 0}, {"y": 2}).shift == ""  # too few to be no chance


def test_a_file_after_the_option_is_explained(spec: Any) -> None:
    outcome = CliRunner().invoke(main, ["check", "--try", str(spec())])
    assert outcome.exit_code == 2
    assert "write `--try` after the specs" in outcome.stderr
