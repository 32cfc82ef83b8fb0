"""How deep shapes lie in one another, against what geometry says."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.examples import examples
from wmspec.compile.lint.overlap import MAX_OVERLAP
from wmspec.runtime.questions.runs import _near, _touched
from wmspec.sim.scene.model import Body, Geom, Pose
from wmspec.sim.scene.model.bounds import bounds
from wmspec.sim.scene.model.transform import apply, compose
from wmspec.sim.scene.physics.overlap import overlap
from wmspec.sim.shapes import Box, Capsule, Cone, Cylinder, Mesh, Shape, Sphere
from wmspec.sim.shapes.facets import tessellate

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
LEAST = 0.001
CUBE = Mesh(np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.05, np.zeros((0, 3), np.int32))
SHAPES: list[Shape] = [
    Box((0.05, 0.04, 0.03)), Sphere(0.05), Cylinder(0.04, 0.08), Cone(0.05, 0.1), Capsule(0.03, 0.06), CUBE,
]  # fmt: skip
FLOOR = Box((1.0, 1.0, 0.1))

turns = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)


def at(x: float, y: float, z: float, turn: tuple[float, ...] = (1, 0, 0, 0)) -> Pose:
    return Pose(np.array([x, y, z]), np.array(turn) / np.linalg.norm(turn))


@examples(16, 40)
@given(st.floats(0.02, 0.1), st.floats(0.02, 0.1), st.floats(-0.01, 0.015), st.floats(0, 6), st.floats(0, 3))
def test_two_spheres(a: float, b: float, depth: float, turn: float, tilt: float) -> None:
    far = a + b - depth
    other = at(far * math.sin(tilt) * math.cos(turn), far * math.sin(tilt) * math.sin(turn), far * math.cos(tilt))
    expected = depth if depth >= LEAST else 0.0
    assert overlap(Sphere(a), at(0, 0, 0), Sphere(b), other, LEAST) == pytest.approx(expected, abs=3e-5)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
@examples(7, 20)
@given(turn=turns, depth=st.floats(0.002, 0.008))
def test_body_on_the_floor_touches_it_exactly(shape: Shape, turn: tuple[float, ...], depth: float) -> None:
    lowest = bounds(shape, at(0, 0, 0, turn))[0, 2]
    assert overlap(FLOOR, at(0, 0, -0.1), shape, at(0.1, 0.2, -lowest, turn), LEAST) == 0
    sunk = overlap(FLOOR, at(0, 0, -0.1), shape, at(0.1, 0.2, -lowest - depth, turn), 1e-6)
    assert 0 < sunk <= depth + 2e-5


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
@examples(7, 20)
@given(turn=turns, both=turns, sunk=st.floats(-0.002, 0.008))
def test_measure_is_independent_of_turns(
    shape: Shape, turn: tuple[float, ...], both: tuple[float, ...], sunk: float
) -> None:
    lowest = bounds(shape, at(0, 0, 0, turn))[0, 2]
    floor, thing, all_of_it = at(0, 0, -0.1), at(0.1, 0.2, -lowest - sunk, turn), at(0.3, -0.2, 0.1, both)
    upright = overlap(FLOOR, floor, shape, thing, 1e-6)
    turned = overlap(FLOOR, compose(all_of_it, floor), shape, compose(all_of_it, thing), 1e-6)
    assert turned == pytest.approx(upright, abs=3e-5)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
@examples(10, 20)
@given(turn=turns)
def test_the_upright_box_holds_the_shape_exactly(shape: Shape, turn: tuple[float, ...]) -> None:
    pose = at(0.3, -0.2, 0.1, turn)
    points = shape.points if isinstance(shape, Mesh) else tessellate(shape).points
    corners = apply(pose, points)
    low, high = bounds(shape, pose)
    assert (corners.min(axis=0) >= low - 1e-9).all()
    assert (corners.max(axis=0) <= high + 1e-9).all()
    assert np.abs(np.stack([corners.min(axis=0), corners.max(axis=0)]) - bounds(shape, pose)).max() < 0.001


def test_a_cylinder_half_sunk_and_a_cone_beside_a_cone() -> None:
    assert overlap(FLOOR, at(0, 0, -0.1), Cylinder(0.1, 0.2), at(0, 0, 0), LEAST) == pytest.approx(0.1, abs=3e-5)
    legs, base = 2 * math.hypot(0.025, 0.05), 0.05  # two cones share a triangle: its inscribed circle
    circle = 2 * (base * 0.05) / (legs + base)
    assert overlap(Cone(0.1, 0.2), at(0, 0, 0.1), Cone(0.1, 0.2), at(0.15, 0, 0.1), LEAST) == pytest.approx(
        circle, abs=3e-5
    )


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.booleans()), max_size=8))
def test_every_pair_is_looked_at_that_may_lie_in_one_another(places: list[tuple[float, float, bool]]) -> None:
    cube, still = Geom("cube", Box((0.05, 0.05, 0.05)), at(0, 0, 0)), np.zeros(3)
    bodies = [
        Body(f"b{i}", f"/b{i}", "static" if stays else "kinematic", at(x, y, 0), (cube, cube), None, still, still)
        for i, (x, y, stays) in enumerate(places)
    ]
    pieces = [(body, *piece) for body in bodies for piece in _touched(body)]
    expected = [
        (pieces[i][0].name, pieces[j][0].name)
        for i, j in combinations(range(len(pieces)), 2)
        if pieces[i][0] is not pieces[j][0]
        and "kinematic" in (pieces[i][0].motion, pieces[j][0].motion)
        and (
            np.minimum(pieces[i][3][1], pieces[j][3][1]) - np.maximum(pieces[i][3][0], pieces[j][3][0]) > MAX_OVERLAP
        ).all()
    ]
    assert [(a[0].name, b[0].name) for a, b in _near(pieces)] == expected
