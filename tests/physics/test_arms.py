"""Arms pick, push, lift, turn, put down and let go alike in every engine, and stages say how."""

from math import radians

import numpy as np
import pytest

import wmspec
from tests.engines import installed
from wmspec.design.depend import Dependencies
from wmspec.design.design import Design
from wmspec.diagnostics import EngineError, SpecError
from wmspec.robots.arm import down
from wmspec.robots.franka import PANDA
from wmspec.robots.ik import solve
from wmspec.stage.episode import document
from wmspec.stage.one_factor import changed_by, violations

ENGINES = ("mujoco", "pybullet", "sapien")
NEAR = 1e-4  # m
TURN = radians(0.05)

ONE = """use tabletop_arm
task one : custom {{
  object cup {{ shape: box  size: (6 cm, 5 cm, 6 cm)  density: {density} kg/m^3  friction: {friction}
                on: table at (-4 cm, -3 cm) }}
  object mat {{ shape: box  size: (16 cm, 16 cm, 1 cm)  on: table at (14 cm, -3 cm)  fixed: true }}
  {more}
  horizon 10.6 s
  observe facing at [0 s]
}}"""
TWO = """use tabletop_arms
task two : custom {{
  object plank {{ shape: box  size: {size}  on: table at (2 cm, 3 cm) }}
  {more}
  horizon 6.4 s
  observe facing at [0 s]
}}"""
PICK = "action grab = arm.pick(cup, height: 12 cm) for 3.4 s"
BOTH = """action a = left_arm.lift(plank, height: {low}) for 3.4 s
  action b = right_arm.lift(plank, height: {high}) for 3.4 s with a"""


def one(more: str, density: float = 500, friction: float = 0.5) -> wmspec.Task:
    """A task with one arm."""
    return wmspec.load(text=ONE.format(more=more, density=density, friction=friction))


def ended(task: wmspec.Task, engine: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """How far something has moved, and its orientation at the end."""
    installed(engine)
    run = task[0].run(engine)
    return run[name].position[-1] - run[name].position[0], run[name].orientation[-1]


def turned(orientation: np.ndarray, angle: float, axis: int = 3) -> float:
    """By how much an orientation is off a turn about an axis (its number in the quaternion)."""
    wanted = np.zeros(4)
    wanted[0], wanted[axis] = np.cos(angle / 2), np.sin(angle / 2)
    return float(2 * np.arccos(min(1.0, abs(wanted @ orientation))))


@pytest.mark.parametrize("engine", ENGINES)
def test_what_is_picked_is_as_high_as_was_said(engine: str) -> None:
    moved, orientation = ended(one(PICK), engine, "cup")
    assert moved == pytest.approx([0, 0, 0.12], abs=NEAR)
    assert turned(orientation, 0.0) < TURN


@pytest.mark.parametrize("engine", ENGINES)
def test_it_is_turned_and_put_down_elsewhere(engine: str) -> None:
    more = f"""{PICK}
      action twist = arm.rotate(cup, angle: 40 deg) for 2 s after grab
      action put = arm.place(cup, on: mat, at: (1 cm, 2 cm)) for 5 s after twist"""
    moved, orientation = ended(one(more), engine, "cup")
    assert moved == pytest.approx([0.19, 0.02, 0.01], abs=2 * NEAR)
    assert turned(orientation, radians(40)) < TURN


@pytest.mark.parametrize("engine", ENGINES)
def test_it_falls_when_the_hand_opens(engine: str) -> None:
    moved, _ = ended(one(PICK + "\naction open = arm.drop(cup) after grab"), engine, "cup")
    assert moved == pytest.approx([0, 0, 0], abs=1.2e-3)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("way", "step"), [("left", (-0.1, 0)), ("away", (0, 0.1)), ("nearer", (0, -0.1))])
def test_what_is_pushed_goes_where_it_is_pushed(engine: str, way: str, step: tuple[float, float]) -> None:
    moved, _ = ended(one(f"action shove = arm.push(cup, direction: {way}, distance: 10 cm) for 5 s"), engine, "cup")
    assert moved == pytest.approx([*step, 0], abs=1.5e-3)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("density", "friction"), [(80_000, 0.5), (3000, 0.0001)])
def test_what_is_too_heavy_or_too_smooth_slips(engine: str, density: float, friction: float) -> None:
    moved, _ = ended(one(PICK, density, friction), engine, "cup")
    assert abs(moved[2]) < 2 * NEAR


@pytest.mark.parametrize("engine", ENGINES)
def test_what_is_held_back_tears_loose_and_is_told(engine: str) -> None:
    installed(engine)
    stop = "object stop { shape: box  size: (3 cm, 8 cm, 6 cm)  on: table at (1.5 cm, -3 cm)  fixed: true }"
    more = f"""{stop} action grab = arm.pick(cup, height: 2 cm) for 3.4 s
      action go = arm.carry(cup, direction: right, distance: 25 mm) for 1 s after grab"""
    with pytest.raises(EngineError, match=r"hand loses hold of .*/cup at \d\.\d+ s"):
        one(more)[0].run(engine)


def test_no_hand_goes_through_a_thing() -> None:
    lid = "object lid { shape: box  size: (8 cm, 3 cm, 2 cm)  at: (-4 cm, -3 cm, 12 cm)  fixed: true }"
    with pytest.raises(SpecError, match="its hand would go through `lid`"):
        one(f"{lid} {PICK}")[0].stage()


@pytest.mark.parametrize("engine", ENGINES)
def test_two_arms_lift_a_plank_by_its_ends(engine: str) -> None:
    task = wmspec.load(text=TWO.format(size="(34 cm, 7 cm, 3 cm)", more=BOTH.format(low="4 cm", high="10 cm")))
    moved, orientation = ended(task, engine, "plank")
    assert moved == pytest.approx([0, 0, 0.07], abs=2 * NEAR)
    assert turned(orientation, -np.arcsin(0.06 / 0.29), axis=2) < TURN


@pytest.mark.parametrize("engine", ENGINES)
def test_one_arm_lifts_one_end_and_the_other_stays(engine: str) -> None:
    only = BOTH.format(low="10 cm", high="4 cm").splitlines()[0]
    task = wmspec.load(text=TWO.format(size="(34 cm, 7 cm, 3 cm)", more=only))
    moved, orientation = ended(task, engine, "plank")
    angle = float(np.arcsin(0.1 / 0.315))
    assert turned(orientation, angle, axis=2) < 4 * TURN
    middle = 0.17 * np.sin(angle) + 0.015 * np.cos(angle) - 0.015
    assert moved[2] == pytest.approx(middle, abs=1e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_two_arms_push_by_the_sum(engine: str) -> None:
    more = """action a = left_arm.push(plank, direction: right, distance: 8 cm) for 6 s
      action b = right_arm.push(plank, direction: nearer, distance: 10 cm) for 6 s with a"""
    moved, orientation = ended(wmspec.load(text=TWO.format(size="(14 cm, 14 cm, 8 cm)", more=more)), engine, "plank")
    assert moved == pytest.approx([0.08, -0.1, 0], abs=1e-3)
    assert turned(orientation, 0.0) < radians(0.2)


def test_the_tool_comes_where_it_is_sent() -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        x, y = rng.uniform(0.32, 0.62), rng.uniform(-0.3, 0.3)
        target = down(x, y, rng.uniform(0.02, 0.25), rng.uniform(-0.6, 0.6))
        q = solve(PANDA, target, np.eye(4), PANDA.home)
        assert q is not None
        assert (PANDA.low <= q).all()
        assert (q <= PANDA.high).all()
        assert PANDA.tool(q, np.eye(4)) == pytest.approx(target, abs=2e-6)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("action grab = arm.pick(cup, height: 12 cm) for 1 s", "times as fast as it can; give it more time"),
        ("action grab = arm.pick(mat, height: 12 cm) for 3 s", "`mat` is fixed"),
        (f"{PICK} action more = arm.push(cup, direction: left, distance: 5 cm) for 5 s after grab", "holds `cup`"),
        (f"{PICK} action more = arm.rotate(cup, angle: 9 deg) for 1 s at 2 s", "`arm` is still busy when `more`"),
    ],
)
def test_what_an_arm_cannot_do_is_told_where_it_stands(more: str, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        one(more)[0].stage()


def test_what_arms_do_obeys_the_law_of_one_factor() -> None:
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
