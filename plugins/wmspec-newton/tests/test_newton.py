"""Newton as an engine of wmspec, in an environment that has both distributions.

`make newton` runs these tests on the wheels.
"""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest

import wmspec
from usdphysics_conformance import all_cases
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.conformance import score_engine
from wmspec.sim.usd import read
from wmspec_newton import execute_all

ROOM = "use room\n\ntask t : custom.motion {\n  factor value in [%s]\n%s\n  horizon %s s\n  observe front at [0 s]\n}\n"
BALL = "object ball { shape: sphere  size: 6 cm  mass: 100 g  color: red  on: floor }"
BOX = BALL.replace("sphere  size: 6 cm", "box  size: 8 cm")
DROP = "action go = drop(ball, height: 20 cm) at 0 s"


def run(values: str, body: str, horizon: float = 1.0) -> list:
    """The episodes in Newton of a task with the factor `value`."""
    return [one.run("newton") for one in wmspec.load(text=ROOM % (values, body, horizon))]


def test_wmspec_finds_it_by_its_entry_point() -> None:
    assert {"mujoco", "newton"} <= {entry.name for entry in entry_points(group="wmspec.backends")}
    done = subprocess.run([sys.executable, "-m", "wmspec", "doctor"], capture_output=True, text=True, check=False)
    assert "ok  newton executes" in done.stdout, done.stdout


@pytest.mark.parametrize("mass", ["20 g", "5 kg"])
def test_a_thrown_ball_flies_on_a_parabola(mass: str) -> None:
    ball = f"object ball {{ shape: sphere  size: 4 cm  mass: {mass}  color: red  at: (0 cm, 0 cm, 1.2 m) }}"
    (flight,) = run("1", f"  {ball}\n  action go = launch(ball, direction: right, speed: 1 m/s) at 0 s", 0.4)
    path, time = flight["ball"].position, flight.time
    np.testing.assert_allclose(path[:, 2], 1.2 - 9.81 * time**2 / 2, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(path[:, :2] - path[0, :2], axis=1), time, atol=1e-4)


def test_a_dropped_ball_rebounds_by_its_restitution() -> None:
    slab = "object slab { shape: box  size: (80 cm, 60 cm, 4 cm)  restitution: value  fixed: true  on: floor }"
    ball = "object ball { shape: sphere  size: 12 cm  mass: 200 g  color: red  restitution: value  on: slab }"
    drop = "action let_go = drop(ball, height: 40 cm) at 0 s"
    for restitution, episode in zip((0.3, 0.6), run("0.3, 0.6", f"  {slab}\n  {ball}\n  {drop}"), strict=True):
        height, fall = episode["ball"].position[:, 2] - 0.10, np.sqrt(2 * 0.4 / 9.81)
        after = height[(episode.time > fall) & (episode.time < fall * (1 + 2 * restitution))]
        assert after.max() == pytest.approx(0.4 * restitution**2, rel=0.1)


def test_a_sliding_box_stops_by_its_friction() -> None:
    box = "object brick { shape: box  size: 10 cm  mass: 1 kg  color: red  friction: value  on: slab }"
    slab = "object slab { shape: box  size: (300 cm, 60 cm, 4 cm)  friction: value  fixed: true  on: floor }"
    go = "action go = launch(brick, direction: right, speed: 1.5 m/s) at 0 s"
    for friction, episode in zip((0.2, 0.4), run("0.2, 0.4", f"  {slab}\n  {box}\n  {go}", 1.5), strict=True):
        way = np.linalg.norm(np.ptp(episode["brick"].position[:, :2], axis=0))
        assert way == pytest.approx(1.5**2 / (2 * friction * 9.81), rel=0.03)


def test_an_armature_slows_a_fall() -> None:
    load = "object load { shape: cube  size: 10 cm  mass: 2 kg  color: red  at: (0, 0, 1 m) }"
    rail = "joint rail : slider { of: load  at: (0, 0, 1 m)  armature: value }"
    for armature, episode in zip((0.5, 4), run("0.5, 4", f"  {load}\n  {rail}", 0.4), strict=True):
        fallen = 9.81 * episode.time**2 / 2 * 2 / (2 + armature)
        np.testing.assert_allclose(episode["load"].position[:, 2], 1 - fallen, atol=1e-4)


def test_a_ball_passes_through_a_wall_as_in_mujoco() -> None:
    wall = "object wall { shape: box  size: (4 cm, 40 cm, 30 cm)  on: floor at (20 cm, 0)  fixed: true }"
    go = "action go = launch(ball, direction: right, speed: 1 m/s) at 0 s"
    ghost = "action ghost = pass_through(ball, through: wall) for 0.6 s"
    (one,) = wmspec.load(text=ROOM % ("1", f"  {BALL}\n  {wall}\n  {go}\n  {ghost}", 0.6))
    ours, theirs = (one.run(engine)["ball"].position for engine in ("newton", "mujoco"))
    assert np.ptp(ours[:, :2], axis=0).max() > 0.4
    np.testing.assert_allclose(ours, theirs, atol=1e-3)


@pytest.mark.parametrize(
    "case",
    ["mimic_counterweight", "four_bar", "drive_hinge", "limit_slider", "pendulum_ball_joint", "pendulum_conical"],
)
def test_joints_move_as_in_mechanics(case: str) -> None:
    scores = list(score_engine("newton", [all_cases()[case]]))
    assert scores
    assert all(score.passed for score in scores), scores


def test_the_native_script_runs_with_newton_alone(tmp_path: Path) -> None:
    go = "action go = launch(ball, direction: right, speed: 50 cm/s) at 0.1 s"
    (one,) = wmspec.load(text=ROOM % ("1", f"  {BALL}\n  {go}", 0.5))
    for name, text in one.native("newton").items():
        (tmp_path / name).write_text(text)
    assert "wmspec" not in (tmp_path / "run.py").read_text()
    subprocess.run([sys.executable, "-I", "run.py"], cwd=tmp_path, check=True, capture_output=True)
    trace = np.load(tmp_path / "trace.npz")
    found = trace["position"][:, list(trace["bodies"]).index("ball")]
    np.testing.assert_array_equal(found, one.run("newton")["ball"].position)


def test_the_same_episode_has_the_same_bytes() -> None:
    (first,), (second,) = (run("1", f"  {BALL}\n  {DROP}", 0.5) for _ in range(2))
    np.testing.assert_array_equal(first["ball"].position, second["ball"].position)


def test_another_engine_draws() -> None:
    (one,) = wmspec.load(text=ROOM % ("1", f"  {BALL}\n  {DROP}", 0.5))
    with pytest.raises(WmsError, match="newton cannot draw"):
        one.run("newton").frame("front", 0.0)
    assert one.run("newton").frame("front", 0.0, renderer="mujoco").shape[2] == 3


WORLDS = """
  object ball { shape: sphere  size: value  mass: 100 g  color: red  damping: 3 Hz  restitution: 0.5  on: floor }
  object wall { shape: box  size: (4 cm, 40 cm, 30 cm)  on: floor at (12 cm, 0 cm)  fixed: true }
  object pulled { shape: box  size: 6 cm  mass: 100 g  color: red  on: floor at (-30 cm, 30 cm) }
  object falling { shape: box  size: value  mass: 200 g  color: blue  friction: 0.1  on: floor at (-40 cm, -30 cm) }
  action fall = drop(falling, height: 1 cm) at 20 ms
  action go = launch(ball, direction: right, speed: 2 m/s) at 10 ms
  action pull = force(pulled, direction: right, force: 2 N) for 60 ms
"""


def test_the_worlds_of_a_batch_move_as_alone() -> None:
    instances = wmspec.load(text=ROOM % ("6 cm, 8 cm, 10 cm", WORLDS, "0.08"))
    alone = [one.run("newton").trace for one in instances]
    together = execute_all([read(one.stage()) for one in instances], device="cpu")
    for one, other in zip(alone, together, strict=True):
        assert np.ptp(one.position, axis=0).max() > 0.05
        np.testing.assert_allclose(one.position, other.position, atol=1e-3)  # 32-bit contacts
        assert {(c.first, c.second) for c in one.contacts} == {(c.first, c.second) for c in other.contacts}


def test_scenes_of_other_structure_keep_their_order() -> None:
    balls, boxes = (wmspec.load(text=ROOM % ("1", f"  {text}\n  {DROP}", 0.02)) for text in (BALL, BOX))
    scenes = [read(one.stage()) for task in (balls, boxes, balls) for one in task]
    first, second, third = execute_all(scenes, device="cpu")
    assert first.position.tobytes() == third.position.tobytes() != second.position.tobytes()


def catalogue(task: str) -> Path:
    """The spec of a task, in a wheel or a checkout."""
    specs = Path(wmspec.__file__).parent / "specs"
    return next(iter([*specs.rglob(f"{task}.wms"), *(specs.parents[1] / "specs").rglob(f"{task}.wms")]))


def test_answers_of_the_catalogue_are_those_of_mujoco() -> None:
    agreement = wmspec.crosscheck(wmspec.load(catalogue("slide")), backend="mujoco,newton", sample=2)
    assert all(instance.passes(strict=False) for instance in agreement.instances)


def test_an_arm_lifts_a_block_as_in_mujoco() -> None:
    """With 79 degrees of freedom, more than MuJoCo-Warp's dense Jacobian allows."""
    one = wmspec.load(catalogue("arm_lift"))[0]
    ours, theirs = (one.run(engine, duration=3.0).trace for engine in ("newton", "mujoco"))
    assert np.ptp(theirs.position[..., 2], axis=0).max() > 0.02
    np.testing.assert_allclose(ours.position, theirs.position, atol=2e-3)
