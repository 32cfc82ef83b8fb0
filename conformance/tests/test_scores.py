"""Scores of traces of a real engine, which are stored; traces that are wrong, and files that are no traces."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from usdphysics_conformance import (
    ConformanceError,
    all_cases,
    make_trace,
    read_trace,
    score_card,
    score_folder,
    score_text,
    score_trace,
    select_cases,
    write_refusal,
    write_trace,
)

DATA = Path(__file__).parent / "data"
#: Traces of MuJoCo, and what they scored when they were written.
STORED = json.loads((DATA / "mujoco.json").read_text())
STORED_CASES = select_cases(dict.fromkeys(record["case"] for record in STORED))
FALL = all_cases()["free_fall"]


def arrays() -> dict[str, Any]:
    """The arrays of the stored free fall."""
    return dict(np.load(DATA / "mujoco/free_fall.npz"))


def test_stored_traces_have_the_scores_that_they_had() -> None:
    records = [score.record() for score in score_folder("mujoco", DATA / "mujoco", STORED_CASES)]
    assert len(records) == len(STORED) == 9
    for record, stored in zip(records, STORED, strict=True):
        assert record == {**stored, **{key: pytest.approx(stored[key]) for key in ("answer", "measured", "error")}}
    assert {record["case"] for record in records if not record["passed"]} == {"cradle_touching"}


@pytest.mark.parametrize("gravity", [9.7, 9.92])
def test_a_free_fall_with_another_gravity_fails(gravity: float, tmp_path: Path) -> None:
    wrong = arrays()
    time = np.arange(len(wrong["position"])) / 240
    wrong["position"][:, 0, 2] = 10 - gravity * time**2 / 2
    np.savez(tmp_path / "free_fall.npz", **wrong)
    (score,) = score_folder("wrong", tmp_path, [FALL])
    assert score.measured == pytest.approx(gravity / 2)
    assert score.error == pytest.approx(abs(gravity - 9.81) / 2)
    assert not score.passed


def test_bodies_are_named_by_path_or_name_in_any_order_among_others() -> None:
    case = all_cases()["collide_equal"]
    with np.load(DATA / "mujoco/collide_equal.npz") as file:
        stored = dict(file)
    order = [1, 0, 0]
    mixed = {name: array[:, order] for name, array in stored.items() if name != "bodies"}
    names = [f"/World/{stored['bodies'][1]}", str(stored["bodies"][0]), "ground"]
    trace = make_trace(case, names, mixed)
    assert set(trace) == {"striker", "struck"}
    assert [score.passed for score in score_trace("mujoco", case, trace)] == [True, True]


def test_a_trace_is_the_same_after_writing_and_reading(tmp_path: Path) -> None:
    trace = read_trace(FALL, DATA / "mujoco/free_fall.npz")
    write_trace(tmp_path / "free_fall.npz", trace)
    again = read_trace(FALL, tmp_path / "free_fall.npz")
    assert np.array_equal(again["ball"].position, trace["ball"].position)
    assert np.array_equal(again["ball"].orientation, trace["ball"].orientation)


def test_event_that_never_happens_fails_with_a_reason() -> None:
    """A pendulum that does not swing has no period."""
    case = all_cases()["pendulum_60"]
    still = {name: np.zeros((case.samples, 1, 3)) for name in ("position", "linear_velocity", "angular_velocity")}
    trace = make_trace(case, ["bob"], {**still, "orientation": np.tile([1.0, 0, 0, 0], (case.samples, 1, 1))})
    (score,) = score_trace("still", case, trace)
    assert (score.passed, score.measured, score.error) == (False, None, None)
    assert score.refusal == "what is measured did not happen"


def test_a_refusal_and_a_missing_trace_fail_with_their_reasons(tmp_path: Path) -> None:
    write_refusal(tmp_path / "free_fall.npz", "no spheres here")
    fall, spin = score_folder("mine", tmp_path, select_cases(["free_fall", "spin"]))
    assert "no spheres here" in fall.refusal
    assert "there is no trace" in spin.refusal
    assert not fall.passed
    assert not spin.passed


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bodies": np.array(["cube"])}, "the body `ball` is missing; `bodies` names cube"),
        ({"bodies": None}, "the body `ball` is missing"),
        ({"orientation": None}, "the array `orientation` is missing"),
        ({"position": np.zeros((2, 1, 3))}, r"`position` has the shape \(2, 1, 3\), expected \(241, 1, 3\)"),
        ({"linear_velocity": np.full((241, 1, 3), np.nan)}, "`linear_velocity` has numbers that are not finite"),
        ({"orientation": np.zeros((241, 1, 4))}, "quaternions that are not of length 1"),
        ({"position": np.array("text")}, "free_fall.npz"),
    ],
)
def test_an_incomplete_trace_is_refused_with_what_it_lacks(
    change: dict[str, Any], message: str, tmp_path: Path
) -> None:
    changed = {name: array for name, array in {**arrays(), **change}.items() if array is not None}
    np.savez(tmp_path / "free_fall.npz", **changed)
    with pytest.raises(ConformanceError, match=message):
        read_trace(FALL, tmp_path / "free_fall.npz")


@pytest.mark.parametrize("content", [b"", b"text", b"PK\x03\x04 cut off", b"\x93NUMPY\x01\x00"])
def test_a_file_that_is_no_archive_is_refused_by_name(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "free_fall.npz").write_bytes(content)
    with pytest.raises(ConformanceError, match=r"free_fall\.npz: not an NPZ archive"):
        read_trace(FALL, tmp_path / "free_fall.npz")


def test_a_single_array_and_objects_that_run_code_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "free_fall.npz"
    with path.open("wb") as file:
        np.save(file, np.zeros(3))
    with pytest.raises(ConformanceError, match="not an NPZ archive"):
        read_trace(FALL, path)
    np.savez(path, bodies=np.array([{"an": "object"}], dtype=object))
    with pytest.raises(ConformanceError, match="not an NPZ archive"):
        read_trace(FALL, path)


def test_a_score_card_has_a_row_a_criterion_and_a_column_an_engine() -> None:
    worse = [{**record, "engine": "worse", "measured": None, "passed": False, "refusal": "no"} for record in STORED[:1]]
    lines = score_card([*STORED, *worse]).splitlines()
    assert lines[0] == "| case | measured quantity | exact answer | tolerance | unit | mujoco | worse |"
    assert len(lines) == 2 + 9 + 1
    assert lines[2] == "| `free_fall` | distance fallen in 1 s | 4.905 | 0.0005 | m | 4.905 | — |"
    assert lines[5].startswith("| `cradle_touching` |")
    assert "| **" in lines[5]
    assert lines[-1] == "|  | number of results within tolerance | 9 |  |  | 4 | 0 |"
    assert score_text(STORED).endswith("mujoco: 4 of 9")
