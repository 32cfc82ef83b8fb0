"""Arms pick, push, lift, turn, put down and let go alike in every engine, and stages say how."""

import os
import subprocess
import sys
from dataclasses import replace
from functools import cache
from importlib import import_module
from itertools import product
from math import radians
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdPhysics
from scipy.interpolate import CubicSpline

import wmspec
from tests.engines import ENGINES, installed, quick
from tests.examples import slow_except
from tests.language.specs import SPECS, task_of
from tests.stage.law import violations
from wmspec.compile.design.depend import Dependencies, changed_by
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.placement import base
from wmspec.compile.robots.arm import downward_pose, solve
from wmspec.compile.robots.franka import PANDA
from wmspec.compile.robots.plan import plan
from wmspec.compile.robots.planning import matrix
from wmspec.compile.stage.episode import document
from wmspec.core.diagnostics import EngineError, SpecError
from wmspec.core.resources import resource
from wmspec.sim.usd import read

TASKS = [path for path in SPECS if path.stem.startswith(("arm_", "arms_"))]
PICKED = 3.8  # s, when PICK is over
AT_A_LIMIT = {"arm_push": (670,)}  # where a joint goes as far as it may
NEAR = 1e-4  # m
TURN = radians(0.05)

ONE = """use tabletop_arm
task one : custom {{
  object cup {{ shape: box  size: (6 cm, 5 cm, 6 cm)  density: {density} kg/m^3  friction: {friction}
                on: table at (-4 cm, -3 cm) }}
  object mat {{ shape: box  size: (16 cm, 16 cm, 1 cm)  on: table at (14 cm, -3 cm)  fixed: true }}
  {more}
  horizon {horizon} s
  observe facing at [0 s]
}}"""
TWO = """use tabletop_arms
task two : custom {{
  object plank {{ shape: box  size: {size}  on: table at (2 cm, 3 cm) }}
  {more}
  horizon {horizon} s
  observe facing at [0 s]
}}"""
PICK = "action grab = arm.pick(cup, height: 12 cm) for 3.4 s"
BLOCK = "object block { shape: cube  size: 5 cm  on: table at (14 cm, 8 cm) }"
BOTH = """action a = left_arm.lift(plank, height: {low}) for 3.4 s
  action b = right_arm.lift(plank, height: {high}) for 3.4 s with a"""


def two(more: str, size: str = "(34 cm, 7 cm, 3 cm)", horizon: float = 6.4) -> wmspec.Task:
    """A task with two arms."""
    return wmspec.load(text=TWO.format(size=size, more=more, horizon=horizon))


@cache
def one(more: str, density: float = 500, friction: float = 0.5, horizon: float = 10.6) -> wmspec.Task:
    """A task with one arm."""
    return wmspec.load(text=text_of_one(more, density, friction, horizon))


def text_of_one(more: str, density: float = 500, friction: float = 0.5, horizon: float = 10.6) -> str:
    """Its text, in which places and sizes can be replaced."""
    return ONE.format(more=more, density=density, friction=friction, horizon=horizon)


def ended(task: wmspec.Task, engine: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """How far something has moved, and its orientation at the end."""
    installed(engine)
    run = task[0].run(engine)
    return run[name].position[-1] - run[name].position[0], run[name].orientation[-1]


def turned(orientation: np.ndarray, angle: float, axis: int = 3) -> float:
    """By how much an orientation is off a turn about an axis (its number in the quaternion)."""
    required = np.zeros(4)
    required[0], required[axis] = np.cos(angle / 2), np.sin(angle / 2)
    return float(2 * np.arccos(min(1.0, abs(required @ orientation))))


@pytest.mark.parametrize("engine", ENGINES)
def test_picked_object_reaches_its_height_and_is_turned_and_placed(engine: str) -> None:
    installed(engine)
    more = f"""{PICK}
      action twist = arm.rotate(cup, angle: 40 deg) for 2 s at 3.6 s
      action put = arm.place(cup, on: mat, at: (1 cm, 2 cm)) for 5 s at 5.6 s"""
    run = one(more, horizon=10.8)[0].run(engine)
    path, orientation = run["cup"].position - run["cup"].position[0], run["cup"].orientation
    up = int(np.searchsorted(run.time, 3.6)) - 1
    assert path[up] == pytest.approx([0, 0, 0.12], abs=NEAR)
    assert turned(orientation[up], 0.0) < TURN
    assert path[-1] == pytest.approx([0.19, 0.02, 0.01], abs=2 * NEAR)
    assert turned(orientation[-1], radians(40)) < TURN


@pytest.mark.parametrize("engine", quick("pybullet"))
def test_it_falls_when_the_hand_opens(engine: str) -> None:
    moved, _ = ended(one(PICK + "\naction open = arm.drop(cup) after grab", horizon=5), engine, "cup")
    assert moved == pytest.approx([0, 0, 0], abs=1.2e-3)


WAYS = {"left": (-0.1, 0), "away": (0, 0.1), "nearer": (0, -0.1)}


@pytest.mark.parametrize(
    ("way", "engine"),
    slow_except([("left", "mujoco"), ("away", "pybullet"), ("nearer", "sapien")], product(WAYS, ENGINES)),
)
def test_pushed_object_follows_the_push(engine: str, way: str) -> None:
    shove = f"action shove = arm.push(cup, direction: {way}, distance: 10 cm) for 5 s"
    moved, _ = ended(one(shove, horizon=5.2), engine, "cup")
    assert moved == pytest.approx([*WAYS[way], 0], abs=1.5e-3)


SLIPS = {"heavy": (80_000, 0.5), "smooth": (3000, 0.0001)}


@pytest.mark.parametrize(
    ("why", "engine"),
    slow_except([("heavy", "mujoco"), ("smooth", "pybullet"), ("smooth", "sapien")], product(SLIPS, ENGINES)),
)
def test_too_heavy_or_smooth_object_slips(engine: str, why: str) -> None:
    moved, _ = ended(one(PICK, *SLIPS[why], horizon=4), engine, "cup")
    assert abs(moved[2]) < 2 * NEAR


@pytest.mark.parametrize("engine", quick("mujoco", "pybullet"))
def test_blocked_push_is_reported(engine: str) -> None:
    """Whether the tie between hand and thing gives, as in MuJoCo and PyBullet, or what is in the way, as in SAPIEN."""
    installed(engine)
    stop = "object stop { shape: box  size: (3 cm, 8 cm, 6 cm)  on: table at (1.5 cm, -3 cm)  mass: 100 g }"
    wall = "object wall { shape: box  size: (3 cm, 8 cm, 6 cm)  on: table at (4.6 cm, -3 cm)  fixed: true }"
    more = f"""{stop} {wall} action grab = arm.pick(cup, height: 2 cm) for 3.4 s
      action go = arm.carry(cup, direction: right, distance: 25 mm) for 1 s after grab"""
    with pytest.raises(EngineError, match=r"hand drops .*/cup at \d\.\d+ s|an arm presses cup and stop .* at \d"):
        one(more, horizon=4.6)[0].run(engine)


@pytest.mark.parametrize("engine", quick("sapien"))
def test_held_object_may_push_a_movable_one(engine: str) -> None:
    installed(engine)
    more = """object stop { shape: box  size: (3 cm, 8 cm, 6 cm)  on: table at (1.5 cm, -3 cm)  mass: 100 g }
      action grab = arm.pick(cup, height: 2 cm) for 3.4 s
      action go = arm.carry(cup, direction: right, distance: 25 mm) for 1 s after grab"""
    run = one(more, horizon=4.6)[0].run(engine)
    assert run["stop"].position[-1][0] - run["stop"].position[0][0] == pytest.approx(0.015, abs=2e-3)


def test_no_hand_passes_through_an_object() -> None:
    lid = "object lid { shape: box  size: (8 cm, 3 cm, 2 cm)  at: (-4 cm, -3 cm, 12 cm)  fixed: true }"
    with pytest.raises(SpecError, match="its hand would go through `lid`"):
        one(f"{lid} {PICK}")[0].stage()


def test_held_and_pushed_objects_never_pass_through_fixed_ones() -> None:
    far = "object stop {{ shape: box  size: (3 cm, 8 cm, {high})  on: table at ({x} cm, -3 cm)  fixed: true }}"
    low = PICK.replace("12 cm", "4 cm")
    go = f"{low} action go = arm.carry(cup, direction: right, distance: 7 cm) for 2 s after grab"
    with pytest.raises(SpecError, match="`cup` would go through `stop`"):
        one(f"{far.format(high='4.5 cm', x=6)} {go}")[0].stage()
    one(f"{far.format(high='3.9 cm', x=6)} {go}")[0].stage()  # it is 4 cm up by then
    shove = "action shove = arm.push(cup, direction: left, distance: 8 cm) for 5 s"
    with pytest.raises(SpecError, match="`cup` would go through `stop`"):
        one(f"{far.format(high='2 cm', x=-15.5)} {shove}")[0].stage()
    one(f"{far.format(high='2 cm', x=-17)} {shove}")[0].stage()


@pytest.mark.parametrize("engine", quick("sapien"))
def test_push_into_a_fixed_object_is_reported(engine: str) -> None:
    installed(engine)
    more = """object next { shape: cube  size: 5 cm  on: table at (-12 cm, -3 cm) }
      object wall { shape: box  size: (2 cm, 16 cm, 12 cm)  on: table at (-17 cm, -3 cm)  fixed: true }
      action shove = arm.push(cup, direction: left, distance: 7 cm) for 5 s"""
    with pytest.raises(EngineError, match=r"an arm presses \w+ and \w+ \d+\.\d mm into each other"):
        one(more, horizon=5.2)[0].run(engine)


def test_contents_move_with_a_carried_object_in_the_plan() -> None:
    """So it can be taken where it is by then, and what it lies on is put down through nothing of its own."""
    more = """object plank { shape: box  size: (20 cm, 6 cm, 3 cm)  on: table at (-4 cm, 12 cm) }
      object rider { shape: cube  size: 3 cm  on: plank at (-7 cm, 0 cm) }
      action grab = arm.pick(plank, height: 12 cm, at: (4 cm, 0 cm)) for 4 s
      action twist = arm.rotate(plank, angle: 60 deg) for 2 s after grab
      action put = arm.place(plank, on: table, at: (-20 cm, -6 cm)) for 5 s after twist
      action take = arm.pick(rider, height: 9 cm) for 4 s after put"""
    task = wmspec.load(text=text_of_one(more, horizon=15.2))
    installed("pybullet")
    run = task[0].run("pybullet")
    x, y = run["rider"].position[-1][:2] - run["plank"].position[-1][:2]
    assert (x, y) == pytest.approx((-0.07 * np.cos(radians(60)), -0.07 * np.sin(radians(60))), abs=1e-3)
    assert run["rider"].position[-1][2] - run["plank"].position[-1][2] == pytest.approx(0.03 + 0.09, abs=3 * NEAR)


def test_vanished_object_is_not_held() -> None:
    more = """object ball { shape: sphere  size: 5 cm  on: table at (-16 cm, -3 cm) }
      action shove = arm.push(cup, direction: left, distance: 9 cm) for 5 s
      action grab = arm.pick(ball, height: 9 cm) for 4 s after shove"""
    installed("pybullet")
    with pytest.raises(EngineError, match=r"ball is not between the fingers of hand when the grip begins at \d"):
        one(more, horizon=9.2)[0].run("pybullet")


@pytest.mark.parametrize("engine", quick("pybullet"))
def test_glass_is_held_by_its_wall_with_its_contents(engine: str) -> None:
    more = """object glass : ware.tumbler { radius: 32 mm  on: table at (-4 cm, 12 cm) }
      object bead { shape: sphere  size: 1 cm  inside: glass at (0, 0) }
      action grab = arm.pick(glass, height: 12 cm) for 3.4 s"""
    text = text_of_one(more, horizon=3.8).replace("use tabletop_arm", "use tabletop_arm use kitchenware as ware")
    moved, _ = ended(wmspec.load(text=text), engine, "glass")
    assert moved == pytest.approx([0, 0, 0.12], abs=3 * NEAR)


def test_no_link_passes_through_an_object() -> None:
    shelf = "object shelf {{ shape: box  size: (40 cm, 3 cm, 3 cm)  at: (0, 40 cm, {z} cm)  fixed: true }}"
    with pytest.raises(SpecError, match=r"a link of it would go through `shelf`"):
        one(f"{shelf.format(z=60)} {PICK}")[0].stage()
    one(f"{shelf.format(z=15)} {PICK}")[0].stage()
    tip = "action tip = arm.tilt(cup, angle: 170 deg) for 4 s after grab"
    with pytest.raises(SpecError, match=r"would go through `table`"):
        one(f"{PICK} {tip}")[0].stage()


@pytest.mark.parametrize("engine", quick("mujoco"))
def test_two_arms_lift_a_plank_by_its_ends(engine: str) -> None:
    task = two(BOTH.format(low="4 cm", high="10 cm"), horizon=PICKED)
    moved, orientation = ended(task, engine, "plank")
    assert moved == pytest.approx([0, 0, 0.07], abs=2 * NEAR)
    assert turned(orientation, -np.arcsin(0.06 / 0.29), axis=2) < TURN


@pytest.mark.parametrize("engine", quick("pybullet"))
def test_one_arm_lifts_one_end_and_the_other_stays(engine: str) -> None:
    only = BOTH.format(low="10 cm", high="4 cm").splitlines()[0]
    task = two(only, horizon=PICKED)
    moved, orientation = ended(task, engine, "plank")
    angle = float(np.arcsin(0.1 / 0.315))
    assert turned(orientation, angle, axis=2) < 4 * TURN
    middle = 0.17 * np.sin(angle) + 0.015 * np.cos(angle) - 0.015
    assert moved[2] == pytest.approx(middle, abs=1e-3)


@pytest.mark.parametrize("engine", quick("sapien"))
def test_two_arms_push_by_the_sum(engine: str) -> None:
    more = """action a = left_arm.push(plank, direction: right, distance: 8 cm) for 6 s
      action b = right_arm.push(plank, direction: nearer, distance: 10 cm) for 6 s with a"""
    moved, orientation = ended(two(more, "(14 cm, 14 cm, 8 cm)"), engine, "plank")
    assert moved == pytest.approx([0.08, -0.1, 0], abs=1e-3)
    assert turned(orientation, 0.0) < radians(0.2)


@pytest.mark.parametrize("engine", quick("pybullet"))
@pytest.mark.parametrize(("left", "right"), slow_except([("away", "nearer")], [("away", "away"), ("away", "nearer")]))
def test_a_bar_that_two_arms_push_by_its_ends_shifts_or_turns(engine: str, left: str, right: str) -> None:
    more = f"""action a = left_arm.push(plank, direction: {left}, distance: 8 cm) for 6 s
      action b = right_arm.push(plank, direction: {right}, distance: 8 cm) for 6 s with a"""
    moved, orientation = ended(two(more, "(36 cm, 6 cm, 6 cm)"), engine, "plank")
    assert moved == pytest.approx([0, 0.08 if left == right else 0, 0], abs=3e-3)
    assert turned(orientation, 0.0 if left == right else -np.arcsin(0.08 / 0.145)) < radians(1.5)


@pytest.mark.parametrize("engine", quick("pybullet"))
def test_hand_that_closes_beside_an_object_misses_it(engine: str) -> None:
    miss = PICK.replace("height: 12 cm", "height: 12 cm, at: (0 cm, -9 cm)")
    moved, _ = ended(one(miss, horizon=PICKED), engine, "cup")
    assert moved == pytest.approx([0, 0, 0], abs=NEAR)
    both = BOTH.format(low="6 cm", high="6 cm").replace(
        "height: 6 cm) for 3.4 s\n", "height: 6 cm, at: (0 cm, -9 cm)) for 3.4 s\n"
    )
    task = two(both, horizon=PICKED)
    _, orientation = ended(task, engine, "plank")
    assert turned(orientation, -np.arcsin(0.06 / 0.315), axis=2) < 4 * TURN


@pytest.mark.parametrize("engine", quick("mujoco"))
def test_object_is_handed_over(engine: str) -> None:
    more = """action grab = left_arm.pick(plank, height: 10 cm, at: (-10 cm, 0 cm)) for 3.4 s
      action take = right_arm.grasp(plank, at: (10 cm, 0 cm)) for 3 s after grab
      action leave = left_arm.drop(plank) after take
      action go = right_arm.carry(plank, direction: right, distance: 5 cm) for 1.5 s after leave"""
    moved, orientation = ended(two(more, "(30 cm, 4 cm, 4 cm)", horizon=8.4), engine, "plank")
    assert moved == pytest.approx([0.05, 0, 0.1], abs=5e-4)
    assert turned(orientation, 0.0) < 4 * TURN


DRAWER = """object body { shape: box  size: (26 cm, 1 cm, 9 cm)  on: table at (0, 26 cm)  fixed: true }
  object drawer {
    mass: 400 g  on: table at (0, 14 cm)
    part base  { shape: box  size: (23 cm, 20 cm, 6 mm)  at: (0, 0, 13 mm) }
    part front { shape: box  size: (23 cm, 1 cm, 8 cm)   at: (0, -105 mm, 45 mm) }
  }
  object knob { shape: cube  size: 25 mm  mass: 20 g  at: (0, -30 mm, 50 mm) }
  joint neck  : fixed  { of: knob    to: drawer  at: (0, -2 cm, 50 mm) }
  joint rails : slider { of: drawer  to: body    at: (0, 0, 2 cm)  axis: (0, -1, 0)  low: -1 cm  high: 18 cm }"""


@pytest.mark.parametrize("wide", slow_except([34], [34, 45]))
@pytest.mark.parametrize("engine", quick("mujoco"))
def test_objects_narrower_than_the_hand_are_pushed(engine: str, wide: int) -> None:
    more = "action go = arm.push(cup, direction: left, distance: 8 cm) for 6 s"
    text = text_of_one(more, horizon=6.2).replace("(6 cm, 5 cm, 6 cm)", f"(6 cm, {wide} mm, 4 cm)")
    moved, orientation = ended(wmspec.load(text=text), engine, "cup")
    assert moved == pytest.approx([-0.08, 0, 0], abs=1.5e-3)
    # PyBullet solves the friction of one contact after another, which turns what few contacts hold.
    assert turned(orientation, 0.0) < radians(1.5 if engine == "pybullet" else 0.5)


@pytest.mark.parametrize("engine", quick("pybullet"))
def test_a_drawer_is_opened_and_closed_by_its_knob(engine: str) -> None:
    more = f"""{DRAWER} action pull = arm.open(knob, joint: rails, far: 12 cm) for 6.4 s
      action back = arm.close(knob, joint: rails, far: 9 cm) for 6.4 s after pull"""
    text = text_of_one(more, horizon=13).replace("(-4 cm, -3 cm)", "(-40 cm, -3 cm)")
    text = text.replace("(14 cm, -3 cm)", "(42 cm, -3 cm)")
    moved, _ = ended(wmspec.load(text=text), engine, "drawer")
    assert moved == pytest.approx([0, -0.03, 0], abs=1e-3)


@pytest.mark.parametrize("engine", quick("sapien"))
def test_held_object_tilts_with_the_hand(engine: str) -> None:
    more = f"{PICK} action pour = arm.tilt(cup, angle: 70 deg, direction: right) for 2.4 s after grab"
    _, orientation = ended(one(more, horizon=6.2), engine, "cup")
    assert turned(orientation, radians(70), axis=2) < TURN


@pytest.mark.parametrize("engine", quick("mujoco"))
def test_arm_variant_places_the_mechanism(engine: str, tmp_path: Path) -> None:
    stage = Usd.Stage.CreateNew(str(tmp_path / "arm.usda"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.Scene.Define(stage, "/physics")
    prim = UsdGeom.Xform.Define(stage, "/arm").GetPrim()
    prim.GetReferences().AddReference(str(resource(PANDA.asset)))
    prim.GetVariantSets().GetVariantSet("motion").SetVariantSelection("articulated")
    found = replace(read(stage), duration=1.0)
    assert [joint.drive is not None for joint in found.joints] == [True] * 9
    trace = installed(engine).execute(found)
    hand = trace.bodies.index("hand")
    assert np.linalg.norm(trace.position[-1, hand] - trace.position[0, hand]) < 0.03
    assert np.linalg.norm(trace.linear_velocity[-1, hand]) < 0.01


@pytest.mark.parametrize("engine", quick("mujoco"))
def test_a_native_script_plays_what_an_arm_does_without_wmspec(engine: str, tmp_path: Path) -> None:
    backend = installed(engine)
    task = one(f"{PICK} action open = arm.drop(cup) after grab", horizon=5)
    found = read(task[0].stage())
    expected = backend.execute(found)
    for name, text in backend.native(found).items():
        assert "import wmspec" not in text
        (tmp_path / name).write_text(text)
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(
        [sys.executable, "-I", str(tmp_path / "run.py")],
        check=False, cwd=tmp_path, env=clean, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    with np.load(tmp_path / "trace.npz") as got:
        assert np.allclose(got["position"], expected.position, rtol=0, atol=1e-9)
        assert np.allclose(got["orientation"], expected.orientation, rtol=0, atol=1e-9)


def test_the_tool_comes_where_it_is_sent() -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        x, y = rng.uniform(0.32, 0.62), rng.uniform(-0.3, 0.3)
        target = downward_pose(x, y, rng.uniform(0.02, 0.25), rng.uniform(-0.6, 0.6))
        q = solve(PANDA, target, np.eye(4), PANDA.home)
        assert q is not None
        assert (PANDA.low <= q).all()
        assert (q <= PANDA.high).all()
        assert PANDA.tool(q, np.eye(4)) == pytest.approx(target, abs=2e-6)


@pytest.mark.parametrize("places", [70, pytest.param(1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("robot", "low", "high"), [("arm", -0.3, 0.3), ("left_arm", -0.3, 0.05), ("right_arm", -0.05, 0.3)]
)
def test_all_of_its_patch_is_within_reach(robot: str, low: float, high: float, places: int) -> None:
    """Random places on 60 × 40 cm, or on one half, with any rotation of the hand."""
    task = one("") if robot == "arm" else two("", "(20 cm, 7 cm, 3 cm)")
    instance = Design(task.spec)[0]
    stand = matrix(base(Evaluator(task.spec, instance.values, None, instance.key), robot))
    rng = np.random.default_rng(0)
    for x, y, z, yaw in rng.uniform((low, -0.2, 0.02, -np.pi / 2), (high, 0.2, 0.25, np.pi / 2), (places, 4)):
        ways = [solve(PANDA, downward_pose(x, y, z, turn), stand, PANDA.rest) for turn in (yaw, yaw + np.pi)]
        assert any(q is not None and (PANDA.low <= q).all() and (q <= PANDA.high).all() for q in ways)


@pytest.mark.slow
@pytest.mark.parametrize("path", TASKS, ids=lambda path: path.stem)
def test_joints_keep_their_limits_and_speeds_between_knots_too(path: Path) -> None:
    design = Design(task_of(path))
    for index in [*design.sample(8), *AT_A_LIMIT.get(path.stem, ())]:
        for reach in plan(Evaluator(design.spec, design[index].values, None, design[index].key)).values():
            way, times = CubicSpline(reach.times, reach.values, bc_type="clamped"), np.arange(0, reach.times[-1], 0.002)
            q, speed = way(times)[:, :7], way(times, 1)[:, :7]
            assert (PANDA.low <= q).all()
            assert (q <= PANDA.high).all()
            assert (np.abs(speed) <= PANDA.speed).all()


@pytest.mark.parametrize("engine", ENGINES)
def test_only_what_can_be_touched_is_driven_step_by_step(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    backend, world = installed(engine), import_module(f"wmspec.backends.{engine}.world").World
    driven, scene = [], read(one(PICK)[0].stage())
    real = world.driven
    monkeypatch.setattr(world, "driven", lambda self, paths: driven.extend(paths) or real(self, paths))
    backend.execute(replace(scene, duration=0.1))
    assert {scene.bodies[i].name for i in driven} == {"hand", "left_finger", "right_finger"}
    assert sum(body.motion == "kinematic" for body in scene.bodies) > 6


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("action grab = arm.pick(cup, height: 12 cm) for 1 s", r"times as fast as it can; give it some \d"),
        (
            "action grab = arm.pick(cup, height: 1 m) for 6 s",
            r"cm is out of its reach with the hand turned like that; place what it handles nearer",
        ),
        (
            f"{PICK} action more = arm.rotate(cup, angle: 500 deg) for 9 s after grab",
            r"its joints stop after some \d+ of 500",
        ),
        ("action grab = arm.place(cup, on: mat) for 4 s", "`arm` does not hold `cup`, so it cannot place it"),
        (
            """object two { shape: cube  size: 5 cm  on: cup }
            action a = arm.push(cup, direction: left, distance: 9 cm) for 6 s""",
            "its hand would go through `two`",
        ),
        (f"{PICK} action more = arm.place(cup, on: cup) for 4 s after grab", "`cup` cannot be put on itself"),
        (
            f"{BLOCK} {PICK} action more = arm.place(cup, on: table, at: (14 cm, 9 cm)) for 5 s after grab",
            "`cup` would go through `block`",
        ),
        ("action grab = arm.pick(mat, height: 12 cm) for 3 s", "`mat` is fixed"),
        (
            f"action kick = launch(cup, direction: left, speed: 30 cm/s) {PICK}",
            "`kick` moves `cup`, and a plan does not",
        ),
        (f"{PICK} action more = arm.push(cup, direction: left, distance: 5 cm) for 5 s after grab", "holds `cup`"),
        (f"{PICK} action more = arm.rotate(cup, angle: 9 deg) for 1 s at 2 s", "`arm` is still busy when `more`"),
        (
            "action grab = arm.pick(cup, height: 12 cm, at: (24 mm, 22 mm)) for 3.4 s",
            "a finger would come down on `cup`; take it nearer to its middle",
        ),
        (
            f"{DRAWER} action pull = arm.open(knob, joint: rails, far: 19 cm) for 8 s",
            "`rails` would be moved to 19 cm, and stops at 18 cm",
        ),
        (
            f"{DRAWER} action pull = arm.close(knob, joint: rails, far: 2 cm) for 6 s",
            "`rails` would be moved to -2 cm, and stops at -1 cm",
        ),
        (
            f"{DRAWER} action pull = arm.open(cup, joint: rails, far: 3 cm) for 6 s",
            "`rails` does not hold `cup`; name a thing that is joined",
        ),
    ],
)
def test_impossible_arm_action_is_reported_at_its_place(more: str, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        one(more)[0].stage()


def test_fingers_centre_the_gripped_object_in_the_plan() -> None:
    tile = "object tile { shape: box  size: (5 cm, 5 cm, 4 cm)  on: table at (14 cm, 9 cm) }"
    more = f"""{tile} action grab = arm.pick(tile, height: 6 cm, at: (7 mm, 3 mm)) for 3.4 s
      action put = arm.place(tile, on: table, at: (-14 cm, 9 cm)) for 5 s after grab"""
    moved, _ = ended(one(more, horizon=8.6), "pybullet", "tile")
    assert moved == pytest.approx([-0.28, 0, 0], abs=3 * NEAR)


@pytest.mark.parametrize(
    ("shape", "at", "message"),
    [
        (
            "box  size: (5 cm, 5 cm, 4 cm)",
            "(0, 28 mm)",
            "its fingers would close on an edge of `tile` and squeeze it out",
        ),
        ("sphere  size: 6 cm", "(26 mm, 0)", "finger"),
    ],
)
def test_nothing_is_squeezed_out(shape: str, at: str, message: str) -> None:
    tile = f"object tile {{ shape: {shape}  on: table at (14 cm, 9 cm) }}"
    with pytest.raises(SpecError, match=message):
        one(f"{tile} action grab = arm.pick(tile, height: 6 cm, at: {at}) for 3.4 s")[0].stage()


@pytest.mark.parametrize("high", slow_except([4], [4, 12]))
def test_thin_object_is_gripped_above_its_support(high: int) -> None:
    thin = f"object tile {{ shape: box  size: (6 cm, 5 cm, {high} mm)  on: table at (14 cm, 9 cm) }}"
    moved, _ = ended(one(f"{thin} {PICK.replace('cup', 'tile')}", horizon=PICKED), "pybullet", "tile")
    assert moved == pytest.approx([0, 0, 0.12], abs=NEAR)


def test_one_arm_cannot_move_an_object_held_by_two() -> None:
    grips = """action a = left_arm.grasp(plank, at: (-12 cm, 0)) for 3 s
      action b = right_arm.grasp(plank, at: (12 cm, 0)) for 3 s after a
      action c = right_arm.carry(plank, direction: right, distance: 3 cm) for 1 s after b"""
    with pytest.raises(SpecError, match="`left_arm` holds `plank`, too, so `right_arm` cannot carry it"):
        two(grips)[0].stage()


def test_impossible_arm_action_names_the_counterfactual() -> None:
    task = one("""factor height in [6, 12] cm
      action grab = arm.pick(cup, height: height) for 3.4 s
      question "Where?" { answer frame(facing, end)
        counterfactual sudden { action grab.duration: height / 1 m * 1 s } }""")
    with pytest.raises(SpecError, match=r"as fast as it can; .*under this counterfactual, `sudden`"):
        task[0].stage(counterfactual="sudden")


def test_arm_actions_obey_the_law_of_one_factor() -> None:
    task = one("""factor height in [6, 12] cm
      action grab = arm.pick(cup, height: height) for 3.4 s
      question "Where?" { answer frame(facing, end)
        counterfactual other { action grab.height: 18 cm - height }  counterfactual none { without grab } }""")
    design, depend = Design(task.spec), Dependencies(task.spec)
    low, high = (document(task.spec, instance) for instance in design)
    assert low.differing(high)
    assert violations(depend, low, high, "height") == ()
    for change in task.spec.questions[0].counterfactuals:
        other = document(task.spec, design[0], change)
        assert low.differing(other)
        assert violations(depend, low, other, *changed_by(change)) == ()
