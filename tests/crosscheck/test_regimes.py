"""Motion that engines get wrong is reported where a run enters it, and nowhere else."""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin

import pytest
from pxr import Usd

import wmspec
from tests.engines import installed
from usdphysics_conformance.stages import ball, body, box, cylinder, floor, joint, prism, stage
from wmspec.runtime.compare.regimes import trace_regimes
from wmspec.sim.usd import read

CUBE = box(0.2, 0.2, 0.2)


def kinds(text: str, engine: str, seconds: float = 0.6) -> list[str]:
    made = Usd.Stage.CreateInMemory()
    made.GetRootLayer().ImportFromString(text)
    scene = replace(read(made, strict=False), duration=seconds, rate=240)
    return [regime.kind for regime in trace_regimes(scene, installed(engine).execute(scene), 0.01)]


def slope(degrees: float, *prims: str) -> str:
    half = radians(degrees) / 2
    return stage(floor((cos(half), 0.0, sin(half), 0.0)), *prims, friction=1.0)


def upright(degrees: float, shape: str, height: float) -> str:
    angle = radians(degrees)
    turn = (cos(angle / 2), 0.0, sin(angle / 2), 0.0)
    return body("thing", shape, (height / 2 * sin(angle), 0.0, height / 2 * cos(angle)), turn)


def drop(mass: float, restitution: float = 0.0) -> str:
    pair = body("below", CUBE, (0, 0, 0.1), mass=1.0), body("falls", CUBE, (0, 0, 0.5), mass=mass)
    return stage(floor(), *pair, restitution=restitution)


def thrown(mass: float) -> str:
    pair = body("rests", CUBE, (0, 0, 0.1)), body("flies", CUBE, (-0.6, 0, 0.5), mass=mass, velocity=(1.9, 0, 0))
    return stage(floor(), *pair)


def pendulum(spring: str = "") -> str:
    arms = body("upper", box(0.4, 0.02, 0.02), (0.2, 0, 0)), body("lower", box(0.4, 0.02, 0.02), (0.6, 0, 0))
    hinges = (
        joint("Revolute", "pivot", "", "upper", (0, 0, 0), (-0.2, 0, 0), "Y"),
        joint("Revolute", "elbow", "upper", "lower", (0.2, 0, 0), (-0.2, 0, 0), "Y", drive=spring),
    )
    return stage(*arms, *hinges)


def car(axle: float = 0.0) -> str:
    """A beam on two rolling wheels, held by their middles, or by points so far (m) above them."""
    places = {"left": -0.3, "right": 0.3}
    wheels = [
        body(name, cylinder(0.1, 0.3, "Y"), (x, 0, 0.1), velocity=(1, 0, 0), angular_velocity=(0, 10, 0))
        for name, x in places.items()
    ]
    hinges = [
        joint("Revolute", f"{name}_axle", "beam", name, (x, 0, axle), (0, 0, axle), "Y") for name, x in places.items()
    ]
    beam = body("beam", box(0.2, 0.1, 0.02), (0, 0, 0.1), velocity=(1, 0, 0))
    return stage(floor(), beam, *wheels, *hinges)


TIPPED, RISES, WHIPS = "tips cylinders too early", "rise again", "energy of double pendulums"
CASES = {
    "a cylinder that nearly tips": (slope(17.0, upright(17.0, cylinder(0.05, 0.3), 0.3)), "mujoco", TIPPED),
    "and one in another engine": (slope(17.0, upright(17.0, cylinder(0.05, 0.3), 0.3)), "sapien", TIPPED),
    "a heavy box on a light one": (drop(6.0), "sapien", RISES),
    "a box that comes flying": (thrown(1.0), "sapien", RISES),
    "a double pendulum": (pendulum(), "pybullet", WHIPS),
    "a car whose wheels are out of balance": (car(0.05), "mujoco", WHIPS),
    "a disc on its rim": (
        stage(floor(), body("disc", cylinder(0.1, 0.05, "Y"), (0, 0, 0.1), velocity=(0.5, 0, 0))),
        "sapien",
        "polygons",
    ),
    "a mesh that slides": (
        stage(floor(), body("prism", prism(6, 0.1, 0.1), (0, 0, 0.05), velocity=(1.5, 0, 0)), friction=0.3),
        "pybullet",
        "convex meshes",
    ),
    "balls that touch": (
        stage(
            *(body(f"ball{i}", ball(0.05), (x, 0, 0), velocity=(v, 0, 0)) for i, (x, v) in enumerate(
                [(-0.3, 1.0), (0.0, 0.0), (0.1, 0.0)]
            )),
            gravity=0,
            restitution=1,
        ),
        "pybullet",
        "at once",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_entering_object_is_reported(name: str) -> None:
    text, engine, kind = CASES[name]
    (reported,) = kinds(text, engine)
    assert kind in reported


@pytest.mark.parametrize(
    ("text", "engine"),
    [
        (slope(10.0, upright(10.0, cylinder(0.05, 0.3), 0.3)), "mujoco"),
        (slope(17.0, upright(17.0, cylinder(0.05, 0.3), 0.3)), "pybullet"),
        (slope(17.0, upright(17.0, box(0.1, 0.1, 0.3), 0.3)), "sapien"),
        (drop(3.0), "sapien"),
        (drop(6.0, restitution=0.5), "sapien"),
        (drop(6.0), "pybullet"),
        (thrown(0.5), "sapien"),
        (pendulum("stiffness = 0\ndamping = 0.05"), "mujoco"),
        (car(), "mujoco"),
        (stage(floor(), body("can", cylinder(0.05, 0.2, "Y"), (0, 0, 0.05), velocity=(0.5, 0, 0))), "sapien"),
    ],
)
def test_ordinary_scenes_are_outside_the_regimes(text: str, engine: str) -> None:
    assert not kinds(text, engine)


def test_stage_run_reports_it() -> None:
    made = Usd.Stage.CreateInMemory()
    made.GetRootLayer().ImportFromString(drop(6.0))
    installed("sapien")
    assert any(
        RISES in note.message and "`falls` lands on `below`" in note.message
        for note in wmspec.run(made, "sapien", 0.6).notes
    )
    assert not wmspec.run(made, "mujoco", 0.2).notes


def gyroscope(spin: float) -> str:
    """A symmetric top of 1 kg, 30 cm from the point by which it is held, that precesses without nodding."""
    around = 9.81 * 0.3 / (0.005 * spin)
    top = body(
        "top",
        ball(0.1),
        (0.3, 0, 0),
        velocity=(0, 0.3 * around, 0),
        angular_velocity=(spin, 0, around),
        moments=(0.005, 0.0025, 0.0025),
    )
    return stage(top, joint("Spherical", "pivot", "", "top", (0, 0, 0), (-0.3, 0, 0)))


@pytest.mark.parametrize(("engine", "wrong"), [("mujoco", False), ("pybullet", True)])
def test_gyroscope_precesses_or_is_reported_as_wrong(engine: str, wrong: bool) -> None:
    """MuJoCo's usual integrator gains 42 % of its energy in a second, at 50 rad/s."""
    assert [("spins fast" in kind) for kind in kinds(gyroscope(50.0), engine, 1.0)] == [True] * wrong


@pytest.mark.parametrize("spin", [50.0, 150.0, 400.0])
def test_mujoco_keeps_a_gyroscope_on_its_way(spin: float) -> None:
    made = Usd.Stage.CreateInMemory()
    made.GetRootLayer().ImportFromString(gyroscope(spin))
    trace = installed("mujoco").execute(replace(read(made, strict=False), duration=1.0, rate=240))
    angle = 9.81 * 0.3 / (0.005 * spin)
    assert trace.position[-1, 0] == pytest.approx((0.3 * cos(angle), 0.3 * sin(angle), 0.0), abs=1e-3)
