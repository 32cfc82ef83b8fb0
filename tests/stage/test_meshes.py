"""Meshes collide as their approximation says, the same pieces for every engine, and weigh what is drawn of them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from tests.engines import ENGINES, installed
from tests.stage.stages import stage
from wmspec.core.diagnostics import StageError, WmsError
from wmspec.sim.scene.model import Body
from wmspec.sim.shapes import Box, Mesh, Sphere
from wmspec.sim.usd import read

APPROXIMATED = """def Mesh "%s" (prepend apiSchemas = [%s"PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"]) {
    uniform token physics:approximation = "%s"
    point3f[] points = %s
    int[] faceVertexCounts = %s
    int[] faceVertexIndices = %s
    double3 xformOp:translate = %s
    uniform token[] xformOpOrder = ["xformOp:translate"] }"""
EPISODE = 'def WmsEpisode "Episode" { uniform double wms:duration = 0.6 }'
RING = trimesh.creation.annulus(0.1, 0.2, 0.08)


def angle() -> trimesh.Trimesh:
    """An L of four cubes of 10 cm, closed."""
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]]) * 0.1
    points = np.vstack([np.column_stack([outline, np.full(6, z)]) for z in (0.0, 0.1)])
    cap = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
    sides = [f for i in range(6) for j in [(i + 1) % 6] for f in ([i, j, j + 6], [i, j + 6, i + 6])]
    faces = [f[::-1] for f in cap] + [[a + 6, b + 6, c + 6] for a, b, c in cap] + sides
    return trimesh.Trimesh(points, faces)


def prim(mesh: trimesh.Trimesh, way: str, *, name: str = "m", dynamic: bool = True, at: object = (0, 0, 0)) -> str:
    """A Mesh prim."""
    points = ", ".join(f"({x:.9g}, {y:.9g}, {z:.9g})" for x, y, z in mesh.vertices.tolist())
    body = '"PhysicsRigidBodyAPI", ' if dynamic else ""
    return APPROXIMATED % (name, body, way, f"[{points}]", [3] * len(mesh.faces), mesh.faces.ravel().tolist(), at)


def only(text: str) -> Body:
    (body,) = read(stage(text)).bodies
    return body


def test_a_decomposition_collides_in_pieces_and_is_drawn_whole() -> None:
    body = only(prim(RING, "convexDecomposition"))
    drawn, *pieces = body.geoms
    assert (drawn.visible, drawn.collides, len(pieces) > 5) == (True, False, True)
    assert all((p.visible, p.collides) == (False, True) for p in pieces)
    filled = sum(p.shape.volume for p in pieces)
    assert filled == pytest.approx(RING.volume, rel=0.1)
    middle = [
        p
        for p in pieces
        if isinstance(p.shape, Mesh) and trimesh.convex.convex_hull(p.shape.points).contains([[0, 0, 0]])[0]
    ]
    assert not middle


def test_decomposed_body_has_the_mass_of_its_drawn_mesh() -> None:
    body = only(prim(angle(), "convexDecomposition"))
    assert body.inertia is not None
    assert body.inertia.mass == pytest.approx(1000 * 0.004)
    assert_allclose(body.inertia.center, angle().center_mass, atol=1e-6)
    assert sorted(body.inertia.moments) == pytest.approx(
        np.linalg.eigvalsh(angle().moment_inertia / angle().volume * 4), rel=1e-5
    )


def test_equal_meshes_give_equal_pieces() -> None:
    a, b = read(stage(prim(RING, "convexDecomposition", name="a") + prim(RING, "convexDecomposition", name="b"))).bodies
    for one, other in zip(a.geoms, b.geoms, strict=True):
        assert isinstance(one.shape, Mesh)
        assert isinstance(other.shape, Mesh)
        assert np.array_equal(one.shape.points, other.shape.points)


def test_bounds() -> None:
    drawn, box = only(prim(angle(), "boundingCube")).geoms
    assert isinstance(box.shape, Box)
    assert not drawn.collides
    assert_allclose(box.shape.half, (0.15, 0.1, 0.05), atol=1e-7)
    assert_allclose(box.pose.position, (0.15, 0.1, 0.05), atol=1e-7)
    body = only(prim(angle(), "boundingSphere"))
    ball = body.geoms[1].shape
    assert isinstance(ball, Sphere)
    assert ball.radius == pytest.approx(np.linalg.norm((0.15, 0.1, 0.05)))
    assert body.inertia is not None
    assert body.inertia.mass == pytest.approx(4.0)


@pytest.mark.parametrize("way", ["none", "meshSimplification"])
def test_exact_meshes_collide_face_by_face_if_they_stand_still_and_are_refused_if_they_fall(way: str) -> None:
    assert len(only(prim(angle(), way, dynamic=False)).geoms) == 1 + 6 + 2 * 4  # as drawn, its sides, its two caps
    with pytest.raises(StageError, match="/World/m: a dynamic non-convex mesh"):
        only(prim(angle(), way))
    with pytest.raises(StageError, match="'sdf' is not supported"):
        only(prim(angle(), "sdf"))
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    assert [(g.collides, g.visible) for g in only(prim(box, "convexDecomposition")).geoms] == [(True, True)]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_ball_falls_through_a_ring_that_lies_on_the_floor(engine: str) -> None:
    installed(engine)
    floor = """def Cube "floor" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double size = 2
        double3 xformOp:translate = (0, 0, -1)
        uniform token[] xformOpOrder = ["xformOp:translate"] }"""
    ball = """def Sphere "ball" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {
        double radius = 0.05 double3 xformOp:translate = (%s, 0, 0.3)
        uniform token[] xformOpOrder = ["xformOp:translate"] }"""
    for at, expected in ((0.0, 0.05), (0.15, 0.13)):
        text = floor + prim(RING, "convexDecomposition", at=(0, 0, 0.041)) + ball % at + EPISODE
        trace = installed(engine).execute(read(stage(text)))
        index = trace.bodies.index("ball")
        if at == 0.0:
            assert trace.position[-1, index, 2] == pytest.approx(expected, abs=2e-3)
        assert trace.position[trace.sample(0.25), index, 2] > expected - 5e-3
        assert trace.position[-1, trace.bodies.index("m"), 2] == pytest.approx(0.04, abs=3e-3)


BAR = """def Cube "%s" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {
    double size = 0.2
    double3 xformOp:translate = (%s, 0, -0.1)
    uniform token[] xformOpOrder = ["xformOp:translate"] }"""


def row(kind: str) -> str:
    """A bar of 20 cones or cubes in a row, which only its two ends rest on something."""
    shape = {"Cone": "double radius = 0.04 double height = 0.08", "Cube": "double size = 0.08"}[kind]
    pieces = "".join(
        f"""def {kind} "p{i}" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {{ {shape}
        double3 xformOp:translate = ({i / 10}, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"] }}\n"""
        for i in range(20)
    )
    body = f"""def Xform "bar" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {{
        double3 xformOp:translate = (0, 0, 0.04)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        {pieces} }}"""
    return BAR % ("left", 0) + BAR % ("right", 1.9) + body + EPISODE


@pytest.mark.parametrize("engine", ENGINES)
def test_no_piece_of_a_body_is_dropped(engine: str) -> None:
    backend = installed(engine)
    trace = backend.execute(read(stage(row("Cone"))))
    assert trace.position[-1, trace.bodies.index("bar"), 2] == pytest.approx(0.04, abs=2e-3)
    if engine == "pybullet":
        with pytest.raises(WmsError, match="/World/bar: a moving body of 20 pieces; PyBullet takes 16"):
            backend.execute(read(stage(row("Cube"))))
