"""What a perfect eye reads off pictures, and which options it strikes out before it guesses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from wmspec.core.space import Quaternion, from_ypr, multiply
from wmspec.dataset.audit import state
from wmspec.dataset.audit.cases import Case

ANGLES = st.floats(-3.1, 3.1)


def thing(picture: int, name: str, look: str, across: float) -> dict[str, Any]:
    where = {"across": across, "down": 0.5, "share": 0.1, "red": 0.0, "green": 0.0, "blue": 0.0}
    turn = {"qw": 1.0, "qx": 0.0, "qy": 0.0, "qz": 0.0}
    return {"picture": picture, "name": name, "look": look, "asked": True} | where | turn


def pictured(kinds: Sequence[str]) -> Case:
    return Case({"option_kind": list(kinds), "answer": kinds.index("truth")}, (), (b"",) * len(kinds))


def test_of_a_closed_set_what_begins_in_another_state_is_struck_out() -> None:
    (struck,) = state.eliminated_options([pictured(["both", "truth", "action", "state"])])
    assert struck.tolist() == [True, False, False, True]
    (kept,) = state.eliminated_options([pictured(["state", "truth", "both", "state"])])  # all that differs is the state
    assert not kept.any()


def test_requested_object_comes_first_under_any_name() -> None:
    def questions(color: str) -> Case:
        seen = [thing(p, n, f"{n} ball", a) for p in (0, 1) for n, a in (("blue", 0.2 + 0.1 * p), ("red", 0.7))]
        row = {
            "context_objects": seen,
            "text": f"A red and a blue ball move. Which path does the {color} one take?",
        }
        return Case(row, (b"", b""), ())

    red, blue = state.question_states([questions("red"), questions("blue")], (0,))
    assert (red[0], blue[0]) == (0.7, 0.2)


def test_probe_sees_displacements_between_two_pictures() -> None:
    seen = [thing(0, "ball", "red ball", 0.2), thing(1, "ball", "red ball", 0.5)]
    (row,) = state.question_states([Case({"context_objects": seen, "text": "Where to?"}, (b"", b""), ())], (0, 1))
    assert np.allclose(row[-3:], [0.3, 0.0, 0.3])


def test_unseen_change_is_no_evidence() -> None:
    def trembling(turn: float) -> Case:
        seen = thing(0, "ball", "red ball", 0.2 + turn / 10) | {"qy": turn}
        return Case({"context_objects": [seen], "text": "How fast?"}, (b"",), ())

    still, trembled, turned = state.question_states([trembling(t) for t in (0.0, 1e-4, 0.1)], (0,))
    assert np.array_equal(still, trembled)
    assert not np.array_equal(still, turned)


def test_how_a_plain_ball_is_turned_is_no_evidence() -> None:
    def features(look: str) -> list[list[float]]:
        turned = [thing(0, "ball", look, 0.2) | {"qw": w, "qy": np.sqrt(1 - w * w)} for w in (1.0, 0.6)]
        cases = [Case({"context_objects": [seen], "text": ""}, (b"",), ()) for seen in turned]
        rows: list[list[float]] = state.question_states(cases, (0,)).tolist()
        return rows

    plain, grained = features("red sphere plastic"), features("red sphere wood")
    assert plain[0] == plain[1]
    assert grained[0] != grained[1]


@given(ANGLES, ANGLES, ANGLES)
def test_sign_of_a_quaternion_is_no_evidence(yaw: float, pitch: float, roll: float) -> None:
    turn = from_ypr(yaw, pitch, roll)
    negative = (-turn[0], -turn[1], -turn[2], -turn[3])
    assert not differ("red cube wood", turn, negative)


def differ(look: str, a: Quaternion, b: Quaternion) -> bool:
    """Whether the features of an object in two orientations differ by more than rounding."""
    turned = [thing(0, "it", look, 0.2) | dict(zip(("qw", "qx", "qy", "qz"), turn, strict=True)) for turn in (a, b)]
    one, other = state.question_states([Case({"context_objects": [t], "text": ""}, (b"",), ()) for t in turned], (0,))
    return bool(np.abs(one - other).max() > 0.015)


@given(ANGLES, ANGLES, ANGLES)
def test_a_turn_about_its_axis_does_not_show_on_what_is_round_and_plain(lean: float, way: float, spin: float) -> None:
    leant = from_ypr(way, lean)
    spun = multiply(leant, from_ypr(spin))
    assert not differ("red plastic cylinder", leant, spun)
    assert not differ("red plastic sphere", leant, spun)


def test_it_shows_on_what_has_a_pattern_or_edges_and_leaning_shows_on_a_cylinder() -> None:
    upright, spun, leant = from_ypr(0.0), from_ypr(0.7), from_ypr(0.0, 0.7)
    assert differ("red wood cylinder", upright, spun)
    assert differ("red plastic cube", upright, spun)
    assert differ("red plastic cylinder", upright, leant)
    assert not differ("red plastic sphere", upright, leant)
