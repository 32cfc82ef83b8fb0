"""The environment for reinforcement learning: fresh questions, rewards by the reader of replies, and a learner."""

from __future__ import annotations

import re
from collections import Counter
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

import wmspec
from wmspec.dataset.build.splits import Split
from wmspec.eval.replies import mark

SPEC = """use tabletop

task wider : perception.vision.size {
  factor wider in [left, right]
  factor color in [red, blue, green]
  factor ratio in [1.4, 2.2]
  nuisance width in 6 cm .. 7 cm
  holdout color in [green]
  design groups of 4 { cross: wider  turn: [color, ratio] }

  let left_width  = if wider == left then width * ratio else width
  let right_width = if wider == left then width else width * ratio

  object a { shape: box  size: (left_width, 5 cm, 8 cm)   color: color  on: table at (-12 cm, 0) }
  object b { shape: box  size: (right_width, 5 cm, 8 cm)  color: color  on: table at (12 cm, 0) }

  observe front at [0 s]

  question "Which box is wider?" {
    options    [left, right]
    answer     if left_width > right_width then left else right
    difference ratio
  }
}
"""


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("environment") / "wider.wms"
    path.write_text(SPEC)
    return path


def test_rewards_are_scores_and_options_are_shuffled(spec: Path) -> None:
    env = wmspec.environment(spec, engine="mujoco", seed=3)
    problems = env.sample(24)
    answers = Counter(problem.answer for problem in problems)
    assert min(answers["A"], answers["B"]) >= 5
    for problem in problems:
        other = "B" if problem.answer == "A" else "A"
        assert problem.reward(problem.answer) == 1.0
        assert problem.reward(f"I think it is {other}. So {problem.answer}.") == 1.0
        assert problem.reward(other) == problem.reward("A or B") == problem.reward("") == 0.0
        assert problem.mark(f"it may be {problem.answer} or", "length").outcome == "truncated"
        assert problem.mark(problem.answer) == mark(problem.answer, **problem.truth)
        text = "\n".join(part["text"] for part in problem.chat[-1]["content"] if part["type"] == "text")
        shown = dict(re.findall(r"(?m)^([AB])\. (.*)$", text))
        assert problem.levels["wider"] in shown[problem.answer]
        pictures = sum(part["type"] == "image" for part in problem.chat[-1]["content"])
        assert len(problem.images) == pictures == sum("image_url" in part for part in problem.messages[-1]["content"])


def test_a_stream_is_endless_fresh_and_reproducible(spec: Path) -> None:
    env = wmspec.environment(spec, engine="mujoco", seed=3)
    ids = [problem.id for problem in islice(env, len(env.task) + 4)]
    assert len(set(ids)) == len(ids), "the design is drawn again with another seed"
    assert ids[:4] == [problem.id for problem in wmspec.environment(spec, engine="mujoco", seed=3).sample(4)]
    assert env.reset(seed=3).id == ids[0]


def test_an_episode_is_one_question(spec: Path) -> None:
    env = wmspec.environment(spec, engine="mujoco")
    with pytest.raises(wmspec.WmsError, match="call `reset` first"):
        env.step("A")
    problem = env.reset()
    reward, marked = env.step(problem.answer)
    assert (reward, marked.outcome) == (1.0, "answered")
    with pytest.raises(wmspec.WmsError):
        env.step("A")


def test_instances_are_chosen_by_difficulty_levels_and_split(spec: Path) -> None:
    hard = wmspec.environment(spec, engine="mujoco", difficulty=(0.5, 1)).sample(6)
    assert {problem.levels["ratio"] for problem in hard} == {1.4}
    easy = wmspec.environment(spec, engine="mujoco", difficulty=(0, 0.5)).sample(6)
    assert {problem.levels["ratio"] for problem in easy} == {2.2}
    red = wmspec.environment(spec, engine="mujoco", levels={"color": ["red"]}).sample(4)
    assert {problem.levels["color"] for problem in red} == {"red"}
    train = wmspec.environment(spec, engine="mujoco", split="train")
    inside = Split("train").contains(train.task.design)
    problems = train.sample(4)
    assert all(problem.levels["color"] != "green" for problem in problems)
    assert all(inside(problem.ask.question.index) for problem in problems)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"levels": {"ratio": [1.5]}}, "1.5 is no level of `ratio`, which has 1.4, 2.2"),
        ({"levels": {"rato": [1.4]}}, "did you mean `ratio`"),
        ({"difficulty": (1, 0)}, "two numbers from 0"),
        ({"split": "tset"}, "did you mean `test`"),
        ({"split": "train", "levels": {"color": ["green"]}}, "no instance has this split"),
        ({"shares": "train=100"}, "belong to --split"),
    ],
)
def test_options_that_do_not_fit_are_errors(spec: Path, options: dict[str, object], message: str) -> None:
    with pytest.raises(wmspec.WmsError, match=message):
        wmspec.environment(spec, engine="mujoco", **options)


def test_a_task_without_a_known_difference_has_no_difficulty(tmp_path: Path) -> None:
    (tmp_path / "t.wms").write_text(SPEC.replace("    difference ratio\n", ""))
    with pytest.raises(wmspec.WmsError, match="no `difference` that follows"):
        wmspec.environment(tmp_path / "t.wms", engine="mujoco", difficulty=(0, 0.5))


@pytest.mark.slow
def test_a_learner_is_rewarded_more_and_more(spec: Path) -> None:
    """REINFORCE with two weights: one for how much wider the left box looks, one for nothing."""
    env, random, weights = wmspec.environment(spec, engine="mujoco", seed=1), np.random.default_rng(0), np.zeros(2)
    rewards = []
    for problem in islice(env, 200):
        pixels = np.asarray(problem.images[0], dtype=float)
        saturated = np.ptp(pixels, axis=2) > 80
        halves = np.split(saturated.any(0), 2)
        look = np.array([(halves[0].sum() - halves[1].sum()) / 20.0, random.normal()])
        text = "\n".join(part["text"] for part in problem.chat[-1]["content"] if part["type"] == "text")
        labels = {words: label for label, words in re.findall(r"(?m)^([AB])\. (?:the )?(left|right)", text)}
        left = random.random() < 1 / (1 + np.exp(-weights @ look))
        reward = problem.reward(labels["left" if left else "right"])
        chosen = 1.0 if left else -1.0
        weights += 0.5 * (reward - 0.5) * chosen * look
        rewards.append(reward)
    assert np.mean(rewards[:20]) < 0.95
    assert np.mean(rewards[-100:]) > 0.9
    assert weights[0] > 3 * abs(weights[1])
