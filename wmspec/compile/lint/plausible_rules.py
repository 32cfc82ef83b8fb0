"""Rules on the scene of an instance: what can hardly be meant, in size, in time, and of cameras."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations, pairwise

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import bounds
from wmspec.compile.layout.values import Values
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import Scene
from wmspec.compile.lint.visibility import boxes_of, boxes_of_matter, mentioned, subjects
from wmspec.core.diagnostics import Note
from wmspec.core.space import Vector, add, dot, inverse, rotate, times, unit
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.types import units
from wmspec.sim.shapes import Shape

#: Heavier (kg) than anything on a table, in a room or on a road that a question is about; and lighter.
HEAVY, LIGHT = 20_000.0, 1e-6
#: What sets off faster (m/s) is taken for a mistake: nobody throws like that.
FAST = 40.0
#: The share of the side of a picture below which nothing can be seen in it: 6 of 256 pixels.
LEAST_SIDE = 6 / 256
_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@rule("WMS604")
def times_out_of_order(scene: Scene) -> Iterator[Breach]:
    """Times of observation that do not rise: the pictures would not be in the order of the text, or be the same."""
    for observation in scene.values.spec.observations:
        moments = evaluate(observation.times, scene.values)
        if any(b < a - 1e-9 for a, b in pairwise(moments)):
            yield Breach("these times are not in order", observation.place, "write them from first to last")
        elif any(b < a + 1e-9 for a, b in pairwise(moments)):
            yield Breach("a time is here twice", observation.place, "write each once")


@rule("WMS605")
def camera_inside(scene: Scene) -> Iterator[Breach]:
    """A camera within an object."""
    values = scene.values
    for camera in _standing(values):
        eye = values.vector(camera, "at")
        for thing in values.spec.things:
            if thing.kind == "object" and values.there(thing.name) and _within(values, thing.name, eye):
                what = f"`{camera}` is inside `{thing.name}` {scene.where}"
                note = Note(f"`{thing.name}` is declared here", values.place(thing.name))
                yield Breach(what, values.place(camera, "at"), "move one of them", (note,), about=(camera, thing.name))


@rule("WMS605")
def camera_far_away(scene: Scene) -> Iterator[Breach]:
    """A camera from which all that matters is too small to be seen."""
    values = scene.values
    boxes = list(boxes_of_matter(values))
    for camera in _standing(values):
        if boxes and all(_share(values, camera, box) < LEAST_SIDE for box in boxes):
            what = f"all that is moved or asked about is too small to be seen from `{camera}` {scene.where}"
            place = next(o.place for o in values.spec.observations if o.camera == camera)
            yield Breach(what, place, "move the camera nearer, or narrow its `fov:`", about=camera)


@rule("WMS605")
def thing_far_away(scene: Scene) -> Iterator[Breach]:
    """Something that is asked about, or needed for it, so far from all cameras that none shows it."""
    values = scene.values
    cameras = _standing(values)
    if len(cameras) < len({o.camera for o in values.spec.observations}):
        return  # one that rides may come near
    needed = {name for q in values.spec.questions for e in q.ensures for name in mentioned(values, e.condition)}
    things = [t for t in values.spec.things if t.kind == "object" and not t.set and values.there(t.name)]
    for name in (t.name for t in things if t.name in needed.union(subjects(values))):
        boxes = list(boxes_of(values, name))
        if cameras and all(_share(values, camera, box) < LEAST_SIDE for camera in cameras for box in boxes):
            what = f"`{name}` is too small to be seen from `{cameras[0]}` {scene.where}"
            yield Breach(what, values.place(name, "at"), "is this the unit that is meant?", about=name)


@rule("WMS606")
def too_fast(scene: Scene) -> Iterator[Breach]:
    """Something that is sent off faster than anybody throws."""
    values = scene.values
    for action in values.spec.things:
        if action.kind == "action" and "speed" in action.properties and values.there(action.name) and not action.of:
            speed = values.number(action.name, "speed")
            if speed > FAST:
                target = values.reference(action.name, "object")
                what = f"`{action.name}` gives `{target}` {units.told(speed, units.SPEED)}"
                place = values.place(action.name, "speed")
                yield Breach(f"{what} {scene.where}", place, "is this the unit that is meant?", about=action.name)


@rule("WMS606")
def out_of_proportion(scene: Scene) -> Iterator[Breach]:
    """An object that weighs more than a truck, or less than a grain of sand."""
    values = scene.values
    for thing in values.spec.things:
        if thing.kind == "object" and values.there(thing.name) and values.has(thing.name, "mass"):
            mass = values.number(thing.name, "mass")
            if not LIGHT <= mass <= HEAVY:
                what = f"`{thing.name}` weighs {units.told(mass, units.MASS)} {scene.where}"
                yield Breach(
                    what, values.place(thing.name, "mass"), "is this the unit that is meant?", about=thing.name
                )


@rule("WMS607", "error")
def launched_twice(scene: Scene) -> Iterator[Breach]:
    """Two actions that set one object's motion at one instant: the later one in the text would win."""
    values = scene.values
    for name in (t.name for t in values.spec.things if t.kind == "object"):
        actions = values.acting("launch", name)
        for a, b in combinations(actions, 2):
            if abs(values.number(a.name, "start") - values.number(b.name, "start")) < 1e-9:
                what = f"`{a.name}` and `{b.name}` launch `{name}` at the same time {scene.where}"
                note = Note(f"`{a.name}` is declared here", values.place(a.name))
                remedy = "leave one out, or let it begin at another time"
                yield Breach(what, values.place(b.name), remedy, (note,), about=(a.name, b.name))


RULES = (
    times_out_of_order,
    camera_inside,
    camera_far_away,
    thing_far_away,
    out_of_proportion,
    too_fast,
    launched_twice,
)


def _standing(values: Values) -> list[str]:
    """The cameras that are observed and do not ride."""
    return [c for c in dict.fromkeys(o.camera for o in values.spec.observations) if not values.has(c, "ride")]


def _within(values: Values, name: str, eye: Vector) -> bool:
    """Whether a point is within the solid of an object."""
    pose = values.pose(name)
    low, high = bounds(pieces(values, name), pose)
    if not all(low[i] < eye[i] < high[i] for i in range(3)):
        return False
    for piece in pieces(values, name):
        for convex, at in piece.solid.pieces():
            there = pose.then(piece.pose).then(at)
            local = rotate(inverse(there.orientation), add(eye, times(-1.0, there.position)))
            if _inside(convex, local):
                return True
    return False


def _inside(solid: Shape, point: Vector) -> bool:
    """Whether a point is within a convex shape: along its axes, its faces, and away from its middle."""
    x, y, _ = point
    outward = [*_AXES, *(times(-1.0, a) for a in _AXES), *(normal for normal, _ in solid.flats)]
    outward += [unit(v) for v in (point, (x, y, 0.0)) if math.hypot(*v) > 1e-9]
    return all(dot(d, point) < solid.reach(d) - 1e-9 for d in outward)


def _share(values: Values, camera: str, box: tuple[Vector, Vector]) -> float:
    """How much of the height of a picture a box takes at most."""
    eye, edge = values.vector(camera, "at"), 2 * math.tan(values.number(camera, "fov") / 2)
    return _across(box) / max(1e-9, edge * _away(box, eye))


def _across(box: tuple[Vector, Vector]) -> float:
    """The diagonal (m) of a box."""
    return math.dist(*box)


def _away(box: tuple[Vector, Vector], eye: Vector) -> float:
    """How far (m) a point is from a box; nothing within it."""
    low, high = box
    return math.hypot(*(max(low[i] - eye[i], 0.0, eye[i] - high[i]) for i in range(3)))
