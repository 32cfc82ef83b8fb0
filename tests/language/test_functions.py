"""What can be computed before the simulation: places, sums, volumes, colours, what is there, what fits."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wmspec.compile.design.design import Design
from wmspec.compile.layout.cavities import has_room
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.view import gaze_direction, view_coordinates
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir import ir
from wmspec.lang.check.statements.builder import compound, objects, observe, task, thing

CAMERA = thing("camera", "front", at=(0, -2, 1))
TRAY = {
    "left": {"shape": "box", "size": (0.02, 0.1, 0.1), "at": (-0.06, 0, 0.05)},
    "right": {"shape": "box", "size": (0.02, 0.1, 0.1), "at": (0.06, 0, 0.05)},
    "lid": {"shape": "box", "size": (0.14, 0.1, 0.02), "at": (0, 0, 0.11)},
}
"""A hollow of 10 x 10 x 10 cm, open at the front and the back."""


def values(*parts: Any) -> Evaluator:
    """What the only instance of a task of these things is."""
    spec = task("t", CAMERA, *parts, observe("front", [0.0]))
    return Evaluator(spec, Design(spec)[0].values)


@pytest.mark.parametrize(
    ("function", "arguments", "expected"),
    [
        ("min", (3.0, 2.0, 5.0), 2.0),
        ("max", (3.0, 2.0, 5.0), 5.0),
        ("abs", (-2.0,), 2.0),
        ("floor", (-0.5,), -1.0),
        ("mod", (7.5, 2.0), 1.5),
        ("mod", (-1.0, 3.0), 2.0),
        ("sqrt", (2.25,), 1.5),
        ("atan", (1.0,), math.pi / 4),
        ("atan", (-1e9,), -math.pi / 2),
        ("sin", (math.pi / 6,), 0.5),
        ("cos", (math.pi,), -1.0),
        ("opposite", ("left",), 2 * math.pi),
    ],
)
def test_sums(function: str, arguments: tuple[Any, ...], expected: float) -> None:
    assert values().call(function, arguments) == pytest.approx(expected)


@pytest.mark.parametrize(("function", "arguments"), [("sqrt", (-1.0,)), ("mod", (1.0, 0.0)), ("largest", ((),))])
def test_undefined_values_are_errors(function: str, arguments: tuple[Any, ...]) -> None:
    with pytest.raises(WmsError):
        values().call(function, arguments)


@pytest.mark.parametrize(
    ("properties", "volume"),
    [
        ({"shape": "cube", "size": 0.2}, 0.008),
        ({"shape": "box", "size": (0.1, 0.2, 0.3)}, 0.006),
        ({"shape": "wedge", "size": (0.1, 0.2, 0.3)}, 0.003),
        ({"shape": "sphere", "radius": 0.1}, 4 / 3 * math.pi * 1e-3),
        ({"shape": "cylinder", "size": 0.2, "height": 0.5}, math.pi * 0.01 * 0.5),
        ({"shape": "cone", "size": 0.2, "height": 0.3}, math.pi * 0.001),
        (
            {"shape": "capsule", "size": 0.2, "height": 0.5, "radius": 0.1},
            math.pi * 0.01 * 0.3 + 4 / 3 * math.pi * 1e-3,
        ),
        ({"shape": "plane", "size": (2, 3)}, 0.6),
    ],
)
def test_volumes(properties: dict[str, Any], volume: float) -> None:
    assert values(thing("object", "a", **properties)).call("volume", ("a",)) == pytest.approx(volume)


def test_a_compound_takes_the_room_of_its_parts() -> None:
    assert values(*compound("tray", TRAY)).call("volume", ("tray",)) == pytest.approx(2 * 0.0002 + 0.00028)


def test_largest_needs_a_lead_beyond_a_tie() -> None:
    small, big = thing("object", "small", size=0.1), thing("object", "big", shape="sphere", size=0.13)
    found = values(small, big)  # 1 and 1.15 dm³
    assert found.call("largest", (("small", "big"),)) == "big"
    assert found.call("largest", (("small", "big"), 1.1)) == "big"
    assert found.call("largest", (("small", "big"), 1.2)) == "neither"
    assert found.call("smallest", (("small", "big"), 1.1)) == "small"


def test_colours_are_ranked_by_how_light_they_are() -> None:
    found = values(*(thing("object", c, color=c) for c in ("black", "yellow", "blue")))
    assert found.call("darkest", (("yellow", "black", "blue"),)) == "black"
    assert found.call("lightest", (("black", "yellow", "blue"),)) == "yellow"
    white = values(thing("object", "a", color="rgb:1,1,1")).call("luminance", ("a",))
    assert white == pytest.approx(1.0)


@given(
    color=st.sampled_from(["red", "green", "blue", "yellow", "purple"]), shares=st.lists(st.floats(0, 1), min_size=2)
)
def test_shades_get_lighter(color: str, shares: list[float]) -> None:
    made = [values().call("shade", (color, share)) for share in sorted(shares)]
    light = [values(thing("object", "a", color=c)).call("luminance", ("a",)) for c in made]
    assert light == sorted(light)


def test_only_what_is_there_is_counted() -> None:
    dots = objects("dots", 5, lambda i: {"size": 0.1}, 3)
    found = values(*dots)
    names = tuple(d.name for d in dots)
    assert found.call("present", (names,)) == names[:3]
    assert found.call("count", (names,)) == 3.0


# ---------------------------------------------------------------- what fits


@pytest.mark.parametrize(
    ("properties", "fits"),
    [
        ({"size": 0.1}, True),
        ({"size": 0.1001}, False),
        ({"shape": "box", "size": (0.05, 0.11, 0.05)}, False),  # it would stick out at the front
        ({"shape": "box", "size": (0.02, 0.02, 0.1)}, True),
        ({"shape": "box", "size": (0.02, 0.02, 0.11)}, False),
        ({"shape": "cylinder", "size": 0.09}, True),
        ({"size": 0.09, "yaw": math.pi / 4}, False),
    ],
)
def test_fits_in_a_hollow(properties: dict[str, Any], fits: bool) -> None:
    for yaw in (0.0, 0.7):  # both turned, the hollow is the same
        turned = properties | {"yaw": properties.get("yaw", 0.0) + yaw}
        found = values(*compound("tray", TRAY, at=(1, 2, 3), yaw=yaw), thing("object", "a", **turned))
        assert found.call("fits", ("a", "tray")) is fits


BOXES = st.tuples(*(st.integers(0, 3) for _ in range(3)), *(st.integers(1, 2) for _ in range(3)))


@settings(max_examples=100)
@given(parts=st.lists(BOXES, min_size=1, max_size=5), edges=st.tuples(*(st.integers(1, 4) for _ in range(3))))
def test_a_box_has_room_where_trying_every_place_finds_some(
    parts: list[tuple[int, ...]], edges: tuple[int, int, int]
) -> None:
    boxes = [(tuple(map(float, p[:3])), tuple(float(a + b) for a, b in zip(p[:3], p[3:], strict=True))) for p in parts]
    full = np.zeros((5, 5, 5), bool)
    for low, high in boxes:
        full[tuple(slice(int(a), int(b)) for a, b in zip(low, high, strict=True))] = True
    whole = ((0.0, 0.0, 0.0), (5.0, 5.0, 5.0))
    starts = product(*(range(6 - e) for e in edges))
    tried = any(not full[tuple(slice(s, s + e) for s, e in zip(start, edges, strict=True))].any() for start in starts)
    assert has_room(tuple(map(float, edges)), whole, boxes) is tried  # type: ignore[arg-type]


def test_place_of_a_property_out_of_bounds_is_reported() -> None:
    shrunk = thing("object", "a", size=ir.Operation(operator="-", operands=(ir.Value(value=0.1), ir.Value(value=0.2))))
    with pytest.raises(WmsError, match=r"`size` of `a` is -10 cm here; it must be more than 0"):
        values(shrunk).pose("a")


def test_the_least_of_none_has_no_value() -> None:
    for name in ("min", "max"):
        with pytest.raises(WmsError, match="none to choose from"):
            values().call(name, ((),))
    assert values().call("sum", ((),)) == 0
    assert (values().call("any", ((),)), values().call("all", ((),))) == (False, True)


def test_items_from_the_end() -> None:
    assert values().call("nth", (("a", "b", "c"), -1.0)) == "c"
    with pytest.raises(WmsError, match="index -4 is out of range"):
        values().call("nth", (("a", "b", "c"), -4.0))


@given(st.floats(-180, 180), st.floats(0.01, 1))
def test_placement_relative_to_a_viewer_is_seen_by_it(turned: float, far: float) -> None:
    """A place to somebody's left is to the left as that one sees it, and as far."""
    found = values(thing("object", "eye", yaw=math.radians(turned), at=(0, 0, 0)), thing("object", "a", at=(1, 2, 0)))
    for name, expected in {
        "left_of": (-far, 0),
        "right_of": (far, 0),
        "behind": (0, far),
        "in_front_of": (0, -far),
    }.items():
        _, x, y = found.call(name, ("a", far), seen_from="eye")
        assert view_coordinates(gaze_direction(found, "eye"), x - 1, y - 2) == pytest.approx(expected, abs=1e-9)


def test_a_property_is_read_as_its_kind_and_as_no_other() -> None:
    known = values(thing("object", "ball", shape="sphere", size=0.1, mass=1, fixed=False, at=(0, 0)))
    right = {"number": "mass", "flag": "fixed", "text": "shape", "reference": "shape", "spot": "at", "pair": "at"}
    for kind, name in right.items():
        assert getattr(known, kind)("ball", name) == known.property("ball", name)
    assert isinstance(known.number("ball", "mass"), float)
    for kind, name in product(("number", "flag", "text", "vector", "points"), ("mass", "fixed", "shape", "at")):
        if right.get(kind) != name:
            with pytest.raises(TypeError, match=f"`ball.{name}` is"):
                getattr(known, kind)("ball", name)
