"""Cameras, colours and tessellation, without any engine."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from tests.pixels.scenes import wedge
from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Camera
from wmspec.sim.scene.model.transform import rotation
from wmspec.sim.scene.render.camera import look_at, project, projection_matrix, unproject, view_matrix
from wmspec.sim.scene.render.color import to_bytes, to_linear, to_srgb
from wmspec.sim.shapes import Box, Capsule, Cone, Cylinder, Mesh, Shape, Sphere
from wmspec.sim.shapes.facets import tessellate

length = st.floats(0.01, 10)
place = st.tuples(*[st.floats(-5, 5)] * 3).map(np.array)
SHAPES: list[tuple[Shape, float]] = [
    (Box((0.1, 0.2, 0.3)), 8 * 0.1 * 0.2 * 0.3),
    (Sphere(0.5), 4 / 3 * math.pi * 0.5**3),
    (Cylinder(0.3, 0.8), math.pi * 0.3**2 * 0.8),
    (Cone(0.3, 0.8), math.pi * 0.3**2 * 0.8 / 3),
    (Capsule(0.3, 0.8), math.pi * 0.3**2 * 0.8 + 4 / 3 * math.pi * 0.3**3),
    (wedge(), 0.12 * 0.10 * 0.08 / 2),
]


@given(place, place)
def test_a_camera_sees_its_target_in_the_middle(eye: Any, target: Any) -> None:
    if np.linalg.norm(eye - target) < 1e-3:
        return
    camera = Camera("c", look_at(eye, target), 0.8, 0.1, 100.0)
    (pixel,), (depth,) = project(camera, target, 200, 100)
    assert np.allclose(pixel, [100, 50], atol=1e-6)
    assert depth == pytest.approx(np.linalg.norm(eye - target))
    assert rotation(camera.pose.orientation)[2, 1] >= -1e-9  # the picture's up is never the world's down


def test_a_camera_can_not_look_at_itself() -> None:
    with pytest.raises(WmsError, match="own position"):
        look_at((1, 2, 3), (1, 2, 3))


def test_looking_down_has_y_up() -> None:
    camera = Camera("top", look_at((0, 0, 2), (0, 0, 0)), 0.8, 0.1, 10.0)
    (pixel,), _ = project(camera, (0.1, 0.2, 0), 100, 100)
    assert pixel[0] > 50
    assert pixel[1] < 50


@given(place)
def test_projection_agrees_with_the_matrices(point: Any) -> None:
    camera = Camera("c", look_at((7, -8, 9), (0.1, 0.2, 0.3)), 0.7, 0.1, 50.0)
    (pixel,), (depth,) = project(camera, point, 320, 200)
    clip = projection_matrix(camera, 320 / 200) @ view_matrix(camera.pose) @ np.append(point, 1)
    assert np.allclose(pixel, [(clip[0] / clip[3] + 1) * 160, (1 - clip[1] / clip[3]) * 100])
    assert clip[3] == pytest.approx(depth)


def test_unproject_undoes_project() -> None:
    camera = Camera("c", look_at((1, -2, 1.5), (0, 0, 0)), 0.7, 0.1, 50.0)
    depth = np.linspace(1, 3, 12 * 20, dtype=np.float32).reshape(12, 20)
    pixels, back = project(camera, unproject(camera, depth).reshape(-1, 3), 20, 12)
    assert np.allclose(back, depth.reshape(-1))
    assert np.allclose(pixels.reshape(12, 20, 2)[3, 7], [7.5, 3.5])


@given(st.floats(0, 1))
def test_srgb_round_trip(value: float) -> None:
    assert to_srgb(to_linear(value)) == pytest.approx(value, abs=1e-6)


def test_srgb_known_values() -> None:
    assert to_linear(0.5) == pytest.approx(0.21404, abs=1e-5)  # IEC 61966-2-1
    assert to_bytes([0.0, 0.5, 1.0, 2.0]).tolist() == [0, 128, 255, 255]


@pytest.mark.parametrize(("shape", "volume"), SHAPES, ids=lambda v: type(v).__name__)
def test_shapes_are_closed_and_face_outwards(shape: Shape, volume: float) -> None:
    facets = tessellate(shape)
    mesh = trimesh.Trimesh(np.round(facets.points, 9), facets.faces, process=False)
    mesh.merge_vertices(merge_norm=True, merge_tex=True)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(volume, rel=0.01)


@pytest.mark.parametrize(("shape", "volume"), SHAPES, ids=lambda v: type(v).__name__)
def test_normals_are_unit_and_on_the_side_of_their_faces(shape: Shape, volume: float) -> None:
    facets = tessellate(shape)
    a, b, c = (facets.points[facets.faces[:, i]] for i in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert np.allclose(np.linalg.norm(facets.normals, axis=1), 1)
    used = facets.normals[facets.faces]
    assert np.all(np.einsum("mij,mj->mi", used, flat) > math.cos(math.radians(40)))
    assert facets.st.min() >= 0
    assert facets.st.max() <= 1


@given(length, length)
def test_round_shapes_reach_their_extent(radius: float, height: float) -> None:
    for shape in (Cylinder(radius, height), Cone(radius, height)):
        points = tessellate(shape).points
        assert np.allclose(points.max(axis=0), [radius, radius, height / 2])
        assert np.allclose(points.min(axis=0), [-radius, -radius, -height / 2])


def test_creases_split_and_smooth_edges_do_not() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    smooth = tessellate(Mesh(ball.vertices.astype(float), ball.faces.astype(np.int32)))
    assert len(smooth.points) == len(ball.vertices)
    assert np.allclose(smooth.normals, smooth.points / 0.1, atol=0.05)
    assert len(tessellate(wedge()).points) == 2 * 3 + 3 * 4


def test_equal_shapes_share_their_triangles() -> None:
    assert tessellate(Sphere(0.25)) is tessellate(Sphere(0.25))
    assert tessellate(Box((0.1,) * 3)) is tessellate(Box((0.1,) * 3))
    assert tessellate(wedge()) is tessellate(wedge())
    assert tessellate(Sphere(0.25)) is not tessellate(Sphere(0.26))
