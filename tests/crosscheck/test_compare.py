"""Within tolerance means within tolerance: a trace changed by a known amount is judged by that amount."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.language.specs import task_of
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.compare.allow import impacts
from wmspec.runtime.compare.compare import compare
from wmspec.runtime.compare.model import Comparison
from wmspec.runtime.compare.tolerance import Tolerances, tolerances
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Body, Geom, Pose, Scene, Trace
from wmspec.sim.scene.model.transform import identity
from wmspec.sim.scene.render.visible_rotation import visible_angle
from wmspec.sim.shapes import Box, Cylinder, Shape, Sphere
from wmspec.sim.usd import read

HERE = Path(__file__).parent
LIMITS = Tolerances()


def executed(name: str) -> tuple[Scene, Trace]:
    spec = task_of(HERE / name)
    scene = read(compose(document(spec, Design(spec)[0])))
    return scene, backend("pybullet").execute(scene)


@pytest.fixture(scope="module")
def race() -> tuple[Scene, Trace]:
    return executed("race.wms")


@pytest.fixture(scope="module")
def tumble() -> tuple[Scene, Trace]:
    return executed("tumble.wms")


def moved(trace: Trace, body: str, by: float, since: float) -> Trace:
    position = trace.position.copy()
    position[trace.time >= since, trace.bodies.index(body), 1] += by
    return replace(trace, engine="other", position=position)


def judged(scene: Scene, a: Trace, b: Trace) -> Comparison:
    return compare("truth", scene, a, b, LIMITS)


@pytest.mark.parametrize("name", ["race", "tumble"])
def test_a_trace_agrees_with_itself(name: str, request: pytest.FixtureRequest) -> None:
    scene, trace = request.getfixturevalue(name)
    found = judged(scene, trace, replace(trace, engine="other"))
    assert found.within
    assert found.cause is None
    assert all(g.position == g.end == g.angle == 0 for g in found.gaps)


def test_a_shift_is_found_where_when_and_how_large(race: tuple[Scene, Trace]) -> None:
    scene, trace = race
    found = judged(scene, trace, moved(trace, "far", 0.02, since=0.3))
    (gap,) = [g for g in found.gaps if g.began is not None]
    assert (gap.body, gap.position, gap.end) == ("far", pytest.approx(0.02), pytest.approx(0.02))
    assert gap.began == pytest.approx(0.3, abs=1 / scene.rate)
    assert found.cause is not None
    assert (found.cause.body, found.cause.other) == ("far", "floor")


def test_resting_contact_has_no_first_touch_even_if_reported_late(
    race: tuple[Scene, Trace],
) -> None:
    scene, trace = race
    late = tuple(replace(c, start=0.2) if c.start == 0 else c for c in trace.contacts)
    assert late != trace.contacts
    found = judged(scene, trace, replace(trace, engine="other", contacts=late))
    assert found.within
    assert found.events == judged(scene, trace, trace).events


@pytest.mark.parametrize(("by", "within"), [(0.002, True), (0.005, False)])
def test_a_body_that_meets_nothing_may_drift_5_mm_a_second(race: tuple[Scene, Trace], by: float, within: bool) -> None:
    scene, trace = race  # it moves from 0.1 s to 0.6 s: 2.5 mm, and the half millimetre of a body at rest
    assert judged(scene, trace, moved(trace, "far", by, since=0.6)).within is within


def test_before_it_moves_a_body_must_be_at_its_place(race: tuple[Scene, Trace]) -> None:
    scene, trace = race
    assert judged(scene, trace, moved(trace, "far", 0.0004, since=0.0)).within
    assert not judged(scene, trace, moved(trace, "far", 0.0006, since=0.0)).within


def test_after_an_impact_more_is_allowed(tumble: tuple[Scene, Trace]) -> None:
    scene, trace = tumble
    hit = next(c for c in impacts(trace, LIMITS.event) if c.first == "post_a" or c.second == "post_a").start
    assert not judged(scene, trace, moved(trace, "a", 0.01, since=hit - 0.02)).within
    assert judged(scene, trace, moved(trace, "a", 0.01, since=hit + 0.02)).within


@pytest.mark.parametrize(("late", "within"), [(0.008, True), (0.05, False)])
def test_a_first_touch_may_be_10_ms_late(tumble: tuple[Scene, Trace], late: float, within: bool) -> None:
    scene, trace = tumble
    later = tuple(replace(c, start=c.start + late, stop=c.stop + late) if c.start > 0 else c for c in trace.contacts)
    found = judged(scene, trace, replace(trace, engine="other", contacts=later))
    assert found.within is within
    assert all(e.times[0] is not None and e.times[1] == pytest.approx(e.times[0] + late) for e in found.events)


def test_missing_touch_is_reported(tumble: tuple[Scene, Trace]) -> None:
    scene, trace = tumble
    missing = tuple(c for c in trace.contacts if "post_a" not in (c.first, c.second))
    found = judged(scene, trace, replace(trace, engine="other", contacts=missing))
    (event,) = [e for e in found.events if not e.within]
    assert event.times[1] is None
    assert {event.first, event.second} == {"a", "post_a"}
    assert found.cause is not None
    assert (found.cause.body, found.cause.restitution) == ("a", pytest.approx(0.9))


def test_coming_to_rest_in_one_engine_alone_is_reported(race: tuple[Scene, Trace]) -> None:
    scene, trace = race
    stopped = trace.linear_velocity.copy()
    stopped[-1, trace.bodies.index("near")] = 0
    found = judged(scene, trace, replace(trace, engine="other", linear_velocity=stopped))
    assert [r.body for r in found.rests] == ["near"]
    assert not found.within


def body(shape: Shape) -> Body:
    zero = np.zeros(3)
    return Body(
        "b", "/b", "dynamic", identity(), (Geom("g", shape, Pose(zero, identity().orientation)),), None, zero, zero
    )


@given(angle=st.floats(-3.1, 3.1), axis=st.sampled_from([0, 2]))
def test_only_visible_turns_count(angle: float, axis: int) -> None:
    rest = np.array([[1.0, 0, 0, 0]])
    about = np.array([[np.cos(angle / 2), *(np.sin(angle / 2) * np.eye(3)[axis])]])
    assert visible_angle(body(Sphere(0.1)), rest, about) == pytest.approx(0)
    assert visible_angle(body(Box((0.1,) * 3)), rest, about) == pytest.approx(abs(angle))
    assert visible_angle(body(Cylinder(0.1, 0.2)), rest, about) == pytest.approx(
        abs(angle) if axis == 0 else 0, abs=1e-12
    )


def test_tolerances_are_read_with_units() -> None:
    given_ = tolerances(["drift=1cm/s", "impact = 5 %", "event=20 ms", "rest=1mm", "angle=15deg"])
    assert (given_.drift, given_.impact, given_.event, given_.rest) == (0.01, 0.05, 0.02, 0.001)
    assert given_.angle == pytest.approx(np.radians(15))
    assert tolerances([]) == LIMITS


@pytest.mark.parametrize(
    ("setting", "remedy"),
    [
        ("drfit=1cm/s", "did you mean `drift`?"),
        ("drift=1cm", "expected a speed, such as drift=1cm/s"),
        ("event", "expected a time, such as event=20ms"),
        ("rest=-1mm", "expected a length, such as rest=1mm"),
        ("impact=nan", "expected a plain number, such as impact=5%"),
        ("rest=3 parsec", "expected a length"),
    ],
)
def test_wrong_tolerance_is_reported_with_the_right_one(setting: str, remedy: str) -> None:
    with pytest.raises(WmsError) as error:
        tolerances([setting])
    assert remedy in str(error.value)


def test_tolerances_of_a_spec_yield_to_the_command_line() -> None:
    found = tolerances(["event=20ms"], {"event": 0.03, "rest": 0.002})
    assert (found.event, found.rest, found.drift) == (0.02, 0.002, LIMITS.drift)
