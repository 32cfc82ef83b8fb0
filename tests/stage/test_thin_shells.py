"""Meshes that are not convex collide as thin solids: their upper side, or the front of a wall, is where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from tests.engines import ENGINES, installed
from tests.stage.stages import stage
from tests.stage.test_meshes import RING, angle, prim
from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.model import Body
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.shapes import Mesh
from wmspec.sim.usd import read
from wmspec.sim.usd import thin_shells as module
from wmspec.sim.usd.thin_shells import MAX_FACES, SHELL_DEPTH, thin_shells

Points = NDArray[np.float64]
SHEET = """
def Mesh "sheet" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {
    point3f[] points = [%s]
    int[] faceVertexCounts = [%s]
    int[] faceVertexIndices = [%s]
    float xformOp:rotateX = %s
    uniform token[] xformOpOrder = ["xformOp:rotateX"]
}
"""
SQUARE = "(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)"
ELL = "(-1, -1, 0), (1, -1, 0), (1, 0, 0), (0, 0, 0), (0, 1, 0), (-1, 1, 0), (-1, 0, 0), (0, -1, 0)"
BALL = """
def Sphere "ball" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {
    double radius = 0.1
    double3 xformOp:translate = (%s, %s, 0.1)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


def stairs() -> trimesh.Trimesh:
    """Two steps of 30 cm, the lower one 60 cm long, closed."""
    made = angle().apply_scale(3)
    made.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0)))
    return made


def inside(solid: trimesh.Trimesh, points: Points) -> NDArray[np.bool_]:
    """Which points a closed mesh winds around: van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983)."""
    a, b, c = (solid.triangles[None, :, i] - points[:, None] for i in range(3))
    x, y, z = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    volume = (np.cross(a, b) * c).sum(axis=2)
    below = x * y * z + (a * b).sum(axis=2) * z + (b * c).sum(axis=2) * x + (c * a).sum(axis=2) * y
    return np.asarray(np.arctan2(volume, below).sum(axis=1) > np.pi)


def square(faces: str = "0, 1, 2, 3", turn: float = 0) -> str:
    return SHEET % (SQUARE, 4, faces, turn)


def sheet(text: str) -> Body:
    """The one body of a stage; it is drawn as it is."""
    (body,) = read(stage(text)).bodies
    drawn, *touched = body.geoms
    assert (drawn.visible, drawn.collides) == (True, False)
    assert all((geom.visible, geom.collides) == (False, True) for geom in touched)
    return body


def reach(body: Body) -> Points:
    """The corners (2, 3) of the upright box around what collides."""
    return world_box([geom for geom in body.geoms if geom.collides], body.pose)


@pytest.mark.parametrize("faces", ["0, 1, 2, 3", "3, 2, 1, 0"])
@pytest.mark.parametrize("turn", [0, 180])
def test_ground_extends_downwards_at_any_turn(faces: str, turn: float) -> None:
    assert_allclose(reach(sheet(square(faces, turn))), [(-1, -1, -SHELL_DEPTH), (1, 1, 0)], atol=1e-7)


@pytest.mark.parametrize(("faces", "back"), [("0, 1, 2, 3", (0, SHELL_DEPTH)), ("3, 2, 1, 0", (-SHELL_DEPTH, 0))])
def test_a_wall_grows_behind_its_front(faces: str, back: tuple[float, float]) -> None:
    assert_allclose(reach(sheet(square(faces, 90)))[:, 1], back, atol=1e-7)


@pytest.mark.parametrize(
    ("text", "area"), [(square(), 4), (SHEET % (ELL, "4, 4, 4", "0, 7, 3, 6, 7, 1, 2, 3, 6, 3, 4, 5", 0), 3)]
)
def test_the_solids_are_closed_and_as_large_as_the_sheet(text: str, area: float) -> None:
    solids = [
        trimesh.Trimesh(g.shape.points, g.shape.faces)
        for g in sheet(text).geoms
        if g.collides and isinstance(g.shape, Mesh)
    ]
    assert all(solid.is_watertight for solid in solids)
    assert sum(s.area_faces[s.face_normals[:, 2] > 0.999].sum() for s in solids) == pytest.approx(area)
    assert sum(solid.volume for solid in solids) == pytest.approx(area * SHELL_DEPTH, rel=0.05)


THIN = trimesh.creation.box((1, 1, 0.004))


@pytest.mark.parametrize("solid", [angle(), RING, stairs(), THIN], ids=["angle", "ring", "stairs", "thin"])
def test_a_solid_keeps_its_surface(solid: trimesh.Trimesh) -> None:
    """Just below it something collides everywhere, and nothing sticks out."""
    made = [trimesh.Trimesh(s.points, s.faces) for s in thin_shells(Mesh(solid.vertices, solid.faces))]
    on, faces = trimesh.sample.sample_surface(solid, 300, seed=0)
    below = on - 1e-5 * solid.face_normals[faces]
    assert np.mean(np.any([inside(m, below) for m in made], axis=0)) > 0.99  # but for the seams
    corners = np.concatenate([m.vertices + 1e-4 * (m.vertices.mean(axis=0) - m.vertices) for m in made])
    assert inside(solid, corners).all()


@pytest.mark.parametrize(("fine", "most"), [(2, 100), pytest.param(4, MAX_FACES, marks=pytest.mark.slow)])
def test_a_mesh_of_too_many_faces_is_refused(fine: int, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of as many as the limit allows, reading takes seconds."""
    monkeypatch.setattr(module, "MAX_FACES", most)
    ball = trimesh.creation.icosphere(fine)
    bowl = trimesh.Trimesh(ball.vertices, ball.faces[ball.triangles_center[:, 2] < 0])
    with pytest.raises(
        StageError, match=r"/World/m: its surface cannot collide: it has .* flat faces.* set physics:approx"
    ):
        read(stage(prim(bowl, "none", dynamic=False)))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_ball_rests_on_a_ground_and_falls_beside_it(engine: str) -> None:
    execute = installed(engine).execute
    for at, end in (((0.5, 0.5), 0.1), ((1.5, 0), 0.1 - 9.81 / 8)):
        found = replace(read(stage(square() + BALL % at)), duration=0.5)
        ball = [body.name for body in found.bodies].index("ball")
        assert execute(found).position[-1, ball, 2] == pytest.approx(end, abs=5e-4)


ROOM = trimesh.creation.box((2, 2, 2), transform=trimesh.transformations.translation_matrix((0, 0, 1)))
ROOM.invert()


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("mesh", "at", "level"), [(ROOM, (0.3, 0.2), 0.0), (stairs(), (0.6, -0.15), 0.3)], ids=["room", "stairs"]
)
def test_a_ball_comes_to_rest_on_a_mesh_that_is_not_convex(
    engine: str, mesh: trimesh.Trimesh, at: tuple[float, float], level: float
) -> None:
    ball = BALL.replace("0.1)", f"{level + 0.2})") % at
    found = replace(read(stage(prim(mesh, "none", dynamic=False) + ball)), duration=1.0)
    last = installed(engine).execute(found).position[-1, [b.name for b in found.bodies].index("ball")]
    assert_allclose(last, (*at, level + 0.1), atol=1e-3)
