"""Every verb of a WmsAction is read as what it says, in metres and Z up, or refused with its prim."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.stage.stages import assert_same, stage
from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.model import Follow, Force, Impulse, Release, Teleport
from wmspec.sim.usd import read

BODIES = """
def Sphere "ball" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {}
def Sphere "cart" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {
    bool physics:kinematicEnabled = 1 }
def Sphere "rock" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {}
"""
ACTION = """def WmsAction "a" { uniform token wms:verb = "%s" rel wms:object = </World/%s>
    uniform double wms:start = 0.5
    %s }"""
HALF = math.sqrt(0.5)


def action(verb: str, body: str, more: str = "", **header: float | str) -> object:
    (found,) = read(stage(BODIES + ACTION % (verb, body, more), **header)).actions  # type: ignore[arg-type]
    return found


def test_each_verb() -> None:
    way = """uniform double[] wms:times = [0, 1]
        uniform double3[] wms:points = [(0, 0, 0), (1, 2, 3)]"""
    turns = way + "\nuniform quatd[] wms:orientations = [(1, 0, 0, 0), (0, 0, 0, 1)]"
    points, times = np.array([[0.0, 0, 0], [1, 2, 3]]), np.array([0.0, 1.0])
    assert_same(action("follow", "cart", way), Follow("a", "cart", 0.5, times, points, None))
    ends = np.array([[1.0, 0, 0, 0], [0, 0, 0, 1]])
    assert_same(action("follow", "cart", turns), Follow("a", "cart", 0.5, times, points, ends))
    place = "uniform double3 wms:position = (1, 2, 3)\nuniform quatd wms:orientation = (0, 1, 0, 0)"
    for body in ("cart", "ball"):
        turned = Teleport("a", body, 0.5, np.array([1.0, 2, 3]), np.array([0.0, 1, 0, 0]))
        assert_same(action("teleport", body, place), turned)
        kept = Teleport("a", body, 0.5, np.array([1.0, 2, 3]), None)
        assert_same(action("teleport", body, place.split("\n", maxsplit=1)[0]), kept)
    hit = "uniform double3 wms:impulse = (1, 2, 3)"
    assert_same(action("impulse", "ball", hit), Impulse("a", "ball", 0.5, np.array([1.0, 2, 3])))
    push = "uniform double wms:duration = 2\nuniform double3 wms:force = (1, 2, 3)"
    assert_same(action("force", "ball", push), Force("a", "ball", 0.5, 2.5, np.array([1.0, 2, 3])))
    assert_same(action("release", "ball"), Release("a", "ball", 0.5))


def test_places_are_metres_in_the_axes_of_the_stage() -> None:
    """A stage in centimetres, Y up: its y is our z, and what is not turned on it is turned by 90 degrees here."""
    place = "uniform double3 wms:position = (1, 2, 3)\nuniform quatd wms:orientation = (1, 0, 0, 0)"
    found = action("teleport", "cart", place, meters=0.01, up="Y")
    assert isinstance(found, Teleport)
    assert_allclose(found.position, (1, -3, 2), atol=1e-12)
    assert found.orientation is not None
    assert_allclose(found.orientation, (HALF, HALF, 0, 0), atol=1e-12)
    assert_same(found.orientation, read(stage(BODIES, up="Y")).bodies[1].pose.orientation)


WAY = "uniform double[] wms:times = %s\nuniform double3[] wms:points = [(0, 0, 0), (1, 2, 3)]"
REFUSED = {
    "static": ("impulse", "rock", "", "impulse needs a dynamic body, but /World/rock is static"),
    "kinematic": ("release", "cart", "", "release needs a dynamic body"),
    "dynamic": ("glide", "ball", "", "glide needs a kinematic body"),
    "short": ("follow", "cart", WAY % "[0]", "1 wms:times, 2 wms:points"),
    "backwards": ("follow", "cart", WAY % "[0, -1]", "expected increasing times"),
    "late": ("follow", "cart", WAY % "[1, 2]", "expected increasing times"),
    "duration": ("follow", "cart", WAY % "[0, 1]" + "\nuniform double wms:duration = 3", "not the last"),
    "quaternion": ("teleport", "cart", "uniform quatd wms:orientation = (1, 1, 0, 0)", "no unit quaternion"),
    "infinite": ("impulse", "ball", "uniform double3 wms:impulse = (inf, 0, 0)", "finite"),
    "unknown": ("shout", "ball", "", "expected one of: launch, glide, follow"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_nonsense_is_refused(case: str) -> None:
    verb, body, more, message = REFUSED[case]
    with pytest.raises(StageError, match=message) as caught:
        action(verb, body, more)
    assert [str(problem.place) for problem in caught.value.diagnostics] == ["/World/a"]


def test_moves_of_one_body_do_not_overlap() -> None:
    moves = BODIES + ACTION % ("follow", "cart", WAY % "[0, 1]")
    second = (ACTION % ("teleport", "cart", "")).replace('"a"', '"b"').replace("0.5", "1.2")
    with pytest.raises(StageError, match="/World/b: it starts while /World/a still moves cart"):
        read(stage(moves + second))
    assert len(read(stage(moves + second.replace("1.2", "1.5"))).actions) == 2
