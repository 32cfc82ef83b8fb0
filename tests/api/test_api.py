"""The public API: what it names, what it gives, and that it says so where it cannot."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import wmspec
from tests.engines import installed
from wmspec import api

COLLIDE = Path("specs/prediction/mechanistic/collide.wms")
TWO = """
use room
task first : custom { object ball { shape: sphere  on: floor }  observe front at [0 s] }
task second : custom { object block { on: floor }  observe front at [0 s] }
"""
FALL = """
use room
task fall : custom {
  factor height in [20, 40] cm
  object ball { shape: sphere  size: 10 cm  color: red  on: floor }
  action let_go = drop(ball, height: height) at 0 s
  horizon 0.5 s
  observe front at [0 s, 0.2 s]
}
"""


def test_public_names() -> None:
    """Taking a name away, or adding one, is a promise to users: change this list with the changelog."""
    assert sorted(api.HOMES) == [
        *(
            "Agreement",
            "DatasetOptions",
            "Diagnosis",
            "Environment",
            "Episode",
            "Factor",
            "Instance",
            "InstanceQuestions",
        ),
        *("Problem", "RenderOptions", "SpecError"),
        *(
            "Task",
            "Track",
            "WmsError",
            "crosscheck",
            "diagnose",
            "environment",
            "generate",
            "load",
            "load_all",
            "load_episode",
        ),
        *("open_stage", "progress_bar", "register", "run"),
    ]
    for name in api.HOMES:
        public = getattr(wmspec, name)
        assert public is getattr(api, name)
        assert public.__doc__, f"{name} says nothing of itself"
        assert name in dir(wmspec)
    with pytest.raises(AttributeError, match="lod"):
        _ = wmspec.lod


def test_importing_it_imports_nothing_heavy() -> None:
    heavy = "numpy", "pxr", "lark", "pydantic", "click", "mujoco", "pybullet", "sapien"
    ask = f"import sys, wmspec; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


# ---------------------------------------------------------------- tasks


def test_a_task_is_the_sequence_of_its_instances() -> None:
    task = wmspec.load(COLLIDE)
    assert len(task) == 1728
    assert task.dimension == "prediction.mechanistic.physics"
    assert task.counterfactuals == ("light_slow", "light_fast", "heavy_slow", "heavy_fast")
    fill = next(factor for factor in task.factors if factor.name == "fill")
    assert (fill.name, fill.unit, fill.values, fill.nuisance) == ("fill", "kg", (0.15, 12), False)
    y = next(nuisance for nuisance in task.nuisances if nuisance.name == "y")
    assert y.values is None
    assert y.bounds == pytest.approx((-0.03, 0.03))
    assert task[-1].index == 1727
    assert [one.index for one in task[10:13]] == [10, 11, 12]
    with pytest.raises(IndexError, match="instances 0 to 1727"):
        task[1728]


@given(st.data())
def test_neighbors_differ_in_one_factor_alone(data: st.DataObject) -> None:
    task = wmspec.load(COLLIDE)
    one = task[data.draw(st.integers(0, len(task) - 1))]
    factor = data.draw(st.sampled_from(sorted(one.factors)))
    for other in one.neighbors(factor):
        assert {f for f in one.factors if one.factors[f] != other.factors[f]} == {factor}
        assert one.nuisances == other.nuisances


def test_unknown_names_are_reported_with_the_known_ones() -> None:
    one = wmspec.load(COLLIDE)[3]
    with pytest.raises(wmspec.WmsError, match="no factor `fil`; did you mean `fill`"):
        one.neighbors("fil")
    with pytest.raises(wmspec.WmsError, match="no counterfactual `light_slwo`; did you mean `light_slow`"):
        one.stage("light_slwo")


def test_mistakes_are_raised_together() -> None:
    text = "use room task t : custom { object a { freiction: 1 } object b { size: 1 s } observe front at [0 s] }"
    with pytest.raises(wmspec.SpecError) as caught:
        wmspec.load(text=text)
    assert [d.code for d in caught.value.diagnostics] == ["WMS203", "WMS301"]
    assert "<text>:1:" in str(caught.value)


def test_of_several_tasks_one_is_named() -> None:
    with pytest.raises(wmspec.WmsError, match="has 2 tasks; choose one of first, second by name"):
        wmspec.load(text=TWO)
    assert wmspec.load(text=TWO, task="second").name == "second"
    with pytest.raises(wmspec.WmsError, match="no task `secnd`; did you mean `second`"):
        wmspec.load(text=TWO, task="secnd")
    with pytest.raises(wmspec.WmsError, match="either the path of a spec or its text"):
        wmspec.load()


def test_load_all_takes_files_and_folders(tmp_path: Path) -> None:
    (tmp_path / "two.wms").write_text(TWO)
    assert [t.name for t in wmspec.load_all(tmp_path)] == ["first", "second"]
    (tmp_path / "again.wms").write_text(TWO)
    with pytest.raises(wmspec.WmsError, match="two tasks are called `first`"):
        wmspec.load_all(tmp_path)


def test_diagnose_returns_all_without_raising(tmp_path: Path) -> None:
    (tmp_path / "wrong.wms").write_text("task t : custom { object a { freiction: 1 } }")
    wrong = wmspec.diagnose(tmp_path)
    assert not wrong.passed
    assert str(wrong.diagnostics[0].place).endswith("wrong.wms:1:30")
    right = wmspec.diagnose(COLLIDE)
    assert right.passed
    assert right.tasks == (("collide", 1728),)


def test_the_seed_decides_the_draws_and_the_order() -> None:
    here, there = (wmspec.load(COLLIDE, seed=seed)[:40] for seed in (0, 1))
    assert all(a.nuisances != b.nuisances for a, b in zip(here, there, strict=True))
    assert [a.factors["pace"] for a in here] != [b.factors["pace"] for b in there]


# ---------------------------------------------------------------- episodes


@pytest.fixture(scope="module")
def episode() -> wmspec.Episode:
    installed("mujoco")
    return wmspec.load(text=FALL)[1].run("mujoco")


def test_an_episode_has_the_ways_of_bodies(episode: wmspec.Episode) -> None:
    ball = episode["ball"]
    assert episode.time.shape == (121,)
    assert ball.position.shape == ball.linear_velocity.shape == (121, 3)
    assert ball.orientation.shape == (121, 4)
    fallen = ball.position[0, 2] - ball.position[48, 2]
    assert fallen == pytest.approx(9.81 * 0.2**2 / 2, rel=0.02), "free fall for 0.2 s"
    with pytest.raises(wmspec.WmsError, match="did you mean `ball`"):
        episode["bal"]


def test_an_episode_iterates_over_the_names_of_its_bodies(episode: wmspec.Episode) -> None:
    assert tuple(episode) == episode.bodies
    assert len(episode) == len(episode.bodies)
    assert "ball" in episode
    assert 0 not in episode
    assert {name: episode[name] for name in episode}.keys() == set(episode.bodies)


def test_pictures_show_the_same_moment(episode: wmspec.Episode) -> None:
    rgb, ids, depth = episode.frame("front", 0.2), episode.ids("front", 0.2), episode.depth("front", 0.2)
    assert (rgb.shape, rgb.dtype, ids.shape, depth.shape) == ((384, 384, 3), np.uint8, (384, 384), (384, 384))
    ball = ids == episode.bodies.index("ball")
    red, green, _ = rgb[ball].mean(axis=0)
    assert red > green + 50
    rows = [
        np.flatnonzero((episode.ids("front", t) == episode.bodies.index("ball")).any(axis=1)).mean() for t in (0, 0.2)
    ]
    assert rows[1] > rows[0], "it falls"
    assert depth[ball].max() < depth[~ball & (depth > 0)].max()
    assert episode.frame("front", 0.2, size=(64, 32)).shape == (32, 64, 3)


def test_unsupported_looks_are_reported(episode: wmspec.Episode) -> None:
    with pytest.raises(wmspec.WmsError, match="outside the episode, which lasts"):
        episode.frame("front", 3.0)
    with pytest.raises(wmspec.WmsError, match="no camera `frnt`"):
        episode.frame("frnt", 0)
    with pytest.raises(wmspec.WmsError, match="each side of a picture has 16 to 4096"):
        episode.frame("front", 0, size=3)


def test_episode_round_trips(episode: wmspec.Episode, tmp_path: Path) -> None:
    episode.save(tmp_path / "fall.npz")
    again = wmspec.load_episode(tmp_path / "fall.npz")
    assert np.array_equal(again["ball"].position, episode["ball"].position)
    assert np.array_equal(again.frame("front", 0.2), episode.frame("front", 0.2))


def test_a_stage_from_disk_runs_like_its_instance(episode: wmspec.Episode, tmp_path: Path) -> None:
    wmspec.load(text=FALL)[1].write(tmp_path)
    there = wmspec.run(tmp_path / "000001.usda", "mujoco")
    assert np.array_equal(there["ball"].position, episode["ball"].position)
    assert wmspec.run(tmp_path / "000001.usda", "mujoco", duration=0.1).time[-1] == pytest.approx(0.1)


def test_stage_without_a_duration_needs_one(tmp_path: Path) -> None:
    installed("mujoco")
    (tmp_path / "ball.usda").write_text(
        '#usda 1.0\ndef Sphere "ball" (apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {}\n'
    )
    with pytest.raises(wmspec.WmsError, match="the stage does not say how long it lasts"):
        wmspec.run(tmp_path / "ball.usda", "mujoco")


def test_a_counterfactual_is_run_as_an_instance_is() -> None:
    installed("mujoco")
    one = next(i for i in wmspec.load(COLLIDE) if (i.factors["fill"], i.factors["pace"]) == (0.15, -1))
    pushed, harder = one.run("mujoco"), one.run("mujoco", "light_fast")
    shown, ratio = int(1.6 * 240), float(one.nuisances["ratio"])  # both have been pushed by then, and have met nothing
    slow, fast = (np.linalg.norm(run["ball"].linear_velocity[:shown], axis=1).max() for run in (pushed, harder))
    assert fast - slow == pytest.approx(float(one.nuisances["middle"]) * (ratio**0.5 - ratio**-0.5), rel=0.02)


def test_questions_and_rejections_are_returned() -> None:
    installed("mujoco")
    question, *seen = wmspec.load(COLLIDE)[7].ask("mujoco", size=128)
    assert "which picture" in question.text.lower()
    assert len(seen) == 2, "heavy or light, slow or fast"
    assert len(question.options) == 4
    assert question.answer is not None
    assert question.options[question.answer].kind == "truth"
    impossible = COLLIDE.read_text().replace("    kinds {", "    ensure height(crate) < 14 cm\n    kinds {")
    questions = wmspec.load(text=impossible)[7].ask("mujoco", size=128)
    assert len(questions) == 2
    assert [r.reason for r in questions.rejected] in (["ensure"], ["group"])


# ---------------------------------------------------------------- many instances


def test_a_crosscheck_is_a_table() -> None:
    installed("mujoco")
    installed("pybullet")
    agreement = wmspec.crosscheck(wmspec.load(COLLIDE), sample=2, backend="mujoco,pybullet", workers=1)
    (line,) = agreement.lines
    assert dataclasses.is_dataclass(type(line))
    assert (line.task, line.engines, line.episodes.all) == ("collide", ("mujoco", "pybullet"), 4 * 4)  # a group
    table = agreement.to_pandas()
    assert list(table["task"]) == ["collide"]
    assert table["episodes_of"][0] == 16


def test_a_crosscheck_needs_two_engines() -> None:
    installed("mujoco")
    with pytest.raises(wmspec.WmsError, match="needs two engines"):
        wmspec.crosscheck(COLLIDE, backend="mujoco")


def example(page: str) -> str:
    """The example of the API as it stands in a page."""
    _, _, rest = Path(page).read_text().partition("```python\nimport wmspec\n")
    return "import wmspec\n" + rest.partition("```")[0]


def run_example(code: str, folder: Path, generated: Path = COLLIDE) -> None:
    (folder / "specs").mkdir()
    (folder / "collide.wms").write_text(COLLIDE.read_text())
    (folder / "specs" / generated.name).write_text(generated.read_text())
    (folder / "example.py").write_text(code)
    done = subprocess.run([sys.executable, "example.py"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (folder / "out/manifest.json").exists()


def test_the_example_is_a_script_that_runs(tmp_path: Path) -> None:
    """It needs no `if __name__ == "__main__"`, though it starts processes."""
    installed("mujoco")
    installed("pybullet")
    code = example("docs/api.md").replace("sample=20", 'sample=1, backend="mujoco,pybullet"')
    code = code.replace('backend="all", per_task=60', 'backend="mujoco", size=64, per_task=2')
    run_example(code, tmp_path, generated=Path("tests/films/specs/shove.wms"))


@pytest.mark.slow
def test_the_example_runs_as_it_stands(tmp_path: Path) -> None:
    for engine in ("mujoco", "pybullet", "sapien"):
        installed(engine)
    run_example(example("docs/api.md"), tmp_path)


def test_a_seed_that_its_tasks_were_not_loaded_with_is_refused(tmp_path: Path) -> None:
    task, reported = wmspec.load(COLLIDE, seed=3), "were loaded with the seed 3, not 4; load them with `seed=4`"
    with pytest.raises(wmspec.WmsError, match=reported):
        wmspec.generate(task, tmp_path / "out", backend="mujoco", per_task=4, seed=4)
    with pytest.raises(wmspec.WmsError, match=reported):
        wmspec.crosscheck(task, seed=4)


def test_generate_reports_whole_control_groups(tmp_path: Path) -> None:
    messages: list[str] = []
    spec = Path("specs/gallery/constancy.wms")
    for count in (1, 4):
        wmspec.generate(
            spec, tmp_path / str(count), per_task=count, backend="mujoco", size=48, workers=0, tell=messages.append
        )
    notices = [line for line in messages if "groups are whole" in line]
    assert notices == ["`constancy`: 4 instances instead of 1, as control groups are whole"]
