"""`wmspec conformance`: the cases of usdphysics-conformance in the engines of wmspec."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from pxr import Usd

from tests.engines import ENGINES, installed
from usdphysics_conformance import all_cases, score_folder, select_cases
from usdphysics_conformance.stages import body, cylinder, floor, stage
from wmspec.cli import main
from wmspec.runtime.conformance import score_engine
from wmspec.sim.usd import read

CASES = all_cases()
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
    for score in score_engine("pybullet", select_cases(names)):
        assert score.passed, (score.criterion.description, score.measured, score.refusal)


def test_a_thin_wall_holds_what_is_fast_in_mujoco() -> None:
    installed("mujoco")
    (score,) = score_engine("mujoco", select_cases(["thin_wall"]))
    assert score.passed, score.measured


def test_body_that_falls_on_a_resting_one_stays_there_in_sapien() -> None:
    installed("sapien")
    (score,) = score_engine("sapien", select_cases(["drop_on_box"]))
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
    for score in score_engine(engine, select_cases([name])):
        assert score.passed, (score.criterion.description, score.measured, score.refusal)


def test_traces_are_kept_and_score_the_same(tmp_path: Path) -> None:
    installed("mujoco")
    command = ["conformance", "free_fall", "cradle_touching", "-b", "mujoco", "--json", "-o", str(tmp_path / "traces")]
    done = CliRunner().invoke(main, command)
    assert done.exit_code == 1, "touching balls do not leave one by one"
    kept = score_folder("mujoco", tmp_path / "traces/mujoco", select_cases(["free_fall", "cradle_touching"]))
    assert json.loads(done.stdout) == [score.record() for score in kept]
    assert CliRunner().invoke(main, command[:2] + command[3:]).exit_code == 0


def test_an_engine_that_refuses_a_case_fails_it_with_the_reason(tmp_path: Path) -> None:
    installed("mujoco")
    stage = CASES["free_fall"].stage.replace("(0, 0, -1)", "(0, 0, 0)").replace("9.81", "-inf")
    refused = replace(CASES["free_fall"], stage=stage.replace("double radius = 0.1", "double radius = -1"))
    (score,) = score_engine("mujoco", [refused], tmp_path)
    assert not score.passed
    assert "radius" in score.refusal
    (kept,) = score_folder("mujoco", tmp_path, [refused])
    assert score.refusal in kept.refusal


def test_an_unknown_case_and_a_missing_distribution_have_a_remedy() -> None:
    unknown = CliRunner().invoke(main, ["conformance", "freefall"])
    assert unknown.exit_code == 2
    assert "did you mean `free_fall`" in unknown.output
    hide = "import sys; sys.modules['usdphysics_conformance'] = None; from wmspec.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", hide, "conformance"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "pip install 'wmspec[conformance]'" in done.stderr
    assert "Traceback" not in done.stderr
