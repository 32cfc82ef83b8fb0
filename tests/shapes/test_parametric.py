"""Turned profiles, extruded outlines, rounded boxes, tubes and tori: what they weigh, how they collide and rest."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.engines import ENGINES, installed
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import pieces
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.core.diagnostics import ImpossibleValue, StageError
from wmspec.lang.check.statements.builder import observe, task, thing
from wmspec.sim.scene.model import Scene
from wmspec.sim.shapes import SHAPES, Box, Cone, Cylinder, Extrude, Lathe, RoundedBox, Shape, Sphere, Sweep, Torus, Tube
from wmspec.sim.shapes.facets import tessellate
from wmspec.sim.shapes.outline import Outline, checked_outline, convex
from wmspec.sim.shapes.shape import UnfitError
from wmspec.sim.usd import read

lengths = st.floats(0.01, 1)
CUP = ((0.0, 0.003), (0.04, 0.0), (0.04, 0.095), (0.036, 0.095), (0.036, 0.005), (0.0, 0.005))
HANDLE = ((0.0, 0.0, 0.0), (0.05, 0.0, 0.0), (0.07, 0.03, 0.0), (0.02, 0.05, 0.0), (0.02, 0.05, 0.06))
STAIRS = ((0.0, 0.0), (0.09, 0.0), (0.09, 0.03), (0.06, 0.03), (0.06, 0.06), (0.0, 0.06))


@st.composite
def outlines(draw: st.DrawFn) -> Outline:
    """Points around (0.5, 0), in any shape that a star can have."""
    count = draw(st.integers(3, 9))
    radii = draw(st.lists(st.floats(0.05, 0.4), min_size=count, max_size=count))
    turns = [2 * math.pi * i / count for i in range(count)]
    points = [(0.5 + r * math.cos(t), r * math.sin(t)) for r, t in zip(radii, turns, strict=True)]
    return checked_outline(points[:: draw(st.sampled_from([1, -1]))], "outline")


def meshed(shape: Shape) -> Any:
    facets = tessellate(shape)
    mesh = trimesh.Trimesh(facets.points, facets.faces)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return mesh


def revolved(profile: Outline) -> Any:
    """The solid of a finely turned profile."""
    n = 720
    turns = np.arange(n) * 2 * math.pi / n
    r, z = np.array(profile).T
    points = np.stack(np.broadcast_arrays(r * np.cos(turns)[:, None], r * np.sin(turns)[:, None], z), -1).reshape(-1, 3)
    k, i, j = len(profile), *np.meshgrid(np.arange(n), np.arange(len(profile)), indexing="ij")
    a, b = i * k + j, i * k + (j + 1) % k
    c, d = (i + 1) % n * k + (j + 1) % k, (i + 1) % n * k + j
    faces = np.concatenate([np.stack([a, d, c], -1).reshape(-1, 3), np.stack([a, c, b], -1).reshape(-1, 3)])
    return trimesh.Trimesh(points, faces)


def assert_weighs(shape: Shape, solid: Any, within: float) -> None:
    assert solid.volume == pytest.approx(shape.volume, rel=within)
    np.testing.assert_allclose(solid.center_mass, shape.center, atol=within)
    tensor = solid.moment_inertia / solid.mass
    np.testing.assert_allclose(tensor, shape.tensor, atol=within * np.abs(tensor).max())


@settings(max_examples=15)
@given(outlines())
def test_a_lathe_weighs_what_its_profile_holds_when_turned(profile: Outline) -> None:
    assert_weighs(Lathe(profile), revolved(profile), 1e-4)


@settings(max_examples=25)
@given(outlines(), lengths)
def test_an_extruded_outline_weighs_what_its_triangles_hold(outline: Outline, depth: float) -> None:
    assert_weighs(Extrude(outline, depth), meshed(Extrude(outline, depth)), 1e-9)


def test_things_lie_on_the_floor_of_what_is_turned() -> None:
    mug = Lathe(((0.0, 0.0), (0.04, 0.0), (0.04, 0.1), (0.03, 0.1), (0.03, 0.02), (0.0, 0.01)))
    assert mug.floor(0.0, 0.0) == pytest.approx(0.01)
    assert mug.floor(0.0, 0.015) == pytest.approx(0.015)
    assert mug.floor(0.02, 0.029) == pytest.approx(0.1), "on its rim"
    assert mug.floor(0.03, 0.03) is None, "beside it"


@given(lengths, lengths)
def test_a_lathe_makes_cylinders_and_cones(r: float, h: float) -> None:
    for shape, profile in (
        (Cylinder(r, h), ((0.0, -h / 2), (r, -h / 2), (r, h / 2), (0.0, h / 2))),
        (Cone(r, h), ((0.0, -h / 2), (r, -h / 2), (0.0, h / 2))),
    ):
        made = Lathe(profile)
        assert made.volume == pytest.approx(shape.volume)
        np.testing.assert_allclose(made.center, shape.center, atol=1e-12)
        np.testing.assert_allclose(made.tensor, shape.tensor, rtol=1e-6, atol=1e-12)
        for d in ((0.6, 0.0, 0.8), (0.0, -1.0, 0.0), (0.48, 0.64, -0.6)):
            assert made.reach(d) == pytest.approx(shape.reach(d))


@given(lengths, st.floats(0.05, 0.9), lengths)
def test_a_tube_is_a_cylinder_without_another(r: float, part: float, h: float) -> None:
    tube = Tube.from_words({"size": 1.0, "radius": r, "height": h, "thickness": r * part})
    outer, inner = Cylinder(r, h), Cylinder(r * (1 - part), h)
    assert tube.volume == pytest.approx(outer.volume - inner.volume)
    whole = [np.array(c.tensor) * c.volume for c in (outer, inner)]
    np.testing.assert_allclose(tube.tensor, (whole[0] - whole[1]) / tube.volume, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("thickness", [0.02, 0.3])
def test_a_torus(thickness: float) -> None:
    shape = Torus.from_words({"size": 1.0, "thickness": thickness})
    assert isinstance(shape, Torus)
    fine = trimesh.creation.torus(shape.radius, shape.thick / 2, major_sections=400, minor_sections=200)
    assert_weighs(shape, fine, 1e-3)


@given(st.tuples(lengths, lengths, lengths), st.floats(0.01, 0.99))
def test_a_rounded_box_is_between_a_box_and_a_ball(size: tuple[float, float, float], part: float) -> None:
    shape = RoundedBox.from_words({"size": size, "round": min(size) / 2 * part})
    assert isinstance(shape, RoundedBox)
    ball = Sphere(shape.round)
    ways = trimesh.creation.icosphere(4).vertices
    signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
    inner = np.array(shape.half) - shape.round
    grown = trimesh.convex.convex_hull((signs[:, None] * inner + ball.radius * ways).reshape(-1, 3))
    assert_weighs(shape, grown, 4e-3)
    assert shape.volume < Box(shape.half).volume


@given(outlines())
def test_convex_pieces_cover_an_outline(outline: Outline) -> None:
    def area(points: Outline) -> float:
        return sum(x * v - u * y for (x, y), (u, v) in zip(points, (*points[1:], points[0]), strict=True)) / 2

    found = convex(outline)
    assert sum(map(area, found)) == pytest.approx(area(outline), rel=0.1)
    assert sum(map(area, found)) >= area(outline) * (1 - 1e-9)
    for piece in found:
        corners = zip((piece[-1], *piece[:-1]), piece, (*piece[1:], piece[0]), strict=True)
        assert all((b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) >= -1e-9 for a, b, c in corners)


@example([(0.01, 0.010000000000000002, 0.01), (0.01, 0.01, 0.01)])
@given(st.lists(st.tuples(lengths, lengths, lengths), min_size=2, max_size=5))
def test_a_sweep_weighs_its_section_along_its_path(along: list[tuple[float, float, float]]) -> None:
    try:
        shape = Sweep.from_words({"size": 1.0, "along": along, "thickness": 0.02})
    except UnfitError:
        return
    assert_weighs(shape, meshed(shape), 1e-6)
    assert sum(piece.volume for piece, _ in shape.pieces) == pytest.approx(shape.volume, rel=1e-6)


EXAMPLES: list[tuple[str, dict[str, Any]]] = [
    ("rounded_box", {"size": (0.09, 0.06, 0.04), "round": 0.012}),
    ("tube", {"radius": 0.03, "height": 0.08, "thickness": 0.004}),
    ("torus", {"size": 0.12, "thickness": 0.02}),
    ("lathe", {"profile": CUP}),
    ("extrude", {"outline": STAIRS, "depth": 0.06}),
    ("sweep", {"along": HANDLE, "thickness": 0.01}),
]


@pytest.mark.parametrize(("word", "words"), EXAMPLES, ids=[word for word, _ in EXAMPLES])
def test_they_are_drawn_closed_and_from_outside(word: str, words: dict[str, Any]) -> None:
    shape = SHAPES[word].from_words({"size": 0.1, **words})
    facets, mesh = tessellate(shape), meshed(shape)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(shape.volume, rel=0.02)
    first, second, third = (facets.points[facets.faces[:, k]] for k in range(3))
    across = np.cross(second - first, third - first)
    assert (np.einsum("ij,ij->i", across, facets.normals[facets.faces].mean(axis=1)) > 0).all()
    ways = np.random.default_rng(0).normal(size=(50, 3))
    for way in ways / np.linalg.norm(ways, axis=1, keepdims=True):
        drawn = (facets.points @ way).max()
        touched = max((piece.corners() @ way).max() for piece, _ in shape.pieces)
        assert shape.reach(tuple(way)) == pytest.approx(drawn, abs=2e-3)
        assert shape.reach(tuple(way)) == pytest.approx(touched, abs=2e-3)


def placed() -> Scene:
    """All of them on a slab, and a ball above the cup."""
    slab = thing("object", "slab", shape="box", size=(2.0, 2.0, 0.1), at=(0.0, 0.0, -0.05), fixed=True)
    things = [
        thing("object", word, shape=word, on="slab", at=(0.2 * i, 0.0), yaw=0.3 * i, **words)
        for i, (word, words) in enumerate(EXAMPLES)
    ]
    ball = thing("object", "ball", shape="sphere", size=0.04, at=(0.6, 0.0, 0.2))
    eye = thing("camera", "front", at=(0.0, -2.0, 1.0))
    spec = task("placed", eye, slab, *things, ball, observe("front", [0.0, 1.0]))
    return read(compose(document(spec, Design(spec)[0])))


def test_nothing_is_lost_on_the_stage() -> None:
    scene = placed()
    for word, words in EXAMPLES:
        body = next(b for b in scene.bodies if b.name == word)
        shape = SHAPES[word].from_words({"size": 0.1, **words})
        assert body.geoms[0].shape == shape
        assert body.inertia is not None
        assert body.inertia.mass == pytest.approx(600 * shape.volume, rel=1e-6)


BROKEN = {
    "primvars:st": ([(0.5, 0.5)], "primvars:st .* does not fit"),
    "faceVertexCounts": ([3], "faceVertexCounts and faceVertexIndices do not fit"),
    "points": ([(0.0, 0.0, 0.0)], "faceVertexIndices and points do not fit"),
    "wms:shape:depth": (0.2, "its points differ from those of the extrude"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_shape_with_other_geometry_is_refused(name: str) -> None:
    value, message = BROKEN[name]
    eye, stairs = thing("camera", "front", at=(0.0, -2.0, 1.0)), dict(EXAMPLES)["extrude"]
    stair = thing("object", "stair", shape="extrude", at=(0.0, 0.0, 0.5), fixed=True, **stairs)
    spec = task("broken", eye, stair, observe("front", [0.0]))
    stage = compose(document(spec, Design(spec)[0]))
    mesh = stage.GetPrimAtPath("/World/Objects/stair/extrude")
    assert read(stage).bodies[0].geoms[0].shape == SHAPES["extrude"].from_words({"size": 0.1, **stairs})
    mesh.GetAttribute(name).Set(value)
    with pytest.raises(StageError, match=message):
        read(stage)


@pytest.mark.parametrize("engine", ENGINES)
def test_containers_rest_and_hold_falling_objects(engine: str) -> None:
    trace = installed(engine).execute(placed())
    for i, name in enumerate(trace.bodies):
        path = trace.position[:, i]
        if name == "ball":
            np.testing.assert_allclose(path[-1], (0.6, 0, 0.005 + 0.02), atol=1e-3)
        else:
            assert np.abs(path - path[0]).max() < 5e-4, name


@pytest.mark.parametrize(
    ("word", "words", "message"),
    [
        ("lathe", {}, "needs three points or more in its profile"),
        ("lathe", {"profile": ((0.0, 0.0), (-0.1, 0.0), (0.1, 0.1))}, "both sides of the axis"),
        ("extrude", {"outline": ((0.0, 0.0), (0.1, 0.1), (0.1, 0.0), (0.0, 0.1))}, "crosses or touches itself"),
        ("extrude", {"outline": ((0.0, 0.0), (0.1, 0.0), (0.05, 0.0))}, "crosses or touches itself"),
        ("tube", {"thickness": 0.05}, "is filled by its own wall"),
        ("torus", {"thickness": 0.05}, "has no hole"),
        ("sweep", {}, "needs two points or more along its path"),
        ("sweep", {"along": ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 0.0))}, "bends too sharply"),
        ("sweep", {"along": ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.1, 0.01, 0.0)), "thickness": 0.05}, "too sharply"),
        ("rounded_box", {"round": 0.05}, "is thinner than its round edges"),
    ],
)
def test_impossible_shapes_are_refused(word: str, words: dict[str, Any], message: str) -> None:
    with pytest.raises(UnfitError, match=message):
        SHAPES[word].from_words({"size": 0.1, **words})
    spec = task("t", thing("object", "a", shape=word, at=(0.0, 0.0, 0.0), **words))
    with pytest.raises(ImpossibleValue, match=message):
        pieces(Evaluator(spec, {}), "a")
