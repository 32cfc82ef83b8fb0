"""What is placed rests exactly: on flat and sloping faces, in hollows, above where it falls, apart from its like."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from wmspec.compile.design.design import Design
from wmspec.compile.layout import scatter
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir import ir
from wmspec.lang.check.statements.builder import action, compound, objects, observe, task, thing
from wmspec.sim.scene.model import Array, Body, Scene
from wmspec.sim.scene.model.transform import apply
from wmspec.sim.shapes.facets import tessellate
from wmspec.sim.usd import read

CAMERA = thing("camera", "front", at=(0, -2, 1))
ANGLES = st.floats(-3.1, 3.1)
LENGTHS = st.floats(0.02, 0.3)
WIDE = st.floats(1.0, 1.5)
"""Faces on which nothing of those lengths reaches over an edge."""
FINE = 2e-3
"""How far (of a round shape's size) its facets stay within it."""


def made(*parts: Any) -> ir.TaskSpec:
    """A task of these things, seen at one moment."""
    return task("placed", CAMERA, *parts, observe("front", [0.0]))


def values(*parts: Any, seed: int = 0) -> Evaluator:
    """What the only instance of such a task is."""
    spec = made(*parts)
    instance = Design(spec, seed)[0]
    return Evaluator(spec, instance.values, None, instance.key)


def scene(*parts: Any) -> Scene:
    """The stage of such a task, read back."""
    spec = made(*parts)
    return read(compose(document(spec, Design(spec)[0])))


def body(found: Scene, name: str) -> Body:
    return next(b for b in found.bodies if b.name == name)


def corners(found: Body) -> Array:
    """Points (n, 3) all over the surface of a body, in the world."""
    return np.concatenate([apply(found.pose, apply(g.pose, tessellate(g.shape).points)) for g in found.geoms])


@st.composite
def things(draw: st.DrawFn, lengths: st.SearchStrategy[float] = LENGTHS) -> dict[str, Any]:
    """The shape, size and turn of an object."""
    shape = draw(st.sampled_from(["box", "cube", "sphere", "cylinder", "cone", "capsule", "wedge"]))
    size: Any = draw(lengths)
    if shape in ("box", "wedge"):
        size = (size, draw(lengths), draw(lengths))
    turn = {name: draw(st.one_of(st.just(0.0), ANGLES)) for name in ("yaw", "pitch", "roll")}
    return {"shape": shape, "size": size, **turn}


@st.composite
def supports(draw: st.DrawFn) -> dict[str, Any]:
    """Something with flat faces, turned as it may be."""
    found = draw(things(WIDE).filter(lambda t: t["shape"] in ("box", "cube", "wedge")))
    if draw(st.booleans()):
        found = {"shape": "plane", "size": (1.0, 2.0), "yaw": draw(ANGLES), "pitch": draw(st.floats(-1, 1))}
    return found | {"at": (0.3, -0.2, 0.7), "fixed": True}


def outward(found: Body) -> tuple[Array, Array]:
    """The corner points and the normals (m, 3) of the faces of a body with flat faces, from its triangles."""
    geom = found.geoms[0]
    facets = tessellate(geom.shape)
    points = apply(found.pose, apply(geom.pose, facets.points))[facets.faces]
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    return points[:, 0], normals / np.linalg.norm(normals, axis=1, keepdims=True)


@settings(max_examples=30, deadline=None)
@given(thing_=things(), support=supports(), at=st.tuples(st.floats(-0.01, 0.01), st.floats(-0.01, 0.01)))
def test_resting_body_touches_the_upper_face_without_overlap(
    thing_: dict[str, Any], support: dict[str, Any], at: tuple[float, float]
) -> None:
    found = scene(thing("object", "base", **support), thing("object", "top", on="base", at=at, **thing_))
    points, normals = outward(body(found, "base"))
    level = np.sort(np.unique(np.round(normals[:, 2], 9)))
    assume(len(level) == 1 or level[-1] - level[-2] > 1e-6)  # else it is not clear which face looks up most
    face = int(normals[:, 2].argmax())
    depth = (corners(body(found, "top")) - points[face]) @ normals[face]
    size = np.max(thing_["size"])
    round_ = thing_["shape"] in ("sphere", "cylinder", "cone", "capsule")
    assert -1e-7 < depth.min() < (FINE * size if round_ else 1e-7)


def test_it_takes_on_the_slope() -> None:
    slope = thing("object", "ramp", shape="wedge", size=(0.4, 0.2, 0.3), fixed=True)
    found = scene(slope, thing("object", "rider", size=0.04, on="ramp", at=(0.1, 0.0)))
    rider = body(found, "rider").pose
    down = np.array([0.8, 0.0, -0.6])  # 3-4-5
    expected = np.array([0.0, 0.0, 0.15]) + 0.1 * down + 0.02 * np.array([0.6, 0.0, 0.8])
    np.testing.assert_allclose(rider.position, expected, atol=1e-12)
    np.testing.assert_allclose(apply(rider, np.array([1.0, 0.0, 0.0])) - rider.position, down, atol=1e-12)


def test_body_beside_a_tilted_box_rests_on_the_face_below() -> None:
    roof = thing("object", "roof", size=0.2, at=(0.0, 0.0, 0.5), pitch=math.pi / 4 - 0.1, fixed=True)
    mark = thing("object", "mark", size=0.01, at=(0.1, 0.0, 0.0), fixed=True)
    for far, sign in ((-0.05, 1.0), (-0.15, -1.0)):  # on either side of the ridge, which is at x = 0.01
        place = ir.Call(function="right_of", arguments=(ir.Value(value="mark"), ir.Value(value=far)))
        pose = values(roof, mark, thing("object", "a", shape="sphere", size=0.02, on="roof", at=place)).pose("a")
        assert math.copysign(1.0, pose.position[0] - (0.1 + far)) == sign


@pytest.mark.parametrize(("x", "height"), [(0.0, 0.02), (0.06, 0.12), (0.2, 0.0)])
def test_inside_means_on_the_lowest_part_below_the_place(x: float, height: float) -> None:
    box = {
        "floor": {"shape": "box", "size": (0.1, 0.1, 0.02), "at": (0, 0, 0.01)},
        "wall": {"shape": "box", "size": (0.02, 0.1, 0.12), "at": (0.06, 0, 0.06)},
        "lid": {"shape": "box", "size": (0.1, 0.1, 0.01), "at": (0, 0, 0.3)},
    }
    table = thing("object", "table", shape="plane", size=(2, 2), at=(0, 0, 0.4), fixed=True)
    parts = compound("tray", box, on="table", at=(0.5, 0.1), yaw=math.pi / 2)
    found = values(table, *parts, thing("object", "pea", shape="sphere", size=0.01, inside="tray", at=(x, 0)))
    np.testing.assert_allclose(found.pose("pea").position, (0.5, 0.1 + x, 0.4 + height + 0.005), atol=1e-12)


def test_relations_are_counted_from_the_middle() -> None:
    def call(name: str, *arguments: Any) -> ir.Call:
        return ir.Call(function=name, arguments=tuple(ir.Value(value=a) for a in arguments))

    places = {
        call("left_of", "a", 0.1): (0.1, 0.3),
        call("right_of", "a", 0.1): (0.3, 0.3),
        call("in_front_of", "a", 0.1): (0.2, 0.2),
        call("behind", "a", 0.1): (0.2, 0.4),
        call("polar", "a", 0.1, "away"): (0.2, 0.4),
        call("between", "a", "b"): (0.5, 0.1),
    }
    a, b = thing("object", "a", at=(0.2, 0.3, 0.5)), thing("object", "b", at=(0.8, -0.1, 0.5))
    for place, expected in places.items():
        found = values(a, b, thing("object", "c", size=0.2, at=place)).pose("c").position
        np.testing.assert_allclose(found, (*expected, 0.1), atol=1e-12)


def test_a_dropped_object_begins_above_where_it_would_rest_and_is_held() -> None:
    table = thing("object", "table", shape="box", size=(1, 1, 0.1), at=(0, 0, 0.35), fixed=True)
    ball = thing("object", "ball", shape="sphere", size=0.1, on="table", at=(0.1, 0.2))
    found = scene(table, ball, action("fall", "drop", object="ball", height=0.25, start=0.5))
    np.testing.assert_allclose(body(found, "ball").pose.position, (0.1, 0.2, 0.4 + 0.05 + 0.25))
    assert [(type(a).__name__, a.start) for a in found.actions] == [("Release", 0.5)]


# ---------------------------------------------------------------- scattered


def dots(count: int, present: int, **more: Any) -> tuple[ir.Entity, ...]:
    def properties(i: int) -> dict[str, Any]:
        return {"size": 0.02 + 0.001 * i, "on": "table", "scatter": (0.5, 0.3), "gap": 0.02, **more}

    return objects("dots", count, properties, present)


TABLE = thing("object", "table", shape="box", size=(1, 1, 0.1), at=(0, 0, 0.35), yaw=0.3, fixed=True)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000), shape=st.sampled_from(["cube", "sphere", "cylinder"]), yaw=ANGLES)
def test_scattered_objects_keep_their_gap_and_stay_in_the_field(seed: int, shape: str, yaw: float) -> None:
    found = values(TABLE, *dots(12, 12, shape=shape, yaw=yaw), seed=seed)
    edges = {f"dots_{i}": 0.02 + 0.001 * i for i in range(12)}
    radius = {n: e / 2 * (math.sqrt(2) if shape == "cube" else 1) for n, e in edges.items()}
    places = {name: np.array(found.pose(name).position) for name in edges}
    for a, b in combinations(edges, 2):
        assert np.hypot(*(places[a] - places[b])[:2]) >= radius[a] + radius[b] + 0.02 - 1e-12
    turn = np.array([[math.cos(0.3), math.sin(0.3)], [-math.sin(0.3), math.cos(0.3)]])
    for name, place in places.items():
        assert np.all(np.abs(turn @ place[:2]) <= (0.25, 0.15))
        assert place[2] == pytest.approx(0.4 + edges[name] / 2)


def test_number_of_members_moves_nothing_else() -> None:
    few, many = values(TABLE, *dots(9, 2)), values(TABLE, *dots(9, 7), thing("object", "other", on="table"))
    assert [few.is_present(f"dots_{i}") for i in range(9)] == [i < 2 for i in range(9)]
    assert all(few.pose(f"dots_{i}") == many.pose(f"dots_{i}") for i in range(9))


def test_another_seed_scatters_again_and_numbers_sort_numerically() -> None:
    one, other = values(TABLE, *dots(11, 11), seed=1), values(TABLE, *dots(11, 11), seed=2)
    assert all(one.pose(f"dots_{i}") != other.pose(f"dots_{i}") for i in range(11))
    fewer = values(TABLE, *dots(10, 10), seed=1)
    assert all(one.pose(f"dots_{i}") == fewer.pose(f"dots_{i}") for i in range(10))


def test_if_one_has_no_room_all_are_placed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    narrow = [values(TABLE, *dots(9, 9, scatter=(0.16, 0.16)), seed=seed) for seed in range(8)]
    assert all(there.pose("dots_8") for there in narrow)
    monkeypatch.setattr(scatter, "MAX_ROUNDS", 1)
    refused = 0
    for seed in range(8):
        try:
            values(TABLE, *dots(9, 9, scatter=(0.16, 0.16)), seed=seed).pose("dots_8")
        except WmsError:
            refused += 1
    assert 0 < refused < 8


def test_a_field_without_room_is_refused_with_a_remedy() -> None:
    with pytest.raises(WmsError, match=r"no room for `dots_\d`.*widen `scatter`"):
        document(spec := made(TABLE, *dots(9, 9, scatter=(0.05, 0.05))), Design(spec)[0])


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ((thing("object", "a", on="a"),), "`a` cannot rest on itself"),
        ((thing("object", "a", on="b"), thing("object", "b", on="a")), "depends on itself"),
        ((thing("object", "a", on="table", at=(0, 0, 1)),), "its place there is"),
        ((thing("object", "a", inside="table"),), "`table` has no parts"),
        (
            (thing("object", "a", shape="sphere", size=(0.1, 0.1, 0.1)),),
            "a wedge or a rounded_box has three edges",
        ),
        ((thing("object", "a", shape="box", size=(0.1, 0.1)),), "only a plane has two edges"),
    ],
)
def test_impossible_places_and_sizes_are_refused(parts: tuple[ir.Entity, ...], message: str) -> None:
    with pytest.raises(WmsError, match=message):
        document(spec := made(TABLE, *parts), Design(spec)[0])
