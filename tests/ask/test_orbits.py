"""Closed sets of options: the same set whichever member is true, each place once, whole groups or nothing."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.ask.asking import pair, spec_of
from wmspec.compile.design.design import Design
from wmspec.runtime.questions.ask import ask, closed_slot
from wmspec.runtime.questions.closed_sets import ask_complete, drop_incomplete_groups
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.kinds.pictures import PictureAnswer
from wmspec.runtime.questions.model import QuestionRow, Rejected

PUSHED = """
  factor load in [30 g called "light", 400 g called "heavy"]
  factor pace in [0.5 m/s called "slow", 1.4 m/s called "fast"]
  factor tone in [red, blue]
  design groups of 8 {{ cross: [load, pace] }}
  object crate {{ shape: cube    size: 6 cm  mass: load  color: tone  friction: 0.3  on: table at (0 cm, 0 cm) }}
  object ball {{ shape: sphere  size: 6 cm  mass: 100 g  color: yellow  on: table at (-16 cm, 0 cm) }}
  action push = launch(ball, direction: right, speed: pace) at 0.1 s
  horizon 1 s
  observe front at [0 s, 0.2 s]
  question "The {{tone}} cube is {{load}}. And then?" {{
    answer   frame(front, end)
    options  orbit of load, pace
    kinds    {{ shoved: displacement(crate) > 8 cm  held: true }}
    {more}
  }}
"""


def design(more: str = "distinct by 0.3 cm or 20 deg", groups: int = 8) -> Design:
    body = PUSHED.format(more=more).replace("groups of 8", f"groups of {groups}")
    return Design(spec_of(body))


def rows(of: Design, block: int = 0) -> list[QuestionRow]:
    (found,) = zip(*(ask(of, index, pair()) for index in of.blocks.members(block)), strict=True)
    assert all(isinstance(row, QuestionRow) for row in found), found
    return [row for row in found if isinstance(row, QuestionRow)]


@pytest.mark.engine
def test_all_members_of_a_group_are_shown_the_same_options_in_the_same_order() -> None:
    members = rows(design())
    first = [option.picture for option in members[0].options]
    for row in members:
        for a, b in zip(row.options, first, strict=True):
            assert a.picture is not None
            assert b is not None
            assert np.array_equal(a.picture.rgb, b.rgb)
        assert [o.outcome for o in row.options] == [o.outcome for o in members[0].options]
    assert sorted(row.answer for row in members if row.answer is not None) == [0, 1, 2, 3]


@pytest.mark.engine
def test_an_option_is_what_it_differs_in_from_the_truth() -> None:
    for row in rows(design()):
        assert Counter(o.kind for o in row.options) == Counter(["truth", "state", "action", "both"])
        for option in row.options:
            if option.change is not None:
                made = [option.change, *([option.change.beside] if option.change.beside else [])]
                expected = [("state", "load"), ("action", "pace")]
                at = {"state": slice(0, 1), "action": slice(1, 2), "both": slice(0, 2)}[option.kind]
                assert [(change.kind, change.target) for change in made] == expected[at]
        load, pace = row.levels["load"], row.levels["pace"]
        assert load in row.text
        (state,) = (o.change for o in row.options if o.kind == "state")
        assert state is not None
        assert (state.before, state.after) == (load, {"light": "heavy", "heavy": "light"}[load])
        assert pace in ("slow", "fast")


@pytest.mark.engine
def test_siblings_are_executed_once() -> None:
    of, traces = design(), pair().traces
    rows(of)
    known = set(traces._traces._values)
    rows(of)
    assert set(traces._traces._values) == known
    assert len(known) <= 8 * 4  # every member and its nudge, whichever tests ran before


def test_groups_balance_places_of_options() -> None:
    of = design(groups=12)
    places = Counter()  # type: Counter[tuple[int, int, int]]
    for index in range(len(of)):
        slot = closed_slot(of, of[index], 0)
        order = slot.order(0, 4)
        assert sorted(order) == [0, 1, 2, 3]
        assert order.index(0) == slot.places[slot.member]
        places[of[index].block // 4, slot.member, order.index(0)] += 1
    assert set(places.values()) == {1}
    assert len(places) == 3 * 4 * 4
    orders = {closed_slot(of, of[4 * block], 0).places for block in range(12)}
    assert len(orders) > 4


def test_a_member_that_fails_rejects_its_group() -> None:
    spec = design().spec
    kept: Any = [_Row()]
    broken = Rejected("t", 2, 0, "a", "unseen", "the box: 3 pixels")
    found = drop_incomplete_groups(spec, {1: kept, 2: [broken]})
    assert found[2] == [broken]
    assert found[1] == [Rejected("t", 1, 0, "a", "group", "instance 2 in a: unseen: the box: 3 pixels", "fill full")]
    assert drop_incomplete_groups(spec, {1: kept})[1] == kept
    opened = replace(spec, questions=(replace(spec.questions[0], orbit=()),))
    assert drop_incomplete_groups(opened, {1: kept, 2: [broken]})[1] == kept


class _Row:
    """As much of a row as is looked at."""

    task, index, question, engine, label = "t", 1, 0, "a", "fill full"


@pytest.mark.engine
def test_instance_has_the_questions_of_its_group() -> None:
    of = design("distinct by 0.3 cm  ensure displacement(crate) > 8 cm")
    reasons = {i: [getattr(a, "reason", "") for a in ask_complete(of, i, pair())] for i in of.blocks.members(0)}
    assert {reason for found in reasons.values() for reason in found} == {"ensure", "group"}


@pytest.mark.engine
def test_options_of_one_kind_are_alike_where_kinds_must_differ() -> None:
    (found,) = ask(design("distinct by kind"), 0, pair())
    assert isinstance(found, Rejected)
    assert found.reason == "alike"
    assert "both are of the kind `held`" in found.detail or "both are of the kind `shoved`" in found.detail


@pytest.mark.engine
def test_outcome_of_no_kind_gives_no_question() -> None:
    of = design("distinct by 0.3 cm")
    question = replace(of.spec.questions[0], kinds=of.spec.questions[0].kinds[:1])
    (found,) = ask(Design(replace(of.spec, questions=(question,))), 0, pair())
    assert isinstance(found, Rejected)
    assert (found.reason, found.detail.partition(" matches ")[2]) == ("ensure", "none of the kinds shoved")


# ---------------------------------------------------------------- turns


def outcome(turn: float) -> np.ndarray:
    return np.array([[0.0, 0.0, 0.0, np.cos(turn / 2), np.sin(turn / 2), 0.0, 0.0]])


def answer(*turns: float, axis: float = np.nan, lever: float = 0.1) -> PictureAnswer:
    names = ("truth", *(f"other{i}" for i in range(1, len(turns))))
    stacked = np.stack([outcome(turn) for turn in turns])
    return PictureAnswer("front", 1.0, names, ("bar",), stacked, ("",) * len(turns), np.full((1, 3), axis), lever)


@pytest.mark.parametrize("lever", [0.0, 0.1])
def test_turn_decides_if_options_differ_in_it_alone(lever: float) -> None:
    mine, other = answer(0.0, 0.6, lever=lever), answer(0.5, 0.1, lever=lever)
    assert KINDS["pictures"].picked(mine, other) == "other1"
    assert KINDS["pictures"].picked(mine, answer(0.1, 0.5, lever=lever)) == "truth"


def test_invisible_turn_is_ignored() -> None:
    ball = answer(0.0, 0.6, axis=0.0)
    assert ball.distance(ball.outcomes[0], ball.outcomes[1]) == 0
    bar = answer(0.0, 0.6)
    assert bar.distance(bar.outcomes[0], bar.outcomes[1]) == pytest.approx(0.06)


TIPPED = """
  factor lean in [0 deg, 60 deg]
  factor pace in [0.1, 0.2] m/s
  object bar {{ shape: box  size: (20 cm, 3 cm, 3 cm)  yaw: lean  on: table at (0 cm, 0 cm) }}
  action go = launch(bar, direction: right, speed: 1 cm/s) at 0.1 s
  horizon 0.5 s
  observe front at [0 s, 0.2 s]
  question "And then?" {{ answer frame(front, end)  counterfactual each other lean  distinct by {by} }}
"""


@pytest.mark.engine
@pytest.mark.parametrize(("by", "kept"), [("5 cm", False), ("5 cm or 20 deg", True), ("5 cm or 80 deg", False)])
def test_large_enough_turn_distinguishes_options(by: str, kept: bool) -> None:
    (found,) = ask(Design(spec_of(TIPPED.format(by=by))), 0, pair())
    assert isinstance(found, QuestionRow) == kept, found
    if isinstance(found, Rejected):
        assert found.reason == "alike"
        assert ("rotated by 60°" in found.detail) == ("deg" in by)


# ---------------------------------------------------------------- each other level, and an action more


EACH = """
  factor pace in [0.2, 0.5, 0.9] m/s
  object ball {{ shape: sphere  size: 6 cm  on: table at (-16 cm, 0 cm) }}
  action push = launch(ball, direction: right, speed: pace) at 0.1 s
  horizon 1 s
  observe front at [0 s, 0.2 s]
  question "And then?" {{ answer frame(front, end)  {change} }}
"""


def names(change: str) -> list[list[tuple[str, str]]]:
    of = Design(spec_of(EACH.format(change=change)))
    found = [ask(of, index, pair())[0] for index in range(3)]
    answered = sorted((row for row in found if isinstance(row, QuestionRow)), key=lambda row: str(row.factors["pace"]))
    return [sorted((o.kind, o.name) for o in row.options) for row in answered]


@pytest.mark.engine
@pytest.mark.parametrize("change", ["counterfactual each other pace", "counterfactual each other push.speed"])
def test_each_other_level_is_a_counterfactual_named_after_it(change: str) -> None:
    levels = ["pace_20_cm_s", "pace_50_cm_s", "pace_90_cm_s"]
    expected = [
        sorted([("truth", "truth"), *(("counterfactual", other) for other in levels if other != level)])
        for level in levels
    ]
    assert names(change) == expected


@pytest.mark.engine
def test_added_action_starts_during_the_episode() -> None:
    back = "counterfactual back {{ add launch(ball, direction: left, speed: 0.9 m/s) at 0.5 s }}"
    of = Design(spec_of(EACH.format(change=back.replace("{{", "{").replace("}}", "}"))))
    (found,) = ask(of, next(i.index for i in of if i.factors["pace"] == 0.9), pair())
    assert isinstance(found, QuestionRow), found
    evidence = found.evidence
    assert isinstance(evidence, PictureAnswer)
    true, other = evidence.outcomes[:, 0, 0]
    assert true - other > 0.3
    (change,) = (o.change for o in found.options if o.change)
    assert (change.kind, change.target) == ("add", "back")
