"""The conformance suite: its stages are plain USD, its answers are those of mechanics, scores tell engines apart."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from pxr import Usd

from tests.engines import ENGINES, installed
from wmspec.cli import main
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.conformance.build import body, cylinder, floor, stage
from wmspec.runtime.conformance.case import RATE
from wmspec.runtime.conformance.score import by_backend, by_traces, cases, chosen, scores
from wmspec.sim.usd import read

CASES = cases()
COUPLED = (
    "mimic_hoist",
    "mimic_counterweight",
    "mimic_gripper",
    "pendulum_jerked",
    "pendulum_conical",
    "nunchaku_thrown",
)


def opened(text: str) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().ImportFromString(text)
    return stage


def test_there_are_many_and_each_names_its_source() -> None:
    assert len(CASES) >= 40
    measures = [measure for case in CASES.values() for measure in case.measures]
    assert all(m.source and m.formula and m.tolerance >= 0 and np.isfinite(m.answer) for m in measures)


@pytest.mark.parametrize("name", CASES)
def test_stages_are_plain_usd_that_the_strict_read(name: str) -> None:
    text = CASES[name].stage
    assert "wms" not in text.lower()
    scene = read(opened(text))
    assert scene.duration == 0
    assert any(body.motion == "dynamic" for body in scene.bodies)


def test_cylinders_slide_stand_and_tip_on_their_ends_in_pybullet() -> None:
    installed("pybullet")
    names = ("slide_puck", "slide_standing_cylinder", "stand_cylinder_slope", "topple_cylinder")
    for score in scores("pybullet", by_backend("pybullet"), chosen(names)):
        assert score.passed, (score.measure.what, score.measured, score.refusal)


def test_a_thin_wall_holds_what_is_fast_in_mujoco() -> None:
    installed("mujoco")
    (score,) = scores("mujoco", by_backend("mujoco"), chosen(["thin_wall"]))
    assert score.passed, score.measured


def test_what_falls_on_what_rests_stays_there_in_sapien() -> None:
    installed("sapien")
    (score,) = scores("sapien", by_backend("sapien"), chosen(["drop_on_box"]))
    assert score.passed, score.measured


def test_cylinders_as_long_as_thick_are_balls_inside_in_sapien_unless_they_stand() -> None:
    installed("sapien")
    from wmspec.backends.sapien.physics import prepare

    def kinds(axis: str, length: float) -> list[str]:
        text = stage(floor(), body("can", cylinder(0.1, length, axis), (0, 0, 0.1)))
        whole, _ = prepare(replace(read(opened(text), strict=False), duration=0.1, rate=240))
        return [piece.kind for piece in whole.bodies[1].pieces]

    assert kinds("Y", 0.2) == kinds("Y", 0.4) == kinds("Z", 0.4) == ["cylinder", "capsule"]
    assert kinds("Z", 0.2) == kinds("Y", 0.1) == ["cylinder"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    "name", ["free_fall", "slide_box", "four_bar", "filtered_pair", "drive_critical", "units", *COUPLED]
)
def test_engines_pass_what_they_are_known_to_do(engine: str, name: str) -> None:
    installed(engine)
    for score in scores(engine, by_backend(engine), chosen([name])):
        assert score.passed, (score.measure.what, score.measured, score.refusal)


def test_another_engine_is_scored_by_its_traces(tmp_path: Path) -> None:
    t = np.arange(RATE + 1)[:, None] / RATE
    still = np.zeros((len(t), 1, 3))
    turn = np.tile([1.0, 0, 0, 0], (len(t), 1, 1))
    way = still + [0, 0, 10] + (t**2 * [0, 0, -9.81 / 2])[:, None]
    ball = {"bodies": ["/World/ball"], "orientation": turn, "linear_velocity": still, "angular_velocity": still}
    np.savez(tmp_path / "free_fall.npz", position=way, **ball)  # type: ignore[arg-type]
    np.savez(tmp_path / "projectile.npz", position=way, **ball)  # type: ignore[arg-type]
    np.savez(tmp_path / "spin.npz", refusal="no tops here")
    command = ["conform", "free_fall", "projectile", "spin", "-b", "none", "--traces", f"mine={tmp_path}", "--json"]
    told = CliRunner().invoke(main, command)
    assert told.exit_code == 1
    fall, thrown, spin = json.loads(told.output)
    assert fall["passed"]
    assert thrown["error"] == pytest.approx(1e3 * np.hypot(1.5, np.hypot(0.5, 3.0)), rel=0.2)
    assert not thrown["passed"]
    assert "no tops here" in spin["refusal"]


def test_what_is_no_trace_is_refused_by_file(tmp_path: Path) -> None:
    np.savez(tmp_path / "free_fall.npz", bodies=["ball"], position=np.zeros((2, 1, 3)))
    with pytest.raises(WmsError, match=r"free_fall\.npz"):
        by_traces(tmp_path)(CASES["free_fall"])
    with pytest.raises(WmsError, match="did you mean `free_fall`"):
        chosen(["freefall"])


def test_the_stages_are_written_for_others(tmp_path: Path) -> None:
    assert CliRunner().invoke(main, ["conform", "--write", str(tmp_path)]).exit_code == 0
    index = json.loads((tmp_path / "cases.json").read_text())
    assert set(index) == set(CASES)
    assert all((tmp_path / about["stage"]).is_file() for about in index.values())
