"""Plausibility rules on the scene of an instance: sizes, times and cameras."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations, pairwise

from wmspec.compile.layout import assets, geometry
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import bounds
from wmspec.compile.lint.question_rules import required_objects
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import LintScene
from wmspec.compile.lint.visibility import mentioned_words, relevant_boxes, relevant_objects, swept_boxes
from wmspec.core.diagnostics import Note
from wmspec.core.space import IDENTITY, Vector, add, dot, inverse, rotate, scale, unit
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.types import units
from wmspec.sim.scene.physics.gyration import excess_text, is_impossible
from wmspec.sim.shapes import Shape

#: Maximum and minimum plausible mass (kg) of an object.
MAX_MASS, MIN_MASS = 20_000.0, 1e-6
#: Maximum and minimum plausible size (m) of a movable mesh.
MAX_MESH_SIZE, MIN_MESH_SIZE = 50.0, 5e-4
#: Maximum plausible launch speed (m/s).
MAX_LAUNCH_SPEED = 40.0
#: Minimum visible size, as a share of the picture's side: 6 of 256 pixels.
MIN_SIDE_SHARE = 6 / 256
_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@rule("WMS604")
def times_out_of_order(scene: LintScene) -> Iterator[Breach]:
    """Find observation times that do not increase."""
    for observation in scene.values.spec.observations:
        moments = evaluate(observation.times, scene.values)
        if any(b < a - 1e-9 for a, b in pairwise(moments)):
            yield Breach("these times are not in order", observation.place, "write them from first to last")
        elif any(b < a + 1e-9 for a, b in pairwise(moments)):
            yield Breach("a time is here twice", observation.place, "write each once")


@rule("WMS605")
def camera_inside(scene: LintScene) -> Iterator[Breach]:
    """Find cameras within an object."""
    values = scene.values
    for camera in _fixed_cameras(values):
        eye = values.vector(camera, "at")
        for thing in values.spec.things:
            if thing.kind == "object" and values.is_present(thing.name) and _is_within(values, thing.name, eye):
                what = f"`{camera}` is inside `{thing.name}` {scene.where}"
                note = Note(f"`{thing.name}` is declared here", values.source_location(thing.name))
                yield Breach(
                    what, values.source_location(camera, "at"), "move one of them", (note,), about=(camera, thing.name)
                )


@rule("WMS605")
def camera_far_away(scene: LintScene) -> Iterator[Breach]:
    """Find cameras in which all relevant objects are too small to be seen."""
    values = scene.values
    boxes = list(relevant_boxes(values))
    for camera in _fixed_cameras(values):
        if boxes and all(_covered_share(values, camera, box) < MIN_SIDE_SHARE for box in boxes):
            what = f"every object that is moved or asked about is too small to be seen from `{camera}` {scene.where}"
            place = next(o.place for o in values.spec.observations if o.camera == camera)
            yield Breach(what, place, "move the camera nearer, or narrow its `fov:`", about=camera)


@rule("WMS605")
def object_far_away(scene: LintScene) -> Iterator[Breach]:
    """Find relevant objects that are too far from all cameras to be seen."""
    values = scene.values
    cameras = _fixed_cameras(values)
    if len(cameras) < len({o.camera for o in values.spec.observations}):
        return  # a riding camera may come near
    needed = {name for q in values.spec.questions for e in q.ensures for name in mentioned_words(values, e.condition)}
    things = [t for t in values.spec.things if t.kind == "object" and not t.set and values.is_present(t.name)]
    needed = needed.union(relevant_objects(values))
    needed = set().union(*(required_objects(question, values, needed) for question in values.spec.questions))
    for name in (t.name for t in things if t.name in needed):
        boxes = list(swept_boxes(values, name))
        if cameras and all(_covered_share(values, camera, box) < MIN_SIDE_SHARE for camera in cameras for box in boxes):
            what = f"`{name}` is too small to be seen from `{cameras[0]}` {scene.where}"
            yield Breach(what, values.source_location(name, "at"), "check its unit", about=name)


@rule("WMS606")
def too_fast(scene: LintScene) -> Iterator[Breach]:
    """Find implausibly fast launches."""
    values = scene.values
    for action in values.spec.things:
        if (
            action.kind == "action"
            and "speed" in action.properties
            and values.is_present(action.name)
            and not action.of
        ):
            speed = values.number(action.name, "speed")
            if speed > MAX_LAUNCH_SPEED:
                target = values.reference(action.name, "object")
                what = f"`{action.name}` gives `{target}` {units.format_quantity(speed, units.SPEED)}"
                place = values.source_location(action.name, "speed")
                yield Breach(f"{what} {scene.where}", place, "check its unit", about=action.name)


@rule("WMS606")
def out_of_proportion(scene: LintScene) -> Iterator[Breach]:
    """Find implausibly heavy or light objects."""
    values = scene.values
    for thing in values.spec.things:
        if thing.kind == "object" and values.is_present(thing.name) and values.has(thing.name, "mass"):
            mass = values.number(thing.name, "mass")
            if not MIN_MASS <= mass <= MAX_MASS:
                what = f"`{thing.name}` weighs {units.format_quantity(mass, units.MASS)} {scene.where}"
                yield Breach(
                    what,
                    values.source_location(thing.name, "mass"),
                    "check its unit",
                    about=thing.name,
                )


@rule("WMS606")
def inertia_out_of_proportion(scene: LintScene) -> Iterator[Breach]:
    """Find implausibly large moments of inertia; those of files are checked when they are read."""
    values = scene.values
    for name in (t.name for t in values.spec.things if t.kind == "object" and "moments" in t.properties):
        if not values.is_present(name) or values.flag(name, "fixed") or assets.base(values, name):
            continue
        times = geometry.inertia_excess(values, name)
        if is_impossible(times):
            what = f"`{name}`: {excess_text(times)} {scene.where}"
            yield Breach(what, values.source_location(name, "moments"), "check its unit", about=name)


@rule("WMS606")
def mesh_out_of_proportion(scene: LintScene) -> Iterator[Breach]:
    """Find movable meshes of implausible size or mass, whose unit may be another."""
    values = scene.values
    for thing in values.spec.things:
        if thing.kind != "object" or not values.is_present(thing.name) or values.flag(thing.name, "fixed"):
            continue
        meshes = [part for part in (thing.name, *values.parts(thing.name)) if values.has(part, "file")]
        if not meshes or any(values.has(part, "units") for part in meshes):
            continue
        made = geometry.pieces(values, thing.name)
        low, high = bounds(made, IDENTITY)
        size = max(b - a for a, b in zip(low, high, strict=True))
        mass = values.number(thing.name, "density") * sum(piece.solid.volume for piece in made)
        mass = 0.0 if values.has(thing.name, "mass") else mass
        if not MIN_MESH_SIZE <= size <= MAX_MESH_SIZE or mass > MAX_MASS:
            length, weight = (float(f"{x:.3g}") for x in (size, mass))
            what = f"the mesh of `{thing.name}` is {units.format_quantity(length, units.LENGTH)} long"
            what += f" and weighs {units.format_quantity(weight, units.MASS)}" if weight else ""
            remedy = "if its lengths are not metres, set `units`, such as `units: mm`"
            yield Breach(f"{what} {scene.where}", values.source_location(meshes[0], "file"), remedy, about=thing.name)


@rule("WMS607", "error")
def launched_twice(scene: LintScene) -> Iterator[Breach]:
    """Find two simultaneous launches of one object: the later one in the text would win."""
    values = scene.values
    for name in (t.name for t in values.spec.things if t.kind == "object"):
        actions = values.actions_on("launch", name)
        for a, b in combinations(actions, 2):
            if abs(values.number(a.name, "start") - values.number(b.name, "start")) < 1e-9:
                what = f"`{a.name}` and `{b.name}` launch `{name}` at the same time {scene.where}"
                note = Note(f"`{a.name}` is declared here", values.source_location(a.name))
                remedy = "leave one out, or let it begin at another time"
                yield Breach(what, values.source_location(b.name), remedy, (note,), about=(a.name, b.name))


RULES = (
    times_out_of_order,
    camera_inside,
    camera_far_away,
    object_far_away,
    out_of_proportion,
    inertia_out_of_proportion,
    mesh_out_of_proportion,
    too_fast,
    launched_twice,
)


def _fixed_cameras(values: Evaluator) -> list[str]:
    """Return the observed cameras that do not ride on an object."""
    return [c for c in dict.fromkeys(o.camera for o in values.spec.observations) if not values.has(c, "ride")]


def _is_within(values: Evaluator, name: str, eye: Vector) -> bool:
    """Whether a point is within a solid of an object."""
    pose = values.pose(name)
    low, high = bounds(pieces(values, name), pose)
    if not all(low[i] < eye[i] < high[i] for i in range(3)):
        return False
    for piece in pieces(values, name):
        for convex, at in piece.solid.pieces:
            there = pose.compose(piece.pose).compose(at)
            local = rotate(inverse(there.orientation), add(eye, scale(-1.0, there.position)))
            if _is_inside(convex, local):
                return True
    return False


def _is_inside(solid: Shape, point: Vector) -> bool:
    """Whether a point is within a convex shape, tested along its axes, its faces, and away from its centre."""
    x, y, _ = point
    outward = [*_AXES, *(scale(-1.0, a) for a in _AXES), *(normal for normal, _ in solid.flat_faces)]
    outward += [unit(v) for v in (point, (x, y, 0.0)) if math.hypot(*v) > 1e-9]
    return all(dot(d, point) < solid.reach(d) - 1e-9 for d in outward)


def _covered_share(values: Evaluator, camera: str, box: tuple[Vector, Vector]) -> float:
    """Return the maximum share of the picture's height that a box covers."""
    eye, edge = values.vector(camera, "at"), 2 * math.tan(values.number(camera, "fov") / 2)
    return math.dist(*box) / max(1e-9, edge * _distance(box, eye))


def _distance(box: tuple[Vector, Vector], eye: Vector) -> float:
    """Return the distance (m) of a point from a box; 0 within it."""
    low, high = box
    return math.hypot(*(max(low[i] - eye[i], 0.0, eye[i] - high[i]) for i in range(3)))
