"""Cars keep to their lanes, walkers stop before walls; what they cannot do is refused with its place and a remedy."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.language.specs import SPECS, task_from, task_of
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.robots.ground_path import arc_length_at
from wmspec.compile.robots.obstacles import hull, obstacles
from wmspec.compile.robots.travel import STOP_DISTANCE, WALKER_HEIGHTS, WALKER_RADIUS, Travel, travels
from wmspec.compile.robots.wayfinding import ARRIVAL_DISTANCE
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.ir import TaskSpec

TOWN = """
task t : custom {{
  factor tone in [red, blue]
  object ground {{ shape: box  size: (200 m, 200 m, 1 m)  at: (0, 0, -0.5 m)  fixed: true }}
  object street {{ shape: box  size: ({wide} m, 120 m, 4 mm)  at: (0, 0, 2 mm)  fixed: true  solid: false }}
  object avenue {{ shape: box  size: (120 m, {wide} m, 4 mm)  at: (0, 0, 2 mm)  fixed: true  solid: false }}
  {more}
  robot taxi : car {{
    on: ground at ({at[0]:.9f} m, {at[1]:.9f} m)  yaw: {yaw:.6f} deg  color: tone  roads: [street, avenue]  {says}
  }}
  camera eye {{ ride: taxi  at: (80 cm, 0, 140 cm)  look_at: (9 m, 0, 1 m) }}
  {acts}
  horizon 60 s
  observe eye at [0 s]
}}
"""
ROOM = """
task t : custom {{
  factor tone in [red, blue]
  object floor {{ shape: box  size: (20 m, 20 m, 1 m)  color: tone  at: (0, 0, -0.5 m)  fixed: true }}
  {more}
  robot someone : walker {{ on: floor at ({at[0]:.9f} m, {at[1]:.9f} m)  yaw: {yaw:.6f} deg }}
  camera eyes {{ ride: someone  at: (0, 0, 150 cm)  look_at: (2 m, 0, 140 cm) }}
  {acts}
  horizon 60 s
  observe eyes at [0 s]
}}
"""


def planned(spec: TaskSpec, index: int = 0) -> dict[str, Travel]:
    instance = Design(spec)[index]
    return travels(Evaluator(spec, instance.values, None, instance.key))


def town(
    acts: str, at: tuple[float, float] = (2, -30), yaw: float = 90, wide: float = 8, says: str = "", more: str = ""
) -> TaskSpec:
    return task_from(TOWN.format(acts=acts, at=at, yaw=yaw, wide=wide, says=says, more=more))


def room(acts: str, at: tuple[float, float] = (0, 0), yaw: float = 0, more: str = "") -> TaskSpec:
    return task_from(ROOM.format(acts=acts, at=at, yaw=yaw, more=more))


def yaw_of(travel: Travel, i: int = -1) -> float:
    w, _, _, z = travel.turns[i]
    return 2 * math.atan2(z, w)


# ---------------------------------------------------------------- cars


@settings(max_examples=40, deadline=None)
@given(
    quarter=st.integers(0, 3),
    way=st.sampled_from(["left", "right"]),
    keeps=st.sampled_from(["left", "right"]),
    before=st.floats(16, 50),
    wide=st.sampled_from([7.0, 8.0, 14.0]),
)
def test_a_turn_ends_in_the_lane_behind_the_crossing(
    quarter: int, way: str, keeps: str, before: float, wide: float
) -> None:
    side = 1 if keeps == "left" else -1
    cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarter]
    x, y = -before * cos - side * 1.8 * sin, -before * sin + side * 1.8 * cos
    spec = town(f"action go = taxi.turn({way}) for 8 s", (x, y), 90 * quarter, wide, f"keeps: {keeps}")
    travel = planned(spec)["go"]
    turned = yaw_of(travel) - math.radians(90 * quarter)
    to = 1 if way == "left" else -1
    assert math.remainder(turned - to * math.pi / 2, 2 * math.pi) == pytest.approx(0, abs=1e-6)
    (end_x, end_y, _), (out_x, out_y) = travel.points[-1], (-to * sin, to * cos)
    lanes = max(1, math.floor(wide / 2 / 3.5 + 1e-9))
    lane = 3.5 * ((lanes - 0.5) if to == side else 0.5)
    assert end_x * out_x + end_y * out_y >= wide / 2 + 1.9, "it is through the crossing"
    assert -end_x * out_y + end_y * out_x == pytest.approx(side * lane, abs=1e-6), "in the middle of its lane"


@settings(max_examples=40, deadline=None)
@given(st.floats(0.1, 50), st.floats(0.5, 10), st.floats(0, 3), st.floats(0, 3))
def test_arc_length_never_decreases(length: float, lasts: float, enters: float, leaves: float) -> None:
    pace = length / lasts
    ways = [arc_length_at(length, lasts, enters * pace, leaves * pace, lasts * i / 100) for i in range(101)]
    assert ways[0] == 0
    assert ways[-1] == pytest.approx(length)
    assert all(b >= a - 1e-9 for a, b in pairwise(ways))


def test_speed_continues_between_actions_and_stop_brakes_evenly() -> None:
    spec = town(
        """
        action one = taxi.forward(12 m) for 3 s
        action two = taxi.forward(12 m) for 3 s after one
        action three = taxi.stop() for 2 s after two
        """
    )
    plans = planned(spec)

    def speed(name: str, i: int) -> float:
        travel = plans[name]
        far = math.dist(travel.points[i], travel.points[i - 1])
        return far / (travel.times[i] - travel.times[i - 1])

    assert speed("one", -1) == pytest.approx(4, rel=0.02)
    assert speed("two", 1) == pytest.approx(4, rel=0.02)
    assert math.dist(plans["three"].points[0], plans["three"].points[-1]) == pytest.approx(4)
    assert speed("three", 30) == pytest.approx(2, rel=0.02), "half of its time, half of its speed"
    assert plans["one"].points[-1] == plans["two"].points[0]


def test_a_car_changes_lanes() -> None:
    spec = town("action over = taxi.change_lane(left) for 4 s", (5.4, -40), wide=14)
    travel = planned(spec)["over"]
    assert travel.points[-1][0] == pytest.approx(1.75)
    assert yaw_of(travel) == pytest.approx(math.pi / 2)
    assert max(abs(yaw_of(travel, i) - math.pi / 2) for i in range(len(travel.times))) > 0.1, "it leads with its nose"


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (("action a = taxi.forward(80 m) for 9 s", (2, 0)), "`street` ends 57.9 m ahead of it"),
        (("action a = taxi.turn(left) for 9 s", (2, 10)), "no road that it can turn into goes off to the left"),
        (("action a = taxi.forward(5 m) for 2 s", (-2, -30)), "on the wrong side of `street`"),
        (("action a = taxi.forward(5 m) for 2 s", (2, -30), 45), "it is headed along none of its roads"),
        (("action a = taxi.change_lane(left) for 3 s",), "there is no lane for it on the left in `street`"),
        (("action a = taxi.stop() for 3 s",), "it stands still by then"),
        (("action a = taxi.forward(40 m) for 1 s",), "would have to go at 60 m/s, and cars here do at most 50"),
        (
            (
                "action a = taxi.forward(20 m) for 3 s",
                (2, -30),
                90,
                8,
                "",
                "object van { shape: cube  size: 2 m  color: red  on: ground at (3 m, -15 m)  fixed: true }",
            ),
            "`taxi` would drive into `van`, 12.0 m after `a` begins",
        ),
    ],
)
def test_impossible_drives_are_refused(spec: tuple[Any, ...], message: str) -> None:
    with pytest.raises(WmsError, match=message) as caught:
        planned(town(*spec))
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.place is not None
    assert diagnostic.help


CORNERS = "object mill { shape: cube  size: 4 m  color: red  at: (%s m, %s m, 2 m)  fixed: true }"


@pytest.mark.parametrize(
    ("place", "ends", "yaw"),
    [
        ((20, 40), (2, 40), 90),  # on along the street
        ((40, 20), (40, -1.75), 0),  # right into the avenue
        ((-40, 20), (-40, 1.75), 180),  # left
        ((90, -20), (57.9, -1.75), 0),  # the avenue ends before it is abreast
    ],
)
def test_a_car_finds_its_way(place: tuple[int, int], ends: tuple[float, float], yaw: float) -> None:
    go = planned(town("action go = taxi.go_to(mill) for 20 s", more=CORNERS % place))["go"]
    assert go.points[-1][:2] == pytest.approx(ends, abs=1e-6)
    assert math.remainder(yaw_of(go) - math.radians(yaw), math.tau) == pytest.approx(0, abs=1e-6)


def test_a_car_goes_round_the_block() -> None:
    roads = """object lane { shape: box  size: (8 m, 120 m, 4 mm)  at: (40 m, 0, 2 mm)  fixed: true  solid: false }
      object way { shape: box  size: (120 m, 8 m, 4 mm)  at: (0, 40 m, 2 mm)  fixed: true  solid: false }"""
    spec = town("action go = taxi.go_to(mill) for 40 s", (2, 20), more=roads + CORNERS % (-12, 12))
    with pytest.raises(WmsError, match="no way leads to where `street` is nearest to that without turning round"):
        planned(spec)
    text = TOWN.replace("[street, avenue]", "[street, avenue, lane, way]")
    acts = "action go = taxi.go_to(mill) for 40 s"
    spec = task_from(text.format(acts=acts, at=(2, 20), yaw=90, wide=8, says="", more=roads + CORNERS % (-12, 12)))
    go = planned(spec)["go"]
    assert go.points[-1][:2] == pytest.approx((1.75, 12), abs=1e-6)
    assert yaw_of(go) == pytest.approx(math.pi / 2)
    assert max(x for x, *_ in go.points) == pytest.approx(38.25, abs=0.1), "down the other lane"


# ---------------------------------------------------------------- walkers


WALL = "object wall { shape: box  size: (10 cm, 8 m, 2 m)  color: oak  on: floor at (2 m, %s m)  fixed: true }"
DOOR = WALL % -3.5 + " object rest { shape: box  size: (10 cm, 8 m, 2 m)  on: floor at (2 m, 5.5 m)  fixed: true }"
CHEST = "object chest { shape: cube  size: 60 cm  color: red  on: floor at (%s m, %s m)  fixed: true }"


def test_walker_reaches_an_object_behind_a_wall_and_faces_it() -> None:
    spec = room("action go = someone.go_to(chest) for 10 s", more=DOOR + CHEST % (2.6, -2))
    go = planned(spec)["go"]
    instance = Design(spec)[0]
    standing = obstacles(Evaluator(spec, instance.values, None, instance.key), *WALKER_HEIGHTS)
    assert all(o.distance(point[:2]) >= WALKER_RADIUS for point in go.points for o in standing)
    crossed = next(y for x, y, _ in go.points if x > 2)
    assert 0.5 < crossed < 1.5, "it came through the door"
    x, y, _ = go.points[-1]
    (chest,) = (o for o in standing if o.name == "chest")
    assert chest.distance((x, y)) <= WALKER_RADIUS + STOP_DISTANCE + ARRIVAL_DISTANCE
    assert math.remainder(yaw_of(go) - math.atan2(-2 - y, 2.6 - x), math.tau) == pytest.approx(0, abs=1e-6)
    gone = sum(math.dist(a, b) for a, b in pairwise(go.points))
    assert gone < 1.1 * (math.dist((0, 0), (2, 0.8)) + math.dist((2, 0.8), (x, y)))


def test_walker_without_a_path_is_an_error() -> None:
    shut = "\n".join(
        f"object wall{i} {{ shape: box  size: ({'6 m, 10 cm' if i % 2 else '10 cm, 6 m'}, 2 m)  color: oak  "
        f"on: floor at ({x} m, {y} m)  fixed: true }}"
        for i, (x, y) in enumerate(((2, 0), (0, 2), (-2, 0), (0, -2)))
    )
    with pytest.raises(WmsError, match="no way leads `someone` to within reach of `chest`") as caught:
        planned(room("action go = someone.go_to(chest) for 10 s", more=shut + CHEST % (4, 0)))
    assert caught.value.diagnostics[0].help


@settings(max_examples=15, deadline=None)
@given(
    boxes=st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(0, 180)), max_size=5),
    place=st.tuples(st.floats(2, 4), st.floats(-4, 4)),
)
def test_approach_passes_through_nothing(boxes: list[tuple[float, float, float]], place: tuple[float, float]) -> None:
    more = "\n".join(
        f"object b{i} {{ shape: box  size: (1.2 m, 50 cm, 1 m)  color: oak  at: ({x:.6f} m, {y:.6f} m, 50 cm)  "
        f"yaw: {turned:.6f} deg  fixed: true }}"
        for i, (x, y, turned) in enumerate(boxes)
        if math.hypot(x, y) > 1
    )
    spec = room("action go = someone.go_to(chest) for 10 s", more=more + CHEST % (f"{place[0]:.6f}", f"{place[1]:.6f}"))
    instance = Design(spec)[0]
    standing = obstacles(Evaluator(spec, instance.values, None, instance.key), *WALKER_HEIGHTS)
    try:
        go = planned(spec)["go"]
    except WmsError as error:
        if "no way leads" not in str(error):
            raise
        return
    for x, y, _ in go.points:
        assert min((o.distance((x, y)) for o in standing), default=1.0) >= WALKER_RADIUS - 1e-3


def test_a_walker_stops_before_a_wall_and_comes_through_a_door() -> None:
    wall = "object wall { shape: box  size: (10 cm, 4 m, 2 m)  color: oak  on: floor at (2 m, %s)  fixed: true }"
    (go,) = planned(room("action go = someone.move(3 m) for 3 s", more=wall % "0 m")).values()
    assert go.points[-1][0] == pytest.approx(1.95 - WALKER_RADIUS - STOP_DISTANCE, abs=6e-3)
    (go,) = planned(room("action go = someone.move(3 m) for 3 s", more=wall % "2.3 m")).values()
    assert go.points[-1][0] == pytest.approx(3)
    (go,) = planned(room("action go = someone.back(3 m) for 3 s", yaw=180, more=wall % "0 m")).values()
    assert go.points[-1][0] == pytest.approx(1.95 - WALKER_RADIUS - STOP_DISTANCE, abs=6e-3)


@settings(max_examples=30, deadline=None)
@given(
    boxes=st.lists(st.tuples(st.floats(-4, 4), st.floats(-4, 4), st.floats(0, 180)), min_size=1, max_size=5),
    yaw=st.floats(0, 360),
    angle=st.floats(1, 180),
)
def test_walker_passes_through_nothing(boxes: list[tuple[float, float, float]], yaw: float, angle: float) -> None:
    more = "\n".join(
        f"object b{i} {{ shape: box  size: (1.2 m, 50 cm, 1 m)  color: oak  at: ({x:.6f} m, {y:.6f} m, 50 cm)  "
        f"yaw: {turned:.6f} deg  fixed: true }}"
        for i, (x, y, turned) in enumerate(boxes)
        if math.hypot(x, y) > 1
    )
    acts = f"""
        action one = someone.move(4 m) for 3 s
        action two = someone.turn(left, angle: {angle:.6f} deg) for 2 s after one
        action three = someone.move(5 m) for 3 s after two
    """
    spec = room(acts, yaw=yaw, more=more)
    instance = Design(spec)[0]
    standing = obstacles(Evaluator(spec, instance.values, None, instance.key), *WALKER_HEIGHTS)
    for travel in planned(spec).values():
        for x, y, _ in travel.points:
            assert min((o.distance((x, y)) for o in standing), default=1.0) >= WALKER_RADIUS - 1e-3


def test_a_walker_looks_up_about_its_neck() -> None:
    up = planned(room("action up = someone.look(30 deg) for 1 s"))["up"]
    w, _, y, _ = up.turns[-1]
    assert 2 * math.atan2(y, w) == pytest.approx(-math.pi / 6)
    x, _, z = up.points[-1]
    assert (x, z) == pytest.approx((1.2 * math.sin(math.pi / 6), 1.2 - 1.2 * math.cos(math.pi / 6)))


def test_walker_may_not_start_inside_an_object() -> None:
    more = "object crate { shape: cube  size: 1 m  color: red  on: floor at (60 cm, 0)  fixed: true }"
    with pytest.raises(WmsError, match="`someone` stands less than 25 cm from `crate`"):
        planned(room("action go = someone.move(1 m) for 1 s", more=more))


@pytest.mark.parametrize(
    ("act", "message"),
    [
        ("someone.move(4 m) for 0.5 s", r"go at 12 m/s, and walkers here do at most 8; give it some 0\.8 s"),
        ("someone.turn(left, angle: 180 deg) for 0.1 s", r"turn at 2686 deg/s, and walkers here do at most 720"),
    ],
)
def test_walkers_and_cars_have_a_largest_speed(act: str, message: str) -> None:
    with pytest.raises(WmsError, match=message):
        planned(room(f"action go = {act}"))


def test_one_object_at_a_time() -> None:
    acts = "action one = someone.move(1 m) for 2 s\n  action two = someone.turn(left) for 1 s at 1 s"
    with pytest.raises(WmsError, match="`someone` is still busy when `two` starts"):
        planned(room(acts))


def test_a_hull_goes_around_anticlockwise() -> None:
    assert hull([(1, 1), (0, 0), (2, 0), (0, 2), (2, 2), (1, 0)]) == ((0, 0), (2, 0), (2, 2), (0, 2))


# ---------------------------------------------------------------- the tasks

NAVIGATION = [p for p in SPECS if p.stem in ("drive", "walk") and p.parent.name in ("mechanistic", "transitivity")]


@pytest.mark.parametrize("path", NAVIGATION, ids=lambda p: f"{p.parent.stem}-{p.stem}")
def test_the_tasks_of_navigation_can_be_planned(path: Path) -> None:
    spec = task_of(path)
    design = Design(spec)
    assert spec.plan.kind == "groups"
    assert design.draws >= 100
    for index in range(0, len(design), len(design) // 12):
        assert planned(spec, index)
