"""Flat meshes that never move collide as thin solids: their upper side, or the front of a wall, is where they are."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from tests.physics.scenes import ENGINES
from tests.stage.stages import stage
from wmspec.scene.bounds import upright
from wmspec.scene.model import Body, Mesh
from wmspec.scene.read import read
from wmspec.scene.read.sheets import THICKNESS

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


def square(faces: str = "0, 1, 2, 3", turn: float = 0) -> str:
    return SHEET % (SQUARE, 4, faces, turn)


def sheet(text: str) -> Body:
    """The one body of a stage; it is drawn as it is."""
    (body,) = read(stage(text)).bodies
    drawn, *touched = body.geoms
    assert (drawn.visible, drawn.collides) == (True, False)
    assert all((geom.visible, geom.collides) == (False, True) for geom in touched)
    return body


def reach(body: Body) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """The corners (2, 3) of the upright box around what collides."""
    return upright([geom for geom in body.geoms if geom.collides], body.pose)


@pytest.mark.parametrize("faces", ["0, 1, 2, 3", "3, 2, 1, 0"])
@pytest.mark.parametrize("turn", [0, 180])
def test_a_ground_grows_downwards_however_it_is_turned(faces: str, turn: float) -> None:
    assert_allclose(reach(sheet(square(faces, turn))), [(-1, -1, -THICKNESS), (1, 1, 0)], atol=1e-7)


@pytest.mark.parametrize(("faces", "back"), [("0, 1, 2, 3", (0, THICKNESS)), ("3, 2, 1, 0", (-THICKNESS, 0))])
def test_a_wall_grows_behind_its_front(faces: str, back: tuple[float, float]) -> None:
    assert_allclose(reach(sheet(square(faces, 90)))[:, 1], back, atol=1e-7)


@pytest.mark.parametrize("text", [square(), SHEET % (ELL, "4, 4, 4", "0, 7, 3, 6, 7, 1, 2, 3, 6, 3, 4, 5", 0)])
def test_the_solids_are_closed_and_as_large_as_the_sheet(text: str) -> None:
    body = sheet(text)
    solids = [g.shape for g in body.geoms if g.collides and isinstance(g.shape, Mesh)]
    volume = 0.0
    for shape in solids:
        solid = trimesh.Trimesh(shape.points, shape.faces)
        assert solid.is_watertight
        volume += solid.volume
    assert volume == pytest.approx((4 if len(solids) == 1 else 3) * THICKNESS, rel=0.02)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_ball_rests_on_a_ground_and_falls_beside_it(engine: str) -> None:
    pytest.importorskip(engine)
    execute = import_module(f"wmspec.backends.{engine}").execute
    for at, end in (((0.5, 0.5), 0.1), ((1.5, 0), 0.1 - 9.81 / 8)):
        found = replace(read(stage(square() + BALL % at)), duration=0.5)
        ball = [body.name for body in found.bodies].index("ball")
        assert execute(found).position[-1, ball, 2] == pytest.approx(end, abs=5e-4)
