"""What is done to bodies, in each engine, against the analytic answer."""

from __future__ import annotations

from math import cos, cosh, pi, sin, sinh

import numpy as np
import pytest

from tests.physics.conftest import Execute
from tests.physics.scenes import UPRIGHT, G, body, floor, scene, turn
from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import (
    Action,
    Follow,
    Force,
    Glide,
    Impulse,
    Launch,
    PassThrough,
    Pose,
    Release,
    Teleport,
    Vanish,
)
from wmspec.sim.scene.model.transform import multiply, rotate
from wmspec.sim.shapes import Box, Sphere

CUBE = Box((0.05,) * 3)
AWAY = Pose(np.array([1.0, 0, 0.05]), turn((0, 0, 1), 0.5))


def test_a_path_is_followed_exactly(execute: Execute) -> None:
    points = np.array([[0, 0, 1], [0.3, 0, 1], [0.3, 0.6, 1.2]])
    turns = np.array([UPRIGHT, turn((0, 0, 1), 1.0), turn((0, 0, 1), 1.0)])
    way = Follow("w", "b", 0.1, np.array([0, 0.25, 0.65]), points, turns)
    trace = execute(scene(body("b", CUBE, (0, 0, 1), motion="kinematic"), duration=1, actions=(way,)))
    t = trace.time - 0.1
    for axis in range(3):
        expected = np.interp(t, way.times, points[:, axis])
        assert np.abs(trace.position[:, 0, axis] - expected).max() < 1e-9
    angle = np.interp(t, [0, 0.25], [0, 1.0])
    assert np.abs(trace.orientation[:, 0, 3] - np.sin(angle / 2)).max() < 1e-9
    assert np.allclose(trace.angular_velocity[(t > 0.01) & (t < 0.24), 0], [0, 0, 4])
    assert np.allclose(trace.linear_velocity[(t > 0.26) & (t < 0.64), 0], [0, 1.5, 0.5])


def test_a_turning_paddle_sweeps_a_ball_along(execute: Execute) -> None:
    """What touches a kinematic body feels its spin: the ball is a bead on a turning wire, x'' = omega² x along it."""
    omega, gap = 2.0, 0.03
    turns = np.array([UPRIGHT, turn((0, 0, 1), omega * pi / 4)])
    way = Follow("w", "paddle", 0.0, np.array([0, pi / 4]), np.zeros((2, 3)), turns)
    paddle = body("paddle", Box((0.4, 0.01, 0.02)), motion="kinematic", friction=0)
    trace = execute(
        scene(paddle, body("ball", Sphere(0.02), (0.2, 0.04, 0), friction=0), gravity=0, duration=0.4, actions=(way,))
    )
    met = next(t for t in np.arange(0, 0.1, 1e-5) if 0.04 * cos(omega * t) - 0.2 * sin(omega * t) < gap)
    x, speed = 0.2 * cos(omega * met) + 0.04 * sin(omega * met), omega * gap
    growth, way_ = cosh(omega * (0.4 - met)), sinh(omega * (0.4 - met))
    x, speed = x * growth + speed / omega * way_, omega * x * way_ + speed * growth
    expected = np.hypot(speed - omega * gap, omega * x)
    assert np.linalg.norm(trace.linear_velocity[-1, 1]) == pytest.approx(expected, rel=0.01)


def test_relocated_body_pushes_nothing(execute: Execute) -> None:
    """The ball lies between the two places; then the cube goes on from where it was put."""
    ball = body("ball", Sphere(0.05), (0.5, 0, 0.05))
    actions = (
        Teleport("t", "b", 0.2011, AWAY.position, AWAY.orientation),
        Glide("g", "b", 0.3, 0.5, np.array([0, 1.0, 0])),
    )
    trace = execute(scene(floor(), ball, body("b", CUBE, (0, 0, 0.05), motion="kinematic"), actions=actions))
    assert np.allclose(trace.position[:48, 2], [0, 0, 0.05])
    assert np.allclose(trace.position[50:72, 2], AWAY.position)
    assert np.allclose(trace.orientation[-1, 2], AWAY.orientation)
    assert np.allclose(trace.position[-1, 2], [1, 0.2, 0.05], atol=1e-9)
    assert np.abs(trace.position[-1, 1] - [0.5, 0, 0.05]).max() < 1e-3


def test_moves_go_on_where_the_last_one_ended(execute: Execute) -> None:
    actions = (
        Glide("g", "b", 0, 0.2, np.array([1.0, 0, 0])),
        Follow("f", "b", 0.2, np.array([0, 0.1]), np.array([[0.2, 0, 0], [0.2, 0, 0.1]])),
        Glide("h", "b", 0.3, 0.4, np.array([0, -1.0, 0])),
    )
    trace = execute(scene(body("b", CUBE, motion="kinematic"), duration=0.5, actions=actions))
    assert np.allclose(trace.position[-1, 0], [0.2, -0.1, 0.1], atol=1e-12)


def test_an_impulse_changes_the_velocity_by_its_share_of_the_mass(execute: Execute) -> None:
    hit = Impulse("i", "b", 0.25, np.array([0.6, 0, 1.2]))
    trace = execute(scene(body("b", CUBE, mass=2.0, velocity=(0, 0.5, 0)), duration=1, actions=(hit,)))
    t = np.maximum(trace.time - 0.25, 0)
    expected = np.stack([0.3 * t, 0.5 * trace.time, 0.6 * t - G * trace.time**2 / 2], axis=1)
    assert np.abs(trace.position[:, 0] - expected).max() < 1e-4
    assert np.abs(trace.angular_velocity[-1]).max() < 1e-5


def test_a_force_accelerates_while_it_lasts(execute: Execute) -> None:
    push = Force("f", "b", 0.2, 0.6, np.array([3.0, 0, 0]))
    cone = body("b", CUBE, mass=1.5, orientation=turn((0, 1, 0), 0.4))
    trace = execute(scene(cone, duration=1, gravity=0, actions=(push,)))
    during, after = np.clip(trace.time - 0.2, 0, 0.4), np.maximum(trace.time - 0.6, 0)
    assert np.abs(trace.position[:, 0, 0] - (during**2 + 0.8 * after)).max() < 1e-4
    assert trace.linear_velocity[-1, 0, 0] == pytest.approx(0.8, abs=1e-4)


def test_a_force_beats_friction_or_does_not(execute: Execute) -> None:
    boxes = [body(f"b{i}", CUBE, (0, i, 0.05)) for i in range(2)]
    pushes = [Force(f"f{i}", f"b{i}", 0, 1, np.array([f * 0.5 * G, 0, 0])) for i, f in enumerate((0.9, 1.2))]
    trace = execute(scene(floor(), *boxes, actions=tuple(pushes)))
    assert abs(trace.position[-1, 1, 0]) < 5e-4
    assert trace.position[-1, 2, 0] == pytest.approx(0.2 * 0.5 * G / 2, rel=0.01)


def test_released_object_falls_from_the_hand(execute: Execute) -> None:
    """A ball that hits it before bounces off as off a wall; a ball on it lies still."""
    held = body("b", CUBE, (0, 0, 2), mass=0.1, velocity=(1, 0, 0), spin=(0, 0, 5), restitution=0.64)
    hitting = body("hit", Sphere(0.05), (-0.2, 0, 2), velocity=(2, 0, 0), mass=3, restitution=1, friction=0)
    lying = body("lying", Sphere(0.02), (0, 0, 2.07))
    trace = execute(scene(held, hitting, lying, duration=1, actions=(Release("r", "b", 0.5),)))
    t = np.maximum(trace.time - 0.5, 0)
    assert np.abs(trace.position[:, 0] - np.stack([0 * t, 0 * t, 2 - G * t**2 / 2], axis=1))[:, :2].max() < 1e-3
    assert np.abs(trace.position[:121, 0] - [0, 0, 2]).max() < 1e-6
    assert np.abs(trace.linear_velocity[:120, 0]).max() < 1e-6
    assert np.abs(trace.position[:, 0, 2] - (2 - G * t**2 / 2)).max() < 2e-3
    assert trace.position[119, 2, 2] == pytest.approx(2.07, abs=5e-4)
    assert trace.linear_velocity[60, 1, 0] == pytest.approx(-0.8 * 2, rel=0.05)


def test_a_long_way_with_turns_is_a_way_of_slerps(execute: Execute) -> None:
    rng = np.random.default_rng(3)
    turns = rng.normal(size=(5, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    points = rng.normal(size=(5, 3))
    way = Follow("w", "b", 0.0, np.array([0, 0.1, 0.25, 0.3, 0.5]), points, turns)
    start = body("b", CUBE, points[0], orientation=turns[0], motion="kinematic")
    trace = execute(scene(start, duration=0.5, actions=(way,)))
    for i, t in enumerate(way.times):
        assert np.allclose(trace.position[trace.sample(t), 0], points[i], atol=1e-9)
        got = trace.orientation[trace.sample(t), 0]
        assert abs(got @ turns[i]) == pytest.approx(1, abs=1e-12)
    middle = trace.orientation[trace.sample(0.4), 0]  # half-way: as far from either end
    assert abs(middle @ turns[3]) == pytest.approx(abs(middle @ turns[4]), abs=1e-9)
    assert np.allclose(rotate(multiply(middle, np.array([1.0, 0, 0, 0])), np.zeros(3)), 0)


WRONG: dict[str, tuple[tuple[Action, ...], str]] = {
    "overlap": (
        (Glide("a", "k", 0, 1, np.zeros(3)), Glide("b", "k", 0.5, 0.8, np.zeros(3))),
        "action b: it starts while a still moves 'k'",
    ),
    "astray": (
        (Follow("a", "k", 0, np.array([0, 1.0]), np.ones((2, 3))),),
        r"action a: its path starts at \[1. 1. 1.\] m, but 'k' is at \[0. 0. 0.\] m",
    ),
    "times": ((Follow("a", "k", 0, np.array([0, 1.0, 1.0]), np.zeros((3, 3))),), "expected increasing times"),
    "held": (
        (Release("a", "d", 0.5), Launch("b", "d", 0.2, np.zeros(3), np.zeros(3))),
        "action b: 'd' is held until 0.5 s",
    ),
    "static": ((Impulse("a", "s", 0, np.zeros(3)),), "'s', which is static, expected a dynamic body"),
    "kinematic": ((Release("a", "k", 0.1),), "'k', which is kinematic, expected a dynamic body"),
}


@pytest.mark.parametrize("case", WRONG)
def test_impossible_actions_are_refused(case: str) -> None:
    from wmspec.sim.scene.validate import validate

    actions, message = WRONG[case]
    bodies = [body("d", CUBE), body("k", CUBE, motion="kinematic"), body("s", CUBE, motion="static")]
    with pytest.raises(WmsError, match=message):
        validate(scene(*bodies, actions=actions))


def test_body_on_a_vanishing_support_falls(execute: Execute) -> None:
    """From when its support is gone, a cube falls freely, for the root of 2 h / g; nothing touches what is gone."""
    support, cube = body("support", CUBE, (0, 0, 0.05)), body("cube", CUBE, (0, 0, 0.15))
    trace = execute(scene(floor(), support, cube, duration=0.6, actions=(Vanish("v", "support", 0.25),)))
    t = trace.time
    assert np.abs(trace.position[t <= 0.25, 2, 2] - 0.15).max() < 1e-3
    falling = (t > 0.25) & (t < 0.25 + np.sqrt(2 * 0.1 / G) - 0.01)
    assert np.abs(trace.position[falling, 2, 2] - (0.15 - G * (t[falling] - 0.25) ** 2 / 2)).max() < 2e-3
    assert trace.position[-1, 2, 2] == pytest.approx(0.05, abs=1e-3)
    assert trace.position[t > 0.26, 1, 2].min() > 100
    assert max(c.stop for c in trace.contacts if {c.first, c.second} == {"support", "cube"}) < 0.27


def test_carried_bodies_may_vanish(execute: Execute) -> None:
    glide = Glide("g", "b", 0.0, 1.0, np.array([1.0, 0, 0]))
    trace = execute(
        scene(body("b", CUBE, (0, 0, 1), motion="kinematic"), duration=1, actions=(glide, Vanish("v", "b", 0.5)))
    )
    t = trace.time
    assert np.abs(trace.position[t < 0.5, 0, 0] - t[t < 0.5]).max() < 1e-9
    assert trace.position[t >= 0.5, 0, 2].min() > 100
    assert not trace.linear_velocity[t >= 0.5].any()


def test_impossible_pass_through_a_wall_continues_undisturbed(execute: Execute) -> None:
    wall = body("wall", Box((0.02, 0.2, 0.2)), (0.5, 0, 0), motion="static")
    ball = body("ball", Sphere(0.05), velocity=(1.0, 0, 0))
    through = PassThrough("p", "ball", "wall", 0.2, 0.8)
    trace = execute(scene(wall, ball, gravity=0, duration=1, actions=(through,)))
    assert np.abs(trace.position[:, 1, 0] - trace.time).max() < 1e-4
    assert not trace.contacts


def test_a_passage_opens_below_what_rests_and_closes_again(execute: Execute) -> None:
    """A cube rests on a plate, falls freely through it once it may, and then lies on the floor; another one stays."""
    plate = body("plate", Box((0.5, 0.2, 0.01)), (0, 0, 0.5), motion="static")
    cubes = [body(name, CUBE, (x, 0, 0.56)) for name, x in (("cube", -0.2), ("other", 0.2))]
    thrown = body("late", Sphere(0.04), (0, 0, 1.0))
    passages = (PassThrough("p", "cube", "plate", 0.5, 2.0), PassThrough("q", "late", "plate", 0.0, 0.1))
    trace = execute(scene(floor(), plate, *cubes, thrown, duration=1.5, actions=passages))
    t, height = trace.time, trace.position[:, 2, 2]
    assert np.abs(height[t <= 0.5] - 0.56).max() < 1e-3
    falling = (t > 0.5) & (t < 0.5 + np.sqrt(2 * 0.51 / G) - 0.01)
    assert np.abs(height[falling] - (0.56 - G * (t[falling] - 0.5) ** 2 / 2)).max() < 3e-3
    assert height[-1] == pytest.approx(0.05, abs=2e-3)
    assert np.abs(trace.position[:, 3, 2] - 0.56).max() < 1e-3
    assert trace.position[-1, 4, 2] == pytest.approx(0.55, abs=2e-3), "it arrives when the passage is closed"
    stops = [c.stop for c in trace.contacts if {c.first, c.second} == {"plate", "cube"}]
    assert max(stops) < 0.52


def test_a_passage_within_another_stays_open(execute: Execute) -> None:
    wall = body("wall", Box((0.02, 0.2, 0.2)), (0.5, 0, 0), motion="static")
    ball = body("ball", Sphere(0.05), velocity=(1.0, 0, 0))
    passages = (PassThrough("p", "ball", "wall", 0.0, 0.9), PassThrough("q", "ball", "wall", 0.1, 0.3))
    trace = execute(scene(wall, ball, gravity=0, duration=1, actions=passages))
    assert np.abs(trace.position[:, 1, 0] - trace.time).max() < 1e-4


def test_a_glide_goes_on_from_where_a_teleport_puts_the_body(execute: Execute) -> None:
    glide = Glide("g", "b", 0.1, 0.9, np.array([1.0, 0, 0]))
    jump = Teleport("t", "b", 0.5, np.array([2.0, 1.0, 1.0]))
    trace = execute(scene(body("b", CUBE, (0, 0, 1), motion="kinematic"), duration=1, actions=(glide, jump)))
    t = trace.time
    assert np.abs(trace.position[t < 0.5, 0, 0] - np.clip(t[t < 0.5] - 0.1, 0, None)).max() < 1e-9
    after = trace.position[t > 0.5, 0]
    assert np.abs(after[:, 0] - (2.0 + np.clip(t[t > 0.5] - 0.5, 0, 0.4))).max() < 1e-9
    assert np.allclose(after[:, 1:], 1.0)


@pytest.mark.parametrize("turned", [None, turn((0, 0, 1), 1.0)])
def test_flight_continues_from_a_teleport(execute: Execute, turned: np.ndarray | None) -> None:
    """It falls and spins as before: positions and speeds are those of the flight, 2 m to the side."""
    flying = body("b", CUBE, (0, 0, 5), velocity=(1.0, 0, 2.0), spin=(0, 0, 3.0))
    jump = Teleport("t", "b", 0.3011, np.array([1.0, 2.0, 4.0]), turned)
    trace = execute(scene(flying, duration=0.6, actions=(jump,)))
    t, at = trace.time, 0.3011
    flight = np.stack([t, 0 * t, 5 + 2 * t - G * t**2 / 2], axis=1)
    start = np.array([at, 0, 5 + 2 * at - G * at**2 / 2])
    there = np.where((t < at)[:, None], flight, flight - start + [1.0, 2.0, 4.0])
    assert np.abs(trace.position[:, 0] - there).max() < 0.005, "jumps are at whole steps of the engine"
    assert np.abs(trace.linear_velocity[:, 0] - [[1, 0, 2 - G * s] for s in t]).max() < 0.02
    assert np.allclose(trace.angular_velocity[:, 0], [0, 0, 3.0], atol=5e-3)
    after = 3 * t if turned is None else 1.0 + 3 * (t - at)
    angle = np.where(t < at, 3 * t, after)
    assert np.abs(trace.orientation[:, 0, 3] - np.sin(angle / 2)).max() < 0.01


def test_relocated_body_keeps_rolling_and_wakes_others(execute: Execute) -> None:
    ball = body("ball", Sphere(0.05), (0, 0, 0.05), velocity=(1.0, 0, 0), spin=(0, 20.0, 0))
    rests = body("rests", CUBE, (0, 2, 0.05))
    wall = body("wall", Box((0.02, 0.2, 0.2)), (0.8, 1.0, 0.2), motion="static")
    jumps = (
        Teleport("t", "ball", 0.3, np.array([0, 1.0, 0.05])),
        Teleport("u", "rests", 0.3, np.array([0, 3.0, 0.55])),
    )
    trace = execute(scene(floor(), ball, rests, wall, duration=1.2, actions=jumps))
    names = trace.bodies
    x, before = trace.position[:, names.index("ball")], trace.time < 0.3
    assert np.allclose(x[before, 0], trace.time[before], atol=0.01)
    assert np.allclose(x[~before & (trace.time < 0.9), 0], trace.time[~before & (trace.time < 0.9)] - 0.3, atol=0.01)
    (met,) = [c.start for c in trace.contacts if {c.first, c.second} == {"ball", "wall"}]
    assert met == pytest.approx(0.3 + 0.73, abs=0.02)
    z = trace.position[:, names.index("rests"), 2]
    falling = (trace.time >= 0.3) & (trace.time < 0.6)
    assert np.allclose(z[falling], 0.55 - G * (trace.time[falling] - 0.3) ** 2 / 2, atol=0.01)
    assert z[-1] == pytest.approx(0.05, abs=2e-3)


def test_a_body_cannot_be_teleported_while_it_is_held(execute: Execute) -> None:
    jump = Teleport("t", "b", 0.1, np.array([1.0, 0, 1.0]))
    with pytest.raises(WmsError, match=r"'b' is held until 0.2 s"):
        execute(scene(body("b", CUBE, (0, 0, 1)), actions=(jump, Release("r", "b", 0.2))))


@pytest.mark.parametrize("way", [0.0, 0.7])
def test_belt_carries_objects_and_stays(execute: Execute, way: float) -> None:
    """It drags the load along by friction until the load is as fast as its surface, which runs along its own x axis."""
    v, mu = 0.5, 0.4
    belt = body(
        "belt", Box((2.0, 0.5, 0.05)), motion="kinematic", friction=mu, orientation=turn((0, 0, 1), way), belt=(v, 0, 0)
    )
    load = body("load", CUBE, (0, 0, 0.1), friction=mu, orientation=turn((0, 0, 1), way))
    other = body("other", Box((2.0, 0.5, 0.05)), (0, 2, 0), motion="kinematic", friction=mu)
    left = body("left", CUBE, (0, 2, 0.1), friction=mu)
    trace = execute(scene(belt, load, other, left, duration=1))
    begun = v / (mu * G)
    t = trace.time
    carried = np.where(t < begun, mu * G * t**2 / 2, v * (t - begun / 2))
    along = np.array([cos(way), sin(way), 0])
    assert np.abs(trace.position[:, 1] @ along - carried).max() < 4e-3
    assert trace.linear_velocity[-1, 1] == pytest.approx(v * along, abs=5e-3)
    assert np.abs(trace.position[:, 0] - trace.position[0, 0]).max() < 1e-9, "the belt stays"
    assert np.abs(trace.position[:, 3] - trace.position[0, 3]).max() < 1e-3, "one whose surface rests moves nothing"
