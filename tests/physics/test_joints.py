"""Joints in each engine against the analytic answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import pi, sin, sqrt

import numpy as np
import pytest

from tests.engines import ENGINES, installed
from tests.physics.conftest import Execute
from tests.physics.scenes import UPRIGHT, G, body, floor, scene, turn
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.compare.regimes import _energy, _rotor_energy
from wmspec.runtime.engines.registry import info
from wmspec.sim.scene.capability import approximation_warnings
from wmspec.sim.scene.model import (
    Array,
    Body,
    Drive,
    Force,
    Impulse,
    Joint,
    JointKind,
    Launch,
    Pose,
    Release,
    Steer,
    Teleport,
    Trace,
)
from wmspec.sim.scene.model.transform import compose, inverse, rotate
from wmspec.sim.shapes import Box, Sphere

ALONG_Y = turn((0, 0, 1), pi / 2)  # turns x to y
DOWN = turn((0, 1, 0), pi / 2)  # turns x to -z


def joint(
    name: str, kind: JointKind, first: Body | None, second: Body, at: object, axis: Array = ALONG_Y, **more: object
) -> Joint:
    """A joint at a place, its axis along x turned by `axis`, both in the world."""
    here = Pose(np.array(at, float), axis)
    frames = [compose(inverse(b.pose), here) if b else here for b in (first, second)]
    return Joint(name, f"/World/{name}", kind, first.name if first else None, second.name, *frames, **more)  # type: ignore[arg-type]


def rod(name: str = "rod", angle: float = 0.0, at: object = (0, 0, 0), length: float = 1.0) -> Body:
    """A rod that hangs from a place, turned out of the vertical by an angle about y."""
    out = turn((0, 1, 0), angle)
    middle = np.array(at, float) + rotate(out, np.array([0, 0, -length / 2]))
    return body(name, Box((0.02, 0.02, length / 2)), middle, orientation=out)


def period(trace: Trace, index: int, axis: int = 0) -> float:
    """The mean time between every second change of sign of a coordinate."""
    x, t = trace.position[:, index, axis], trace.time
    i = np.flatnonzero(x[:-1] * x[1:] < 0)
    crossings = t[i] - x[i] / (x[i + 1] - x[i]) * (t[1] - t[0])
    return float(2 * np.diff(crossings).mean())


def swing(amplitude: float, length: float = 1.0) -> float:
    """The period of a rod that swings about its end (series in the amplitude to fourth order)."""
    small = 2 * pi * sqrt((length**2 / 3 + 0.02**2 / 3) / (G * length / 2))
    return small * (1 + amplitude**2 / 16 + 11 * amplitude**4 / 3072)


@pytest.mark.parametrize("turned_round", [False, True])
def test_the_period_of_a_pendulum(execute: Execute, turned_round: bool) -> None:
    hanging = rod(angle=0.3)
    hinge = joint("hinge", "hinge", None, hanging, (0, 0, 0))
    if turned_round:
        post = body("post", Box((0.01,) * 3), (0, 0.5, 0), motion="static")
        hinge = joint("hinge", "hinge", hanging, post, (0, 0, 0))
        trace = execute(scene(post, hanging, duration=6, joints=(hinge,)))
    else:
        trace = execute(scene(hanging, duration=6, joints=(hinge,)))
    assert period(trace, -1) == pytest.approx(swing(0.3), rel=2e-4)
    assert np.abs(trace.position[:, -1, 1]).max() < 1e-5
    reach = np.linalg.norm(trace.position[:, -1], axis=1)
    assert np.abs(reach - 0.5).max() < 1e-5
    moved = np.gradient(trace.position[:, -1], trace.time, axis=0)
    assert np.abs(moved - trace.linear_velocity[:, -1])[2:-2].max() < 2e-3


def test_a_ball_joint_swings_as_a_pendulum_in_any_plane(execute: Execute) -> None:
    hanging = rod(angle=0.3)
    trace = execute(scene(hanging, duration=6, joints=(joint("ball", "ball", None, hanging, (0, 0, 0)),)))
    assert period(trace, 0) == pytest.approx(swing(0.3), rel=5e-4)
    assert np.abs(np.linalg.norm(trace.position[:, 0], axis=1) - 0.5).max() < 1e-4


def test_a_slider_falls_along_its_axis(execute: Execute) -> None:
    """On a track 30 degrees below the horizontal; it stops at its limit."""
    axis = turn((0, 1, 0), pi / 6)
    load = body("load", Box((0.05,) * 3), (0, 0, 1))
    slider = joint("slider", "slider", None, load, (0, 0, 1), axis, limits=(-0.1, 0.8))
    trace = execute(scene(load, duration=1, joints=(slider,)))
    way = (trace.position[:, 0] - [0, 0, 1]) @ rotate(axis, np.array([1.0, 0, 0]))
    free = G * sin(pi / 6) * trace.time**2 / 2
    assert np.abs(way - free)[free < 0.78].max() < 2e-4
    assert way[-1] == pytest.approx(0.8, abs=2e-3)
    assert way.max() < 0.81
    assert np.abs(np.cross(trace.position[:, 0] - [0, 0, 1], rotate(axis, np.array([1.0, 0, 0])))).max() < 1e-5
    assert np.abs(trace.orientation[:, 0] - UPRIGHT).max() < 1e-5


def test_fixed_joint_merges_two_bodies(execute: Execute) -> None:
    """Two cubes thrown by an impulse on one of them turn about their common middle."""
    a, b = body("a", Box((0.05,) * 3)), body("b", Box((0.05,) * 3), (0.3, 0, 0))
    hit = Impulse("hit", "b", 0, np.array([0, 1.0, 0]))
    trace = execute(
        scene(a, b, gravity=0, duration=1, joints=(joint("weld", "fixed", a, b, (0.1, 0, 0)),), actions=(hit,))
    )
    middle = trace.position[:, :2].mean(axis=1)
    assert np.abs(middle - np.stack([0.15 + 0 * trace.time, trace.time / 2, 0 * trace.time], axis=1)).max() < 1e-3
    inertia = 2 * (2 / 3 * 0.05**2 + 0.15**2)
    assert trace.angular_velocity[-1, 0, 2] == pytest.approx(0.15 / inertia, rel=2e-3)
    apart = np.linalg.norm(trace.position[:, 1] - trace.position[:, 0], axis=1)
    assert np.abs(apart - 0.3).max() < 1e-5


@pytest.mark.parametrize("limits", [None, (-0.5, 0.6)])
def test_a_hinge_keeps_its_limits(execute: Execute, limits: tuple[float, float] | None) -> None:
    """Without limits the lid falls through half a turn and more; with them it comes to rest at one."""
    lid = rod(angle=3.0)
    hinge = joint("hinge", "hinge", None, lid, (0, 0, 0))
    trace = execute(scene(lid, duration=3, joints=(replace(hinge, limits=limits),)))
    angle = 2 * np.unwrap(np.arctan2(trace.orientation[:, 0, 2], trace.orientation[:, 0, 0])) - 3.0
    if limits:
        assert angle.min() > limits[0] - 0.02
        assert angle.max() < limits[1] + 0.02
        assert angle[-1] == pytest.approx(limits[1] if angle[-1] > 0 else limits[0], abs=0.01)
    else:
        assert np.abs(angle).max() > 2.5


@pytest.mark.parametrize("share", [0.2, 2.0])
@pytest.mark.parametrize("engine", [e for e in ENGINES if e != "pybullet"])
def test_an_armature_slows_a_pendulum_and_a_fall(engine: str, share: float) -> None:
    """Its inertia is added to that of the bodies, but not its weight."""
    execute, hanging = installed(engine).execute, rod(angle=0.4)
    inertia = 1.0**2 / 3 + 0.02**2 / 3
    hinge = joint("j", "hinge", None, hanging, (0, 0, 0), armature=share * inertia)
    trace = execute(scene(hanging, duration=8, joints=(hinge,)))
    assert period(trace, 0) == pytest.approx(sqrt(1 + share) * swing(0.4), rel=2e-3)
    load = body("load", Box((0.05,) * 3), mass=2.0)
    rail = joint("j", "slider", None, load, (0, 0, 0), DOWN, armature=share * 2.0)
    trace = execute(scene(load, duration=0.5, joints=(rail,)))
    assert trace.position[-1, 0, 2] == pytest.approx(-G * 0.5**2 / 2 / (1 + share), rel=2e-3)


@pytest.mark.parametrize(
    ("kind", "axis", "spin", "speed"),
    [("hinge", turn((0, 1, 0), -pi / 2), 9.0, 3.2), ("slider", turn((0, 0, 1), 0.3), 5.0, 2.0)],
)
def test_rotors_have_their_part_of_the_energy(kind: JointKind, axis: Array, spin: float, speed: float) -> None:
    """A free body spins, and moves a second one on a joint with an armature."""
    base = replace(body("base", Box((0.2, 0.1, 0.1)), mass=1.0), angular_velocity=np.array([0, 0, 5.0]))
    load = body("load", Box((0.05,) * 3), (0.4, 0, 0), mass=1.0, velocity=(0, speed, 0))
    load = replace(load, angular_velocity=np.array([0, 0, spin]))
    held = joint("j", kind, base, load, (0.1, 0, 0), axis, armature=2.0)
    spun = scene(base, load, duration=0.5, gravity=0, joints=(held,))
    trace = installed("mujoco").execute(spun)
    rotor = _rotor_energy(spun, trace, held)
    total = rotor + sum(_energy(spun, trace, i)[0] for i in (0, 1))
    assert rotor.max() > 0.05 * total[0]
    assert np.abs(total / total[0] - 1).max() < 0.02


def test_pybullet_leaves_out_small_armatures_and_refuses_others() -> None:
    execute, load = installed("pybullet").execute, body("load", Box((0.05,) * 3), mass=2.0)
    rail = joint("j", "slider", None, load, (0, 0, 0), DOWN, armature=0.1)
    with pytest.raises(
        WmsError, match=r"/World/j: an armature of 0.1, 4.8 % of what the joint moves; PyBullet has none"
    ):
        execute(scene(load, joints=(rail,)))
    small = scene(load, joints=(replace(rail, armature=0.01),))
    without = scene(load, joints=(replace(rail, armature=0.0),))
    assert (execute(small).position == execute(without).position).all()
    (warning,) = approximation_warnings(info("pybullet").lacks, small)
    assert "an armature of 0.01, 0.5 % of what the joint moves (PyBullet has none; it is left out)" in warning.message


def test_a_drive_settles_where_spring_and_weight_balance(execute: Execute) -> None:
    """The slider sags by m g / k; after it is steered, by the same below the new target. Overdamped on the way."""
    load = body("load", Box((0.05,) * 3), (0, 0, 1), mass=2.0)
    up = turn((0, 1, 0), -pi / 2)
    drive = Drive(stiffness=400.0, damping=80.0, target=0.2)
    lift = joint("lift", "slider", None, load, (0, 0, 1), up, drive=drive)
    trace = execute(scene(load, duration=3, joints=(lift,), actions=(Steer("go", "lift", 1.5, -0.1),)))
    sag = 2 * G / 400
    assert trace.position[trace.sample(1.5), 0, 2] == pytest.approx(1.2 - sag, abs=5e-4)
    assert trace.position[-1, 0, 2] == pytest.approx(0.9 - sag, abs=5e-4)
    rate = (80 - sqrt(80**2 - 4 * 2 * 400)) / 4
    decay = np.log((trace.position[240, 0, 2] - 1.2 + sag) / (trace.position[120, 0, 2] - 1.2 + sag))
    assert decay == pytest.approx(-rate / 2, rel=0.02)


def test_a_drive_swings_as_a_damped_spring(execute: Execute) -> None:
    """Underdamped, from rest, half a metre from its target, without gravity."""
    load = body("load", Box((0.05,) * 3), mass=0.5)
    rail = joint("rail", "slider", None, load, (0, 0, 0), UPRIGHT, drive=Drive(50.0, 1.0, 0.5))
    trace = execute(scene(load, duration=1, gravity=0, joints=(rail,)))
    decay, rate = 1.0, sqrt(50 / 0.5 - 1)
    left = np.exp(-decay * trace.time) * (np.cos(rate * trace.time) + decay / rate * np.sin(rate * trace.time))
    assert np.abs(trace.position[:, 0, 0] - 0.5 * (1 - left)).max() < 1e-3


def test_a_drive_of_speed_turns_a_wheel_and_gives_up_above_its_force(execute: Execute) -> None:
    wheel = body("wheel", Box((0.1, 0.02, 0.1)))
    turning = joint("axle", "hinge", None, wheel, (0, 0, 0), drive=Drive(0.0, 5.0, velocity=3.0))
    trace = execute(scene(wheel, duration=1, joints=(turning,)))
    assert np.abs(trace.angular_velocity[-1, 0] - [0, 3, 0]).max() < 1e-3
    weak = replace(turning, drive=Drive(0.0, 5.0, velocity=100.0, max_force=0.01))
    trace = execute(scene(wheel, duration=1, joints=(weak,)))
    assert trace.angular_velocity[-1, 0, 1] == pytest.approx(0.01 / (2 * 0.1**2 / 3), rel=2e-3)


def test_a_double_pendulum_keeps_its_energy(execute: Execute) -> None:
    upper, lower = rod("upper", 1.0), rod("lower", -0.5, rotate(turn((0, 1, 0), 1.0), np.array([0, 0, -1.0])))
    elbow = rotate(turn((0, 1, 0), 1.0), np.array([0, 0, -1.0]))
    joints = (joint("shoulder", "hinge", None, upper, (0, 0, 0)), joint("elbow", "hinge", lower, upper, elbow))
    trace = execute(scene(lower, upper, duration=2, joints=joints))
    inertia = np.array([1.0, 1.0, 0.02**2 * 2]) / 3
    inertia[:2] = (0.5**2 + 0.02**2) / 3
    kinetic = (trace.linear_velocity**2).sum(axis=(1, 2)) / 2 + (trace.angular_velocity[..., 1] ** 2).sum(
        axis=1
    ) * inertia[1] / 2
    energy = kinetic + G * trace.position[..., 2].sum(axis=1)
    assert np.abs(energy - energy[0]).max() < 0.015 * kinetic.max()
    gap = (
        trace.position[:, 0]
        + rotate(trace.orientation[:, 0], np.array([0, 0, 0.5]))
        - (trace.position[:, 1] + rotate(trace.orientation[:, 1], np.array([0, 0, -0.5])))
    )
    assert np.abs(gap).max() < 1e-4


@pytest.mark.parametrize("kind", ["hinge", "ball", "slider"])
def test_a_tree_without_anchor_falls_as_a_whole(execute: Execute, kind: JointKind) -> None:
    """Its middle falls freely, and a push at one of its bodies moves the middle by the force on the whole mass."""
    bodies = [body(n, Box((0.1, 0.03, 0.02)), (0.25 * i, 0, 2), mass=1 + i) for i, n in enumerate("abc")]
    joints = tuple(joint(f"j{i}", kind, bodies[i], bodies[i + 1], (0.25 * i + 0.125, 0, 2)) for i in range(2))
    push = Force("push", "c", 0.1, 0.3, np.array([0, 0, 12.0]))
    trace = execute(scene(*bodies, duration=0.6, joints=joints, actions=(push,)))
    middle = (
        trace.position @ np.array([[1]] * 3)[0] if False else (trace.position * np.array([1, 2, 3])[:, None]).sum(1) / 6
    )
    t, during = trace.time, np.clip(trace.time - 0.1, 0, 0.2)
    lifted = 2 * during * (during / 2 + np.maximum(trace.time - 0.3, 0))
    expected = middle[0] + np.stack([0 * t, 0 * t, lifted - G * t**2 / 2], axis=1)
    assert np.abs(middle - expected).max() < 1e-3


def test_a_held_pendulum_swings_from_its_release(execute: Execute) -> None:
    hanging = rod(angle=0.3)
    hinge = joint("hinge", "hinge", None, hanging, (0, 0, 0))
    trace = execute(scene(hanging, duration=6, joints=(hinge,), actions=(Release("go", "rod", 0.5),)))
    assert np.abs(trace.position[:121, 0] - trace.position[0, 0]).max() < 1e-6
    assert period(trace, 0) == pytest.approx(swing(0.3), rel=2e-4)
    quarter = trace.position[trace.sample(0.5 + swing(0.3) / 4), 0, 0]
    assert abs(quarter) < 0.01


def test_bodies_of_a_tree_touch_others_but_not_their_neighbours(execute: Execute) -> None:
    """Two boxes that overlap at their hinge stay as they are; the chain lies on the floor, and a ball on the chain."""
    a, b = (body(n, Box((0.11, 0.05, 0.05)), (0.2 * i, 0, 0.05)) for i, n in enumerate("ab"))
    ball = body("ball", Sphere(0.03), (0.2, 0, 0.131))
    trace = execute(scene(floor(), a, b, ball, duration=0.5, joints=(joint("j", "hinge", a, b, (0.1, 0, 0.05)),)))
    assert np.abs(trace.position[-1] - trace.position[0]).max() < 1.5e-3
    met = {(c.first, c.second) for c in trace.contacts}
    assert met == {("floor", "a"), ("floor", "b"), ("b", "ball")}


def test_a_pendulum_strikes_a_ball(execute: Execute) -> None:
    """An elastic impact of equal inertia: the ball leaves with the speed of the bob, m l² = I."""
    bob = body("bob", Sphere(0.05), (-0.5 * sin(1.0), 0, 1 - 0.5 * np.cos(1.0)), mass=1, restitution=1, friction=0)
    ball = body("ball", Sphere(0.05), (0.1, 0, 0.5), mass=1, restitution=1, friction=0)
    pivot = joint("pivot", "hinge", None, bob, (0, 0, 1))
    shelf = body("shelf", Box((1, 1, 0.05)), (0.1 + 0.95, 0, 0.4), motion="static", friction=0)
    trace = execute(scene(bob, ball, shelf, duration=1, joints=(pivot,), actions=()))
    inertia = 0.4 * 0.05**2 + 0.5**2
    speed = sqrt(2 * G * 0.5 * (1 - np.cos(1.0)) / inertia) * 0.5
    mass = inertia / 0.5**2
    assert trace.linear_velocity[-1, 1, 0] == pytest.approx(2 * mass / (mass + 1) * speed, rel=0.03)


def test_filtered_pairs_pass_through_each_other(execute: Execute) -> None:
    balls = [body(f"b{i}", Sphere(0.05), (0, 0.5 * i, 0.3)) for i in range(3)]
    boxes = [body(f"x{i}", Box((0.05,) * 3), (0, 0.5 * i, 0.05)) for i in range(3)]
    world = scene(floor(), *balls, *boxes, duration=0.6)
    pairs = (("b0", "x0"), ("floor", "b1"), ("b1", "x1"))
    trace = execute(replace(world, filtered=pairs))
    assert trace.position[-1, 1:4, 2] == pytest.approx([0.05, 0.3 - G * 0.6**2 / 2, 0.15], abs=2e-3)
    assert ("b0", "x0") not in {(c.first, c.second) for c in trace.contacts}


def test_jointed_bodies_collide_if_enabled(engine: str, execute: Execute) -> None:
    """A lid on a hinge in the air falls until it meets the box that it is hinged to."""
    box = body("box", Box((0.1, 0.1, 0.1)), (0, 0, 0.1), mass=50)
    lid = body("lid", Box((0.1, 0.1, 0.01)), (-0.11, 0, 0.31), orientation=turn((0, 1, 0), -pi / 2))
    hinge = joint("hinge", "hinge", box, lid, (-0.11, 0, 0.2), collides=True)
    push = Impulse("push", "lid", 0, np.array([0.6, 0, 0]))
    play = scene(floor(), box, lid, duration=1, joints=(hinge,), actions=(push,))
    if engine == "sapien":
        with pytest.raises(WmsError, match="/World/hinge: the bodies of a joint that touch each other; PhysX"):
            execute(play)
        return
    trace = execute(play)
    assert ("box", "lid") in {(c.first, c.second) for c in trace.contacts}
    assert trace.position[-1, 2, 2] > 0.2


WRONG: dict[str, tuple[Callable[[Body, Body], tuple[Joint, ...]], str]] = {
    "loop of sliders": (
        lambda a, b: (joint("j", "slider", a, b, (0, 0, 0)), joint("k", "slider", b, a, (0, 0, 0))),
        "/World/k: it closes a loop",
    ),
    "frames": (
        lambda a, b: (replace(joint("j", "hinge", a, b, (0, 0, 0)), first_frame=Pose(np.ones(3), UPRIGHT)),),
        "/World/j: its two frames are",
    ),
    "limits": (
        lambda a, b: (joint("j", "hinge", a, b, (0, 0, 0), limits=(0.5, 1.0)),),
        "/World/j: it starts at 0, outside its limits",
    ),
    "driven ball": (
        lambda a, b: (joint("j", "ball", a, b, (0, 0, 0), drive=Drive(1, 1)),),
        "/World/j: a ball joint does not have exactly one coordinate",
    ),
    "itself": (lambda a, b: (joint("j", "ball", a, a, (0, 0, 0)),), "/World/j: it joins a and a"),
}


@pytest.mark.parametrize("case", WRONG)
def test_joints_that_make_no_sense_are_refused(execute: Execute, case: str) -> None:
    make, message = WRONG[case]
    a, b = body("a", Box((0.1,) * 3)), body("b", Box((0.1,) * 3), (0.3, 0, 0))
    with pytest.raises(WmsError, match=message):
        execute(scene(a, b, joints=make(a, b)))


def test_impossible_actions_on_jointed_bodies_are_refused(execute: Execute) -> None:
    a, b = body("a", Box((0.1,) * 3)), body("b", Box((0.1,) * 3), (0.3, 0, 0), velocity=(1, 0, 0))
    hinge = joint("j", "hinge", None, a, (0, 0, 0))
    with pytest.raises(WmsError, match="'a' has joints; give it an impulse"):
        execute(scene(a, joints=(hinge,), actions=(Launch("go", "a", 0, np.zeros(3), np.zeros(3)),)))
    with pytest.raises(WmsError, match="'a' has joints; only bodies without joints can be teleported"):
        execute(scene(a, joints=(hinge,), actions=(Teleport("go", "a", 0, np.ones(3)),)))
    with pytest.raises(WmsError, match=r"/World/b: .* violate its joints"):
        execute(scene(b, joints=(joint("j", "hinge", None, b, (0, 0, 0)),)))
    with pytest.raises(WmsError, match="action go: there is no joint 'j' with a drive"):
        execute(scene(a, joints=(hinge,), actions=(Steer("go", "j", 0, 1.0),)))


def test_mujoco_needs_no_smaller_steps_for_dampers() -> None:
    """It integrates them implicitly."""
    load = body("load", Box((0.05,) * 3), (0, 0, 1), mass=0.01)
    for drive, count in ((Drive(0.0, 1e3), 0), (Drive(1e7, 1.0), 1)):
        rail = joint("j", "slider", None, load, (0, 0, 1), DOWN, drive=drive)
        damped = scene(load, joints=(rail,), duration=0.2)
        assert len(approximation_warnings(info("mujoco").lacks, damped)) == count
    rail = replace(rail, drive=Drive(0.0, 1e3))
    trace = installed("mujoco").execute(scene(load, joints=(rail,), duration=0.2))
    assert trace.linear_velocity[-1, 0, 2] == pytest.approx(-0.01 * G / 1e3, rel=0.01)


def test_drives_too_stiff_for_an_engine_are_refused_with_their_prim() -> None:
    light = body("light", Box((0.05,) * 3), mass=0.01)
    stiff = scene(light, joints=(joint("j", "slider", None, light, (0, 0, 0), drive=Drive(1e9, 1e3)),), duration=0.2)
    for engine in ENGINES:
        execute = installed(engine).execute
        if any(lack.capability.name == "drives however stiff" for lack in info(engine).lacks):
            with pytest.raises(WmsError, match="/World/j: a drive of stiffness 1e"):
                execute(stiff)
        else:
            assert np.abs(execute(stiff).position).max() < 1e-3
