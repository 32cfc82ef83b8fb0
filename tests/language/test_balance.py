"""Balanced answers: which draws of the groups of a lap are kept, and what can be balanced."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import cache
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import wmspec
from tests.examples import examples
from wmspec.compile.design.design import Design
from wmspec.core.limits import MAX_DRAWS
from wmspec.core.rng import bits
from wmspec.lang.check.ir.ir import Plan
from wmspec.runtime.questions.balance import balanced_batch, pick_assignment
from wmspec.runtime.questions.kinds.labels import LabelAnswer
from wmspec.runtime.questions.model import Option, QuestionRow, Rejected

SPEC = """
use tabletop
task t : custom {{
  factor   tone in [red, blue]
  factor   wood in [oak, walnut, slate]
  nuisance pace in 0.3 m/s .. 0.9 m/s
  design groups of {count} {{ {plan} }}
  object block {{ shape: cube  size: 6 cm  color: tone  on: table at (-25 cm, 0) }}
  object other {{ shape: cube  size: 6 cm  color: wood  on: table at (25 cm, 0) }}
  action push = launch(block, direction: right, speed: pace) at 0.1 s
  horizon 0.6 s
  observe front at [0 s]
  question far "Where is the block?" {{ {question} }}
}}
"""
LABELS = 'options ["a", "b", "c"] answer if position(block).x < -20 cm then "a" else "b"'


def spec(plan: str = "cross: tone  balance: far", question: str = LABELS, count: int = 12) -> str:
    return SPEC.format(plan=plan, question=question, count=count)


@cache
def design(plan: str = "cross: tone  turn: wood  balance: far", count: int = 12, seed: int = 0) -> Design:
    design: Design = wmspec.load(text=spec(plan, count=count), seed=seed).design
    return design


# ---------------------------------------------------------------- the choice

COUNTS = st.lists(st.tuples(*[st.integers(0, 3)] * 3), min_size=1, max_size=4, unique=True)


@given(ways=st.lists(COUNTS, min_size=1, max_size=4), most=st.integers(1, 6))
def test_groups_come_together_whenever_they_can(ways: list[list[tuple[int, ...]]], most: int) -> None:
    chosen = pick_assignment([dict.fromkeys(way, None) for way in ways], most)
    fitting = [one for one in product(*ways) if all(sum(answer) <= most for answer in zip(*one, strict=True))]
    assert chosen in fitting if fitting else chosen is None


def drawn(answers: Mapping[str, float], seed: int) -> object:
    """Asks groups of which an answer is drawn at random for each member; of some, there is none."""

    def ask(design: Design, block: int) -> dict[int, list[QuestionRow | Rejected]]:
        return {index: [_answer(design, index, answers, seed)] for index in design.blocks.members(block)}

    return ask


def _answer(design: Design, index: int, answers: Mapping[str, float], seed: int) -> QuestionRow | Rejected:
    instance = design[index]
    share = bits(*instance.key, index, seed) / 2**64
    if share < 0.1:
        return Rejected("t", index, 0, "some", "unstable", "it would turn")
    reached = 0.1
    names = iter(answers)
    name = next(names)
    while share >= (reached := reached + 0.9 * answers[name]):
        name = next(names, name)
    options = tuple(Option("truth" if other == name else "label", other, other) for other in answers)
    at = list(answers).index(name)
    return QuestionRow(
        task="t", dimension="custom", question=0, seed=0, engine="some", renderer="some", text="",
        index=index, block=instance.block, context=(), options=options, answer=at, value=name, margin=None,
        factors=instance.factors, nuisances=instance.nuisances, groups={}, measured={},
        evidence=LabelAnswer(name, tuple(answers)), redrawn=instance.redrawn,
    )  # fmt: skip


SKEW = {"a": 0.7, "b": 0.2, "c": 0.1}


@examples(10, 30, deadline=None)
@given(seed=st.integers(0, 99), block=st.integers(0, 23))
def test_lap_balances_answers_over_its_groups(seed: int, block: int) -> None:
    task = design(count=24)
    lap = balanced_batch(task, block, drawn(SKEW, seed))  # type: ignore[arg-type]
    groups = task.balance_batch(block)
    assert block in groups
    assert sorted(lap.answers) == sorted(i for b in groups for i in task.blocks.members(b))
    answers = [answer for each in lap.answers.values() for answer in each]
    rows = [answer for answer in answers if isinstance(answer, QuestionRow)]
    if lap.kept:
        assert len(rows) == len(answers)
        assert {[r.value for r in rows].count(name) for name in SKEW} == {len(rows) // 3}
        assert len(groups) <= lap.executed <= MAX_DRAWS * len(groups)
        for group in groups:  # a group is kept as a whole: all members share their draws
            assert len({lap.answers[i][0].redrawn for i in task.blocks.members(group)}) == 1  # type: ignore[union-attr]
    else:
        assert not rows
        assert {answer.reason for answer in answers if isinstance(answer, Rejected)} <= {"balance", "unstable"}
    for other in groups:
        assert balanced_batch(task, other, drawn(SKEW, seed)) == lap  # type: ignore[arg-type]


def test_answer_that_never_occurs_is_reported_with_the_counts_of_the_others() -> None:
    lap = balanced_batch(design(), 0, drawn({"a": 0.5, "b": 0.5, "c": 0.0}, 1))  # type: ignore[arg-type]
    (first, *_) = [answer for each in lap.answers.values() for answer in each if answer.reason == "balance"]  # type: ignore[union-attr]
    assert isinstance(first, Rejected)
    assert first.detail.startswith(f"{3 * MAX_DRAWS} draws gave a ")
    assert ", c 0, rejected unstable " in first.detail
    assert first.detail.endswith("no combination has equally frequent answers")


# ---------------------------------------------------------------- the design


def test_the_laps_of_a_design_are_its_groups_each_once_with_the_same_crossed() -> None:
    task = design(plan="cross: tone  turn: wood  balance: far", count=20)
    laps = {task.balance_batch(block) for block in range(20)}
    assert sorted(block for lap in laps for block in lap) == list(range(20))
    assert all(len({task.blocks.crossed(block) for block in lap}) == 1 for lap in laps)
    two = design(plan="turn: [tone, wood]  balance: far", count=20)
    for block in range(18):
        assert two.blocks.crossed(block) in (("tone",), ("wood",))
        # One group of each turn in a round of two, and three rounds to a lap.
        assert sorted(other // 2 for other in two.balance_batch(block)) == [block // 6 * 3 + n for n in range(3)]
    assert [two.balance_batch(block) for block in (18, 19)] == [(18,), (19,)]


def test_no_place_in_a_lap_is_that_of_the_first_choice() -> None:
    """The first groups of a lap have the answers that come, the later ones those that are left."""
    firsts = [design(plan="turn: [tone, wood]  balance: far", count=18, seed=s).balance_batch(0)[0] for s in range(60)]
    assert min(Counter(first // 2 for first in firsts).values()) > 8


@settings(max_examples=30, deadline=None)
@given(index=st.integers(0, 20), times=st.integers(1, 9))
def test_redrawn_instance_keeps_factors_and_changes_nuisances(index: int, times: int) -> None:
    task = design()
    here, there = task[index], task.redrawn(times)[index]
    assert (there.factors, there.block, there.index, there.redrawn) == (here.factors, here.block, index, times)
    assert there.nuisances != here.nuisances
    assert there.nuisances != task.redrawn(times + 1)[index].nuisances
    assert task.redrawn(0)[index] == here == design(plan="cross: tone  turn: wood")[index]


@given(count=st.integers(1, 12))
def test_a_sample_has_whole_laps(count: int) -> None:
    task = design()
    sampled = set(task.sample(count))
    for index in sampled:
        lap = task.balance_batch(task.blocks.locate(index)[0])
        assert sampled >= {i for block in lap for i in task.blocks.members(block)}


def test_sample_sizes_are_the_groups_in_which_something_is_compared() -> None:
    sizes = design(plan="turn: [tone, wood]  balance: far", count=21).sample_sizes
    assert sizes == {"tone": 11, "wood": 10, "pace": 21}
    assert design(plan="cross: tone  balance: far").sample_sizes == {"tone": 12, "wood": 12, "pace": 12}


# ---------------------------------------------------------------- what cannot be balanced


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        (spec(plan="cross: tone  balance: fat"), "there is no question `fat`; did you mean `far`?"),
        (spec(plan="cross: tone  balance: [far]"), "there is no question `[far]`"),
        (spec(plan="cross: tone  balnce: far"), "groups have no `balnce`; did you mean `balance`?"),
        (spec(plan="balance: far"), "groups need crossed factors"),
        (
            spec(question="answer position(block).x within 2 cm"),
            "`far` has no list of answers that could come equally often; balance a question that is answered with one",
        ),
        (
            spec(question='options ["x", if tone == red then "a" else "b"] answer "x"'),
            "the options of `far` differ from instance to instance, so they cannot be counted",
        ),
        (
            spec().replace("nuisance pace in 0.3 m/s .. 0.9 m/s", "let pace = 1 m/s"),
            "nothing is drawn here, so a group comes out the same however often it is drawn",
        ),
        (
            spec().replace("design", "require tone == red or wood == oak\n  design"),
            "conditions make some groups larger than others, so that answers cannot be balanced among them",
        ),
    ],
)
def test_impossible_balance_is_reported_at_its_clause(text: str, reported: str) -> None:
    errors = [d for d in wmspec.diagnose(text=text).diagnostics if d.severity == "error"]
    assert len(errors) == 1, errors
    assert reported in str(errors[0])


def test_the_plan_is_part_of_the_checked_task() -> None:
    task = wmspec.load(text=spec())
    assert task.spec.plan == Plan(kind="groups", count=12, cross=("tone",), balance="far", place=task.spec.plan.place)
    with pytest.raises(wmspec.WmsError, match="spread over all its instances"):
        wmspec.load(text=spec().replace("groups of 12 { cross: tone  balance: far }", "latin of 12"))[0].redrawn(1)
