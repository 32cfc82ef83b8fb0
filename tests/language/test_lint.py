"""What linting finds in the first scenes: objects inside one another, and cameras that look elsewhere."""

import math
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import linprog

from tests.examples import examples
from tests.language.specs import random_text, task_from
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import pieces
from wmspec.compile.lint.overlap import MAX_OVERLAP, Overlap, overlaps
from wmspec.compile.lint.visibility import blind_cameras
from wmspec.lang.check.statements.builder import action, observe, task, thing

ANGLES = st.floats(-3, 3)
PLACES = st.tuples(*[st.floats(-0.12, 0.12)] * 3)
FORMS = st.sampled_from(
    [
        {"shape": "box", "size": (0.1, 0.06, 0.2)},
        {"shape": "wedge", "size": (0.2, 0.1, 0.08)},
        {"shape": "cube", "size": 0.1},
        {"shape": "sphere", "size": 0.1},
        {"shape": "cylinder", "size": 0.1, "height": 0.2},
        {"shape": "cone", "size": 0.16, "height": 0.1},
        {"shape": "capsule", "size": 0.2},
    ]
)


def found(*things: object) -> list[Overlap]:
    spec = task("t", *things, observe("front", [0.0]))  # type: ignore[arg-type]
    return list(overlaps(Evaluator(spec, {})))


@given(r=st.floats(0.01, 0.1), s=st.floats(0.01, 0.1), at=PLACES)
def test_spheres_are_as_deep_in_one_another_as_their_radii_exceed_their_distance(
    r: float, s: float, at: tuple[float, float, float]
) -> None:
    ball = thing("object", "ball", shape="sphere", radius=r, at=(0.0, 0.0, 0.0))
    other = thing("object", "other", shape="sphere", radius=s, at=at)
    depth = min(r + s - math.hypot(*at), 2 * r, 2 * s)
    reported = found(ball, other)
    assert bool(reported) == (depth > MAX_OVERLAP)
    if reported:
        assert reported[0].depth == pytest.approx(depth, abs=1e-4)


@examples(50, 150, deadline=None)
@given(forms=st.tuples(FORMS, FORMS), at=PLACES, turns=st.tuples(*[ANGLES] * 6))
def test_solids_overlap_if_some_point_is_inside_both(
    forms: tuple[dict[str, Any], dict[str, Any]], at: tuple[float, float, float], turns: tuple[float, ...]
) -> None:
    """The oracle: a linear program looks for a point that is a mean of surface points of both."""
    poses: list[dict[str, Any]] = [dict(zip(("yaw", "pitch", "roll"), t, strict=True)) for t in (turns[:3], turns[3:])]
    a = thing("object", "a", **forms[0], **poses[0], at=(0.0, 0.0, 0.0))
    b = thing("object", "b", **forms[1], **poses[1], at=at)
    reported = found(a, b)
    values = Evaluator(task("t", a, b, observe("front", [0.0])), {})
    if reported and reported[0].depth > 3e-3:  # the surface points of round solids are on polygons within them
        assert _meet(_surface(values, "a"), _surface(values, "b"))
    if not reported:
        assert not _meet(0.97 * _surface(values, "a"), _surface(values, "b") * 0.97 + 0.03 * np.array(at))


def _surface(values: Evaluator, name: str) -> NDArray[np.float64]:
    """Points whose hull is the solid, or for a round one almost."""
    (piece,) = pieces(values, name)
    x, y, z = piece.solid.half_extent
    ring = [(math.cos(t), math.sin(t)) for t in np.linspace(0, 2 * math.pi, 48, endpoint=False)]
    ball = [(math.cos(e) * c, math.cos(e) * s, math.sin(e)) for c, s in ring for e in np.linspace(-1.5, 1.5, 15)]
    match values.property(name, "shape"):
        case "box" | "cube":
            points = np.array(list(product((-x, x), (-y, y), (-z, z))))
        case "wedge":
            points = np.array([(u, v, -z) for u in (-x, x) for v in (-y, y)] + [(-x, v, z) for v in (-y, y)])
        case "sphere":
            points = x * np.array(ball)
        case "cylinder":
            points = np.array([(x * c, x * s, h) for c, s in ring for h in (-z, z)])
        case "cone":
            points = np.array([(x * c, x * s, -z) for c, s in ring] + [(0, 0, z)])
        case _:
            points = np.array([(x * u, x * v, x * w + h) for u, v, w in ball for h in (x - z, z - x)])
    return np.array([values.pose(name).apply(p) for p in points.tolist()])


def _meet(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    equal = np.vstack([np.hstack([a.T, -b.T]), [[1.0] * len(a) + [0.0] * len(b)], [[0.0] * len(a) + [1.0] * len(b)]])
    solved = linprog(np.zeros(len(a) + len(b)), A_eq=equal, b_eq=[0, 0, 0, 1, 1], bounds=(0, None))
    return bool(solved.success)


def test_bodies_without_collision_may_overlap() -> None:
    here: dict[str, Any] = {"shape": "cube", "size": 0.1, "at": (0.0, 0.0, 0.0)}
    a = thing("object", "a", **here)
    assert found(a, thing("object", "b", **here))
    assert not found(a, thing("object", "b", **here, fixed=True, solid=False))
    assert not found(thing("object", "a", **here, fixed=True), thing("object", "b", **here, fixed=True))
    assert not found(a, thing("object", "b", **here, present=False))


@examples(8, 25, deadline=None)
@given(text=random_text(), data=st.data())
def test_resting_body_is_not_inside_its_support(text: str, data: st.DataObject) -> None:
    design = Design(task_from(text))
    instance = design[data.draw(st.integers(0, len(design) - 1))]
    values = Evaluator(design.spec, instance.values, None, instance.key)
    assert "table" not in {pair.first for pair in overlaps(values)}


# ---------------------------------------------------------------- cameras


@settings(max_examples=100, deadline=None)
@given(eye=PLACES, target=PLACES, ball=PLACES, fov=st.floats(0.1, 2))
def test_a_camera_is_blind_only_if_the_middle_is_out_of_its_picture(
    eye: tuple[float, ...], target: tuple[float, ...], ball: tuple[float, ...], fov: float
) -> None:
    ahead = np.array(target) - eye
    if np.linalg.norm(ahead) < 0.01:
        return
    camera = thing("camera", "eye", at=eye, look_at=target, fov=fov)
    seen = thing("object", "ball", shape="sphere", size=0.02, at=ball)
    pushed = action("push", "launch", object="ball", direction=0.0, speed=0.0)
    values = Evaluator(task("t", camera, seen, pushed, observe("eye", [0.0])), {})
    forward = ahead / np.linalg.norm(ahead)
    there = np.array(ball) - eye
    along = float(there @ forward)
    off = math.atan2(float(np.linalg.norm(there - along * forward)), along)
    if off < fov / 2:
        assert blind_cameras(values) == ()
    if off > fov / 2 * math.sqrt(2) + 0.1 and np.linalg.norm(there) > 0.2 and fov < 1:
        assert blind_cameras(values) == ("eye",)


def test_object_that_moves_into_view_is_seen() -> None:
    camera = thing("camera", "eye", at=(2.0, -1.0, 0.1), look_at=(2.0, 0.0, 0.1), fov=0.3)
    ball = thing("object", "ball", shape="sphere", size=0.1, at=(0.0, 0.0, 0.1))
    for pace, expected in ((1.5, ()), (0.5, ("eye",))):
        go = action("go", "glide", object="ball", direction=0.0, speed=pace, duration=2.0)
        spec = task("t", camera, ball, go, observe("eye", [0.0, 2.0]))
        assert blind_cameras(Evaluator(spec, {})) == expected


def test_riding_camera_and_questionless_task_have_no_blind_camera() -> None:
    away: dict[str, Any] = {"at": (0.0, -1.0, 0.1), "look_at": (0.0, -2.0, 0.1)}
    ball = thing("object", "ball", shape="sphere", size=0.1, at=(0.0, 0.0, 0.1))
    go = action("go", "glide", object="ball", direction=0.0, speed=1.0, duration=1.0)
    still, riding = thing("camera", "eye", **away), thing("camera", "eye", **away, ride="ball")
    assert blind_cameras(Evaluator(task("t", still, ball, go, observe("eye", [0.0])), {})) == ("eye",)
    assert blind_cameras(Evaluator(task("t", riding, ball, go, observe("eye", [0.0])), {})) == ()
    assert blind_cameras(Evaluator(task("t", still, ball, observe("eye", [0.0])), {})) == ()
