"""Mass properties agree with those of a fine mesh, and do not depend on how a body is put together."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Array, Inertia, Pose
from wmspec.sim.scene.model.transform import compose, identity, inverse, multiply, quaternion, rotate, rotation
from wmspec.sim.scene.physics.inertia import inertia
from wmspec.sim.shapes import Box, Capsule, Cone, Cylinder, Mesh, Shape, Sphere

sizes = st.floats(0.01, 1.0)


@st.composite
def poses(draw: st.DrawFn) -> Pose:
    q = np.array([draw(st.floats(-1, 1)) for _ in range(4)])
    q = q / np.linalg.norm(q) if np.linalg.norm(q) > 0.1 else np.array([1.0, 0, 0, 0])
    return Pose(np.array([draw(st.floats(-1, 1)) for _ in range(3)]), q)


def tensor(i: Inertia) -> Array:
    turn = rotation(i.axes)
    return turn @ np.diag(i.moments) @ turn.T


def meshed(shape: Shape) -> trimesh.Trimesh:
    match shape:
        case Box(half):
            return trimesh.creation.box(2 * np.array(half))
        case Sphere(r):
            return trimesh.creation.icosphere(5, r)
        case Cylinder(r, h):
            return trimesh.creation.cylinder(r, h, sections=512)
        case Cone(r, h):
            return trimesh.creation.cone(r, h, sections=512).apply_translation([0, 0, -h / 2])
        case Capsule(r, h):
            # trimesh merges points closer than a fixed distance: made large, then shrunk
            return trimesh.creation.capsule(height=100 * h, radius=100 * r, count=[128, 128]).apply_scale(0.01)
        case Mesh():
            return trimesh.convex.convex_hull(shape.points)


@st.composite
def shapes(draw: st.DrawFn) -> Shape:
    r, h, d = draw(sizes), draw(sizes), draw(sizes)
    tetra = Mesh(np.array([[0, 0, 0], [r, 0, 0], [0, h, 0], [0.1 * r, 0.2 * h, d]]), np.zeros((0, 3), np.int32))
    choice: tuple[Shape, ...] = (
        Box((r, h, d)),
        Sphere(r),
        Cylinder(r, h),
        Cone(r, h),
        Capsule(max(r, h / 20), h),
        tetra,
    )
    return choice[draw(st.integers(0, len(choice) - 1))]


@settings(max_examples=60, deadline=None)
@given(shapes())
def test_each_shape_has_the_mass_properties_of_its_mesh(shape: Shape) -> None:
    mesh = meshed(shape)
    assert shape.volume == pytest.approx(mesh.volume, rel=2e-3)
    mine, size = inertia([(shape, identity(), 2.0)]), np.linalg.norm(mesh.extents)
    assert mine.mass == 2.0
    assert np.allclose(mine.center, mesh.center_mass, atol=2e-3 * size)
    expected = mesh.moment_inertia / mesh.mass * 2.0
    assert np.allclose(tensor(mine), expected, atol=3e-3 * np.trace(expected))


@settings(max_examples=60, deadline=None)
@given(shapes(), poses(), poses())
def test_mass_properties_move_with_the_body(shape: Shape, first: Pose, outer: Pose) -> None:
    parts = [(shape, first, 1.0), (Sphere(0.2), identity(), 0.5)]
    here = inertia(parts)
    there = inertia([(s, compose(outer, p), m) for s, p, m in parts])
    turn = rotation(outer.orientation)
    assert np.allclose(there.center, outer.position + turn @ here.center, atol=1e-9)
    assert np.allclose(tensor(there), turn @ tensor(here) @ turn.T, atol=1e-9)
    assert np.linalg.norm(there.axes) == pytest.approx(1.0)


@given(sizes, sizes, sizes, st.floats(0.1, 0.9))
def test_a_box_cut_in_two_is_the_box(x: float, y: float, z: float, cut: float) -> None:
    whole = inertia([(Box((x, y, z)), identity(), 1.0)])
    left = Pose(np.array([-x * (1 - cut), 0, 0]), identity().orientation)
    right = Pose(np.array([x * cut, 0, 0]), identity().orientation)
    halves = [(Box((x * cut, y, z)), left, cut), (Box((x * (1 - cut), y, z)), right, 1 - cut)]
    both = inertia(halves)
    assert np.allclose(both.center, whole.center, atol=1e-12)
    assert np.allclose(both.moments, whole.moments)
    assert np.array_equal(both.axes, whole.axes)


@given(poses(), poses())
def test_poses_form_a_group(a: Pose, b: Pose) -> None:
    c = compose(inverse(a), compose(a, b))
    assert np.allclose(c.position, b.position, atol=1e-12)
    assert np.allclose(c.orientation, b.orientation, atol=1e-12)
    q = multiply(a.orientation, b.orientation)
    assert np.allclose(rotation(q), rotation(a.orientation) @ rotation(b.orientation), atol=1e-12)
    assert np.allclose(rotation(quaternion(rotation(q))), rotation(q), atol=1e-12)
    assert np.allclose(rotate(q, b.position), rotation(q) @ b.position, atol=1e-12)


def test_flat_meshes_and_massless_bodies_are_refused() -> None:
    flat = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]), np.array([[0, 1, 2], [1, 3, 2]], np.int32))
    with pytest.raises(WmsError, match="volume"):
        inertia([(flat, identity(), 1.0)])
    with pytest.raises(WmsError, match="mass"):
        inertia([(Sphere(1.0), identity(), 0.0)])
