"""Every measured function, on paths written down by hand: no engine, so every number is known."""

from __future__ import annotations

import math
from inspect import signature
from pkgutil import resolve_name
from typing import Any

import numpy as np
import pytest

from tests.physics.scenes import body, scene, turn
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Call, Counterfactual, Items, Operation, Option, Value
from wmspec.lang.check.statements.builder import observe, task, thing
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.observed import Observed
from wmspec.sim.scene.model import Body, Contact, Geom, Pose, Trace
from wmspec.sim.shapes import Box, Sphere

RATE = 240
T = np.arange(2 * RATE + 1) / RATE
UPRIGHT = np.tile([1.0, 0.0, 0.0, 0.0], (len(T), 1))
SPEC = task(
    "t", thing("camera", "front", at=(0, -1, 1)), observe("front", [0, 2]), thing("object", "a", shape="sphere")
)


def straight(start: float, stop: float, speed: float, angle: float = 0.0, y: float = 0.0) -> np.ndarray:
    """A path along a heading at constant speed from `start` to `stop` (s)."""
    far = speed * np.clip(T - start, 0, stop - start)
    return np.stack([far * math.cos(angle), y + far * math.sin(angle), np.full(len(T), 0.05)], axis=1)


def measured(
    window: tuple[float, float] = (0.0, 2.0),
    turned: dict[str, np.ndarray] | None = None,
    contacts: tuple[Contact, ...] = (),
    bodies: tuple[Body, ...] | None = None,
    **paths: Any,
) -> Measured:
    """What was observed of spheres of 5 cm radius (or of `bodies`) that take these paths."""
    made = bodies or tuple(body(name, Sphere(0.05), path[0]) for name, path in paths.items())
    position = np.stack([paths[b.name] for b in made], axis=1)
    orientation = np.stack([(turned or {}).get(b.name, UPRIGHT) for b in made], axis=1)
    velocity = np.gradient(position, T, axis=0)
    zero = np.zeros_like(position)
    trace = Trace("hand", tuple(b.name for b in made), T, position, orientation, velocity, zero, contacts)
    looks = [("front", time) for time in window]
    return Measured(Evaluator(SPEC, {}), Observed(scene(*made, duration=2.0), trace, looks), unimagined)


def unimagined(change: Counterfactual) -> Measured:
    """No change is imagined here."""
    raise AssertionError(change.name)


def of(m: Measured, function: str, *arguments: Any) -> Any:
    """A function of names, numbers and lists of names."""

    def expr(value: Any) -> Any:
        return Items(items=tuple(map(expr, value))) if isinstance(value, list) else Value(value=value)

    return evaluate(Call(function=function, arguments=tuple(map(expr, arguments))), m)


def test_every_measured_function_of_the_language_is_measured() -> None:
    for name, row in FUNCTIONS.items():
        if row.measured:
            given = list(signature(resolve_name(row.measured)).parameters.values())
            assert len(given) == 1 + len(row.parameters) + len(row.options), name
            assert [p.name.rstrip("_") for p in given if p.default is not p.empty] == list(row.options), name


def test_when_it_moved() -> None:
    m = measured(a=straight(0.5, 1.25, 0.2), b=straight(0.75, 1.0, 0.2), c=straight(0, 0, 0))
    assert of(m, "onset", "a") == pytest.approx(0.5, abs=1e-9)
    assert of(m, "moving_time", "a") == pytest.approx(0.75, abs=1e-9)
    assert of(m, "moving_time", "c") == 0
    assert (of(m, "moved", "a"), of(m, "moved", "c")) == (True, False)
    assert of(m, "first", ["b", "a", "c"]) == "a"
    assert of(m, "first", ["b", "a"], 0.3) == "neither"
    assert of(m, "first", ["b", "a"], 0.2) == "a"
    assert of(m, "longest", ["b", "a"]) == "a"
    assert of(m, "mover", ["c", "b", "a"]) == "a"
    with pytest.raises(WmsError, match="`c` does not move"):
        of(m, "onset", "c")
    with pytest.raises(WmsError, match="none of c moves"):
        of(m, "mover", ["c"])


def test_creep_and_jitter_are_no_motion() -> None:
    random = np.random.default_rng(1)
    creep = straight(0, 2, 0.0009) + random.normal(0, 2e-5, (len(T), 3))
    late = creep + straight(1.0, 2.0, 0.3)
    m = measured(still=creep, late=late)
    assert not of(m, "moved", "still")
    assert of(m, "onset", "late") == pytest.approx(1.0, abs=2 / RATE)


def test_only_observed_moments_count() -> None:
    m = measured(window=(1.0, 2.0), a=straight(0.0, 0.9, 0.5), b=straight(0.0, 1.5, 0.2))
    assert not of(m, "moved", "a")
    assert of(m, "speed", "b") == pytest.approx(0.1, rel=1e-6)
    assert of(m, "onset", "b") == pytest.approx(1.0)


def test_fastest_and_slowest() -> None:
    m = measured(a=straight(0, 2, 0.2), b=straight(0, 2, 0.21), c=straight(0, 2, 0.5), still=straight(0, 0, 0))
    assert of(m, "fastest", ["a", "b", "c"]) == "c"
    assert of(m, "fastest", ["a", "b"], 1.1) == "neither"
    assert of(m, "fastest", ["a", "c"], 1.1) == "c"
    assert of(m, "slowest", ["a", "b"], 1.1) == "neither"
    assert of(m, "slowest", ["still", "b"], 1.1) == "still"
    assert m.readings["speed(c)"] == pytest.approx(0.5)


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5, -2.0])
def test_where_it_goes(angle: float) -> None:
    around = [np.array([math.cos(a), math.sin(a), 0]) for a in (-2.1, 0.1, 1.2, 2.4)]
    others = {f"o{i}": straight(0, 0, 0) + place for i, place in enumerate(around)}
    m = measured(a=straight(0, 2, 0.3, angle), **others)
    assert of(m, "heading", "a") == pytest.approx(angle)
    assert of(m, "heads_to", "a", list(others)) == {0.0: "o1", 1.0: "o2", 2.5: "o3", -2.0: "o0"}[angle]
    assert of(m, "trajectory", "a") == "straight"
    assert of(m, "displacement", "a") == pytest.approx(0.6)
    assert of(m, "distance", "a", "o0") > 0


def test_remaining_bodies_are_at_rest() -> None:
    m = measured(a=straight(0.0, 1.5, 0.3), b=straight(0.0, 1.95, 0.3), contacts=(Contact("b", "a", 0.1, 0.2),))
    assert (of(m, "at_rest", "a"), of(m, "at_rest", "b")) == (True, False)
    assert of(m, "contact", "a", "b") is True
    assert of(m, "height", "a") == pytest.approx(0.05)


@pytest.mark.parametrize("angle", [0.0, 0.5, 0.7, 0.9, 3.0])
def test_tipped_more_than_half_way(angle: float) -> None:
    first, last = turn((0, 1, 0), 0.3), turn((0, 1, 0), 0.3 + angle)
    turned = np.where(T[:, None] < 1, first, last)
    assert of(measured(turned={"a": turned}, a=straight(0, 0, 0)), "toppled", "a") == (angle > math.pi / 4)


@pytest.mark.parametrize(
    ("way", "word"),
    [
        ((0.3, 0.1, 0), "right_of"),
        ((-0.3, 0.1, 0), "left_of"),
        ((0.1, 0.3, 0), "behind"),
        ((0.1, -0.3, 0), "in_front_of"),
        ((0.02, 0.03, 0.1), "above"),
        ((0.02, 0.03, -0.1), "below"),
        ((0.06, 0.02, 0.01), "right_of"),
    ],
)
def test_where_one_is_from_the_other(way: tuple[float, ...], word: str) -> None:
    m = measured(a=straight(0, 0, 0) + np.array(way), b=straight(0, 0, 0))
    assert of(m, "relation", "a", "b") == word


def test_diagonal_position_has_no_relation() -> None:
    m = measured(a=straight(0, 0, 0) + np.array([0.3, 0.28, 0]), b=straight(0, 0, 0))
    with pytest.raises(WmsError, match="diagonal"):
        of(m, "relation", "a", "b")


def rack() -> Body:
    """A box without top, its frame on the ground in its middle."""
    base = body("rack", Sphere(1.0))
    sizes = [((0.2, 0.2, 0.01), (0, 0, 0.01)), ((0.01, 0.2, 0.1), (-0.19, 0, 0.1)), ((0.01, 0.2, 0.1), (0.19, 0, 0.1))]
    geoms = tuple(Geom(f"g{i}", Box(half), Pose(np.array(at, float), UPRIGHT[0])) for i, (half, at) in enumerate(sizes))
    return Body("rack", "/World/rack", "dynamic", base.pose, geoms, base.inertia, np.zeros(3), np.zeros(3))


def test_a_compound_is_measured_at_its_middle() -> None:
    tipped = np.where(T[:, None] < 1, UPRIGHT, turn((0, 1, 0), math.pi / 2))
    still = np.zeros((len(T), 3))
    ball = body("ball", Sphere(0.03), (0.05, 0, 0.05))
    m = measured(bodies=(rack(), ball), rack=still, ball=straight(0, 0, 0))
    assert of(m, "height", "rack") == pytest.approx(0.1)
    assert of(m, "contains", "rack", "ball") is True
    assert (
        of(measured(bodies=(rack(), ball), rack=still, ball=straight(0, 1, 0.3)), "contains", "rack", "ball") is False
    )
    over = measured(bodies=(rack(),), turned={"rack": tipped}, rack=still)
    assert of(over, "displacement", "rack") == pytest.approx(math.hypot(0.1, 0.1))


def test_absent_objects_cannot_be_measured() -> None:
    with pytest.raises(WmsError, match="`ghost` is absent"):
        of(measured(a=straight(0, 0, 0)), "speed", "ghost")
    with pytest.raises(WmsError, match="need pictures, which are not drawn"):
        of(measured(a=straight(0, 0, 0), floor=straight(0, 0, 0)), "visible", "a", "front")
    with pytest.raises(WmsError, match="`top`"):
        of(measured(a=straight(0, 0, 0)), "visible", "a", "top")


def at_times(m: Measured, function: str, *names: str, **options: float | str) -> object:
    """A function of names, with options."""
    given = tuple(Option(name=n.rstrip("_"), value=Value(value=v)) for n, v in options.items())
    return evaluate(Call(function=function, arguments=tuple(Value(value=n) for n in names), options=given), m)


def thrown(speed: float = 4.0, g: float = 10.0) -> np.ndarray:
    """Straight up, with a path that is a parabola."""
    return np.stack([np.zeros(len(T)), np.zeros(len(T)), 0.05 + speed * T - g * T**2 / 2], axis=1)


def test_at_a_time() -> None:
    m = measured(a=straight(0.5, 1.5, 0.4), b=straight(0, 0, 0, y=0.3), up=thrown())
    assert at_times(m, "position", "a", at=1.0) == pytest.approx((0.2, 0, 0.05))
    assert at_times(m, "displacement", "a", at=1.0) == pytest.approx(0.2)
    assert at_times(m, "distance", "a", "b", at=0.5) == pytest.approx(0.3)
    assert at_times(m, "height", "up", at=0.3) == pytest.approx(0.05 + 1.2 - 0.45)
    assert at_times(m, "speed", "up", at=0.0) == pytest.approx(4)
    assert at_times(m, "speed", "up", at=0.2) == pytest.approx(2)
    assert at_times(m, "speed", "a", from_=0.25, to=0.75) == pytest.approx(0.2)
    assert [at_times(m, "moved", "a", to=0.5), at_times(m, "moved", "a", from_=1.5)] == [False, False]
    assert at_times(m, "moved", "a", from_=1.0, to=1.1) is True
    assert [at_times(m, "at_rest", "a", at=t) for t in (0.25, 1.0, 1.55, 1.75)] == [True, False, False, True]
    assert m.readings["speed(a, from: 0.25 s, to: 0.75 s)"] == pytest.approx(0.2)
    assert m.readings["position(a, at: 1 s).x"] == pytest.approx(0.2)


def test_a_heading_at_a_time_is_that_of_the_motion() -> None:
    corner = straight(0, 1, 0.3) + np.where(T[:, None] > 1, (T[:, None] - 1) * [0, 0.3, 0], 0)
    m = measured(a=corner, up=thrown())
    assert at_times(m, "heading", "a", at=0.5) == pytest.approx(0, abs=1e-9)
    assert at_times(m, "heading", "a", at=1.5) == pytest.approx(math.pi / 2)
    with pytest.raises(WmsError, match="no heading then"):
        at_times(m, "heading", "up", at=0.5)


def test_the_highest_point() -> None:
    m = measured(a=straight(0, 1, 0.3), up=thrown())
    assert of(m, "highest", "up") == pytest.approx(0.85, abs=1e-4)
    assert of(m, "when_highest", "up") == pytest.approx(0.4, abs=1 / RATE)
    assert at_times(m, "when_highest", "up", from_=0.5) == pytest.approx(0.5)
    assert at_times(m, "highest", "up", to=0.2) == pytest.approx(0.05 + 0.8 - 0.2)
    with pytest.raises(WmsError, match="stays at its height"):
        of(m, "when_highest", "a")


def test_touches_and_their_order() -> None:
    still: dict[str, Any] = {name: straight(0, 0, 0) for name in "abcd"}
    met = (Contact("a", "b", 0.5, 0.6), Contact("c", "a", 0.9, 1.2), Contact("a", "b", 1.5, 1.5))
    m = measured(contacts=met, **still)
    assert of(m, "contact_time", "a", "b") == 0.5
    assert at_times(m, "contact_time", "b", "a", from_=1.0) == 1.5
    assert at_times(m, "contact_time", "a", "c", from_=1.0) == 1.0  # they have touched since before
    assert [at_times(m, "contact", "a", "c", to=t) for t in (0.75, 1.0)] == [False, True]
    assert [at_times(m, "contact", "a", "c", from_=t) for t in (1.0, 1.25)] == [True, False]
    assert of(m, "touches_first", "a", ["c", "b", "d"]) == "b"
    assert of(m, "touches_first", "a", ["c", "b"], 0.5) == "neither"
    assert of(m, "touches_first", "d", ["a", "b"], 0.5) == "neither"
    with pytest.raises(WmsError, match="do not touch"):
        of(m, "contact_time", "a", "d")
    with pytest.raises(WmsError, match="touches none of a, b"):
        of(m, "touches_first", "d", ["a", "b"])


def test_simultaneous_touches_have_no_first() -> None:
    still: dict[str, Any] = {name: straight(0, 0, 0) for name in "abc"}
    m = measured(contacts=(Contact("a", "b", 0, 2), Contact("a", "c", 0, 1)), **still)
    with pytest.raises(WmsError, match="at once"):
        of(m, "touches_first", "a", ["b", "c"])


@pytest.mark.parametrize("function", ["height", "speed", "toppled", "at_rest", "heading", "displacement"])
def test_a_time_outside_the_episode_has_no_value(function: str) -> None:
    for time in (-0.1, 2.1):
        with pytest.raises(WmsError, match="outside the episode"):
            at_times(measured(a=straight(0, 2, 0.1)), function, "a", at=time)
    with pytest.raises(WmsError, match="ends before it starts"):
        at_times(measured(a=straight(0, 2, 0.1)), "speed", "a", from_=1.0, to=1.0)


@pytest.mark.parametrize(
    ("turned", "word"), [(0, "behind"), (90, "right_of"), (180, "in_front_of"), (-90, "left_of"), (30, "behind")]
)
def test_a_relation_is_seen_as_the_viewer_is_turned(turned: float, word: str) -> None:
    """An object looks along its own x; `b` is to the right of `a`, +x, so ahead of who is not turned."""
    facing = np.tile(turn((0, 0, 1), math.radians(turned)), (len(T), 1))
    still = {"a": straight(0, 0, 0), "b": straight(0, 0, 0) + np.array([0.3, 0, 0]), "eye": straight(0, 0, 0, y=-1)}
    m = measured(turned={"eye": facing}, **still)
    assert at_times(m, "relation", "b", "a", seen_from="eye") == word
    assert of(m, "relation", "b", "a") == "right_of"


def test_viewer_looking_up_has_no_left() -> None:
    up = np.tile(turn((0, 1, 0), -math.pi / 2), (len(T), 1))
    m = measured(turned={"eye": up}, a=straight(0, 0, 0), b=straight(0, 0, 0), eye=straight(0, 0, 0))
    with pytest.raises(WmsError, match="straight up or down"):
        at_times(m, "relation", "b", "a", seen_from="eye")


def test_of_each_of_a_list() -> None:
    m = measured(a=straight(0, 1, 0.3), b=straight(0, 0, 0), c=straight(0, 1, 0.1))
    names = Items(items=tuple(Value(value=n) for n in "abc"))
    far = Call(function="displacement", arguments=(names,), each=0)
    assert evaluate(far, m) == pytest.approx((0.3, 0, 0.1))
    assert evaluate(Call(function="sum", arguments=(far,)), m) == pytest.approx(0.4)
    moved = Call(function="moved", arguments=(names,), each=0)
    assert [evaluate(Call(function=f, arguments=(moved,)), m) for f in ("count", "any", "all")] == [2, True, False]
    beyond = Operation(operator=">", operands=(far, Value(value=0.2)), each=0)
    assert evaluate(beyond, m) == (True, False, False)
