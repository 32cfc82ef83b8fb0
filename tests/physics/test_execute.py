"""Each engine on scenes that no oracle has, made by hand. Bars are what it was measured to reach, rounded up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.engines import ENGINES, installed
from tests.physics.conftest import Execute
from tests.physics.scenes import UPRIGHT, G, body, floor, scene, turn
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.engines.registry import info
from wmspec.sim.scene.capability import approximation_warnings, require
from wmspec.sim.scene.model import Array, Body, Friction, Geom, Glide, Launch, Pose, Trace
from wmspec.sim.scene.model.transform import rotate
from wmspec.sim.scene.physics.inertia import inertia
from wmspec.sim.shapes import Box, Capsule, Cone, Cylinder, Mesh, Shape, Sphere


def cube(half: float) -> Box:
    return Box((half,) * 3)


def tilt(trace: Trace, index: int) -> Array:
    """The angle (T,) between a body's z axis and the vertical, degrees."""
    up = rotate(trace.orientation[:, index], np.array([0.0, 0.0, 1.0]))
    angles: Array = np.degrees(np.arccos(np.clip(up[:, 2], -1, 1)))
    return angles


def test_a_thrown_cone_turns_about_its_centre_of_mass(execute: Execute) -> None:
    cone = body("b", Cone(0.1, 0.4), (0, 0, 10), orientation=turn((1, 0, 0), 0.5), velocity=(1, 0, 3), spin=(3, 0, 0))
    trace = execute(scene(cone, duration=1))
    center = trace.position[:, 0] + rotate(trace.orientation[:, 0], np.array([0, 0, -0.1]))
    t, start = trace.time, center[0]
    assert np.abs(center - start - np.stack([t, 0 * t, 3 * t - G * t**2 / 2], axis=1)).max() < 5e-5
    assert np.abs(np.abs((trace.orientation[:, 0] * turn((1, 0, 0), 0.5 + 3 * 1)).sum(axis=1)[-1]) - 1) < 1e-5


def test_asymmetric_body_obeys_eulers_equations(execute: Execute) -> None:
    spin = np.array([0.1, 6.0, 0.1])
    trace = execute(scene(body("b", Box((0.1, 0.05, 0.02)), spin=spin, mass=3.0), gravity=0, duration=1))
    moments = np.array([0.0029, 0.0104, 0.0125])
    turned = trace.orientation[:, 0] * np.array([1.0, -1, -1, -1])
    momentum = rotate(trace.orientation[:, 0], moments * rotate(turned, trace.angular_velocity[:, 0]))
    assert np.abs(momentum - moments * spin).max() < 0.005 * np.linalg.norm(moments * spin)


@pytest.mark.parametrize(("m1", "m2", "e"), [(1, 1, 1.0), (1, 3, 1.0), (3, 1, 0.5), (0.1, 5, 0.8)])
def test_two_balls_collide(engine: str, execute: Execute, m1: float, m2: float, e: float) -> None:
    bar = {"mujoco": 0.015, "pybullet": 0.002, "sapien": 0.002}[engine]
    a = body("a", Sphere(0.05), (-0.2517, 0, 0), mass=m1, velocity=(2, 0, 0), restitution=e, friction=0)
    b = body("b", Sphere(0.05), (0.05, 0, 0), mass=m2, restitution=e, friction=0)
    trace = execute(scene(a, b, gravity=0, duration=0.3))
    expected = [2 * (m1 - e * m2) / (m1 + m2), 2 * (1 + e) * m1 / (m1 + m2)]
    assert np.abs(trace.linear_velocity[-1, :, 0] - expected).max() < bar * 2
    assert [(c.first, c.second) for c in trace.contacts] == [("a", "b")]
    assert trace.contacts[0].start == pytest.approx(0.2017 / 2, abs=5e-3)


def test_a_pusher_carries_a_box_at_its_speed(execute: Execute) -> None:
    box = body("box", cube(0.05), (0.06, 0, 0.05))
    pusher = body("pusher", Box((0.01, 0.05, 0.02)), (0, 0, 0.05), motion="kinematic")
    push = Glide("push", "pusher", 0.1, 0.6, np.array([0.2, 0, 0]))
    trace = execute(scene(floor(), box, pusher, duration=1, actions=(push,)))
    assert trace.position[-1, 1, 0] == pytest.approx(0.16 + 0.2**2 / (2 * 0.5 * G), abs=0.005)
    expected = 0.2 * np.clip(trace.time - 0.1, 0, 0.5)
    assert np.allclose(trace.position[:, 2, 0], expected, atol=1e-12)
    assert np.allclose(trace.position[:, 2, 1:], [0, 0.05], atol=1e-12)
    during = (trace.time > 0.1) & (trace.time < 0.6)
    assert np.allclose(trace.linear_velocity[during, 2], [0.2, 0, 0], atol=1e-12)


def test_a_launch_changes_the_velocity_at_its_time(execute: Execute) -> None:
    launch = Launch("go", "b", 0.25, np.array([1.0, 2.0, 3.0]), np.array([0, 0, 1.0]))
    trace = execute(scene(body("b", cube(0.05), (0, 0, 5)), gravity=0, duration=0.5, actions=(launch,)))
    assert np.allclose(trace.position[:61, 0], [0, 0, 5], atol=1e-6)
    assert np.allclose(trace.position[-1, 0], [0.25, 0.5, 5.75], atol=1e-4)
    assert np.array_equal(trace.linear_velocity[60, 0], [1, 2, 3])
    assert trace.angular_velocity[-1, 0, 2] == pytest.approx(1, abs=5e-4)  # SAPIEN computes with 32 bits


def test_damping_slows_exponentially(execute: Execute) -> None:
    body_ = body(
        "b",
        Box((0.1, 0.05, 0.02)),
        velocity=(1, 0, 0),
        spin=(0, 0, 2),
        linear_damping=0.7,
        angular_damping=1.3,
    )
    trace = execute(scene(body_, gravity=0, duration=1))
    assert trace.linear_velocity[-1, 0, 0] == pytest.approx(np.exp(-0.7), rel=1e-3)
    assert trace.angular_velocity[-1, 0, 2] == pytest.approx(2 * np.exp(-1.3), rel=1e-3)


def pebble() -> Mesh:
    points = np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0], [0.4, 0.3, 1.2], [-0.5, 0.2, 1.0]]) * 0.05
    return Mesh(points, np.zeros((0, 3), np.int32))


@pytest.mark.parametrize(
    ("shape", "height"),
    [
        (cube(0.05), 0.05),
        (Sphere(0.05), 0.05),
        (Cylinder(0.05, 0.1), 0.05),
        (Cone(0.05, 0.1), 0.05),
        (Capsule(0.03, 0.08), 0.07),
        (pebble(), 0.0),
    ],
    ids=lambda v: type(v).__name__,
)
def test_every_shape_rests_where_it_is_put(execute: Execute, shape: Shape, height: float) -> None:
    trace = execute(scene(floor(), body("b", shape, (0.2, 0.1, height)), duration=0.5))
    assert np.abs(trace.position[-1, 1] - [0.2, 0.1, height]).max() < 2e-4
    assert tilt(trace, 1)[-1] < 0.1
    assert [(c.first, c.second) for c in trace.contacts] == [("floor", "b")]
    assert trace.contacts[0].stop == pytest.approx(0.5)


@pytest.mark.parametrize("shape", [cube(0.04), Sphere(0.04)], ids=lambda v: type(v).__name__)
@pytest.mark.parametrize("gap", [0.0003, 0.001, 0.0019])
def test_close_bodies_do_not_touch(execute: Execute, shape: Shape, gap: float) -> None:
    trace = execute(
        scene(floor(), body("a", shape, (0, 0, 0.04)), body("b", shape, (0.08 + gap, 0, 0.04)), duration=0.5)
    )
    assert sorted((c.first, c.second) for c in trace.contacts) == [("floor", "a"), ("floor", "b")]


def test_a_body_of_several_pieces_balances_on_its_centre_of_mass(execute: Execute) -> None:
    """A hammer, its head twice as heavy as its handle, lies on a narrow beam under its centre of mass."""
    head, handle = Box((0.03, 0.05, 0.03)), Box((0.15, 0.02, 0.03))
    at = Pose(np.array([0.18, 0, 0]), UPRIGHT), Pose(np.zeros(3), UPRIGHT)
    geoms = (Geom("head", head, at[0]), Geom("handle", handle, at[1]))
    mass = inertia([(head, at[0], 2.0), (handle, at[1], 1.0)])
    zero = np.zeros(3)
    hammer = Body("hammer", "/World/hammer", "dynamic", Pose(np.array([0, 0, 0.23]), UPRIGHT), geoms, mass, zero, zero)
    assert np.allclose(mass.center, [0.12, 0, 0])
    for shift, stays in ((0.0, True), (-0.02, False)):
        beam = body("beam", Box((0.01, 0.1, 0.1)), (0.12 + shift, 0, 0.1), motion="static")
        trace = execute(scene(floor(), beam, hammer, duration=1))
        assert (tilt(trace, 2)[-1] < 0.5) == stays


def test_materials_of_a_pair_mix_by_the_geometric_mean(execute: Execute) -> None:
    boxes = [
        body(f"b{i}", Box((0.1, 0.1, 0.05)), (0, i, 0.05), velocity=(1, 0, 0), friction=mu)
        for i, mu in enumerate((0.08, 0.32, 0.72))
    ]
    trace = execute(scene(floor(0.5), *boxes, duration=1))
    for i, mu in enumerate((0.2, 0.4, 0.6)):
        assert trace.position[-1, 1 + i, 0] == pytest.approx(1 / (2 * mu * G), rel=0.005)


def test_kinematic_bodies_pass_through_each_other(execute: Execute) -> None:
    wall = body("wall", cube(0.1), (0.3, 0, 0.2), motion="static")
    a, b = (body(n, cube(0.1), (0, 0.05 * i, 0.2), motion="kinematic") for i, n in enumerate("ab"))
    trace = execute(scene(wall, a, b, duration=0.5, actions=(Glide("g", "a", 0, 0.5, np.array([1.0, 0, 0])),)))
    assert trace.contacts == ()
    assert np.allclose(trace.position[-1, 1], [0.5, 0, 0.2], atol=1e-12)


def test_nonsense_is_refused_with_its_prim(execute: Execute) -> None:
    bad = body("b", cube(0.05), restitution=1.5)
    with pytest.raises(WmsError, match=r"/World/b.*restitution"):
        execute(scene(bad))
    still = body("b", cube(0.05), motion="static")
    with pytest.raises(WmsError, match="'b', which is static"):
        execute(scene(still, actions=(Launch("go", "b", 0, np.zeros(3), np.zeros(3)),)))


@pytest.mark.parametrize("engine", ENGINES)
def test_dynamic_friction_counts_and_the_other_is_reported(engine: str) -> None:
    slope = turn((0, 1, 0), np.radians(27))
    pair = Friction(static=0.6, dynamic=0.4)
    box = body("b", cube(0.05), rotate(slope, np.array([0, 0, 0.05])), orientation=slope)
    both = [
        replace(one, geoms=tuple(replace(geom, friction=pair) for geom in one.geoms))
        for one in (floor(orientation=slope), box)
    ]
    play = scene(*both, duration=0.5)
    trace = installed(engine).execute(play)
    slid = float(np.linalg.norm(trace.position[-1, 1] - trace.position[0, 1]))
    reported = approximation_warnings(info(engine).lacks, play)
    assert {str(note.place) for note in reported} == {"/World/floor", "/World/b"}
    assert slid == pytest.approx(9.81 * (np.sin(np.radians(27)) - 0.4 * np.cos(np.radians(27))) / 8, rel=0.02)
    with pytest.raises(WmsError, match=r"friction 0\.6 at rest and 0\.4 in motion"):
        require(info(engine).lacks, play, strict=True)


def test_too_many_materials_for_sapien_are_refused_by_name() -> None:
    execute: Execute = installed("sapien").execute
    balls = [body(f"b{i}", Sphere(0.05), (0.2 * i, 0, 0.05), friction=0.1 * (i + 1)) for i in range(9)]
    with pytest.raises(WmsError, match=r"/World/b8.*32 pairs"):
        execute(scene(floor(), *balls))
    assert execute(scene(floor(), *[body(f"b{i}", Sphere(0.05), (i, 0, 0.05)) for i in range(40)], duration=0.05))
