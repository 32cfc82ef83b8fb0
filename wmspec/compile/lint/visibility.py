"""Whether a camera can see any relevant object of a task."""

from __future__ import annotations

import math
from collections.abc import Iterator

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.motion import PLACING, carriers, heading_of, placement_after, placement_before, timed_path
from wmspec.compile.layout.solids import Box, bounds, corners
from wmspec.core.space import Vector, add, cross, dot, heading_vector, scale
from wmspec.lang.check.ir.evaluate import subexpressions
from wmspec.lang.check.ir.ir import Entity, Expr, Interpolation, Property, Ref, TaskSpec, Value


def blind_cameras(values: Evaluator) -> tuple[str, ...]:
    """Return the observed, fixed cameras without a relevant or moved object in view.

    An object is in view unless its axis-aligned box, and the boxes where its own actions take it, are wholly outside
    the square picture. Occlusion and motion due to collisions are ignored.
    """
    boxes = list(relevant_boxes(values))
    cameras = dict.fromkeys(o.camera for o in values.spec.observations)
    still = [camera for camera in cameras if not values.has(camera, "ride")]
    return tuple(c for c in still if boxes and not any(is_in_view(values, c, box) for box in boxes))


def relevant_boxes(values: Evaluator) -> Iterator[Box]:
    """Yield the boxes of relevant or moved objects, at the start and where their own actions take them."""
    for name in relevant_objects(values):
        yield from swept_boxes(values, name)


# ---------------------------------------------------------------- what matters


def relevant_objects(values: Evaluator) -> list[str]:
    """Return the present objects that actions move or that answers, options and texts mention."""
    objects = {t.name for t in values.spec.things if t.kind == "object" and values.is_present(t.name)}
    names = dict.fromkeys(moved_objects(values))
    for expr in _question_expressions(values.spec):
        names |= dict.fromkeys(mentioned_words(values, expr))
    return [name for name in names if name in objects]


def moved_objects(values: Evaluator) -> list[str]:
    """Return the objects of actions."""
    acting = (t.name for t in values.spec.things if t.kind == "action" and "object" in t.properties)
    return [values.reference(name, "object") for name in acting if values.is_present(name)]


def _question_expressions(spec: TaskSpec) -> Iterator[Expr]:
    for question in spec.questions:
        yield question.answer
        parts = (*question.text, *(part for text in question.texts for part in text.parts))
        yield from (part.value for part in parts if isinstance(part, Interpolation))
        yield from (question.options,) if question.options else ()


def mentioned_words(values: Evaluator, expr: Expr) -> Iterator[str]:
    """Yield the words of an expression as evaluated in an instance, including names of objects."""
    for part in subexpressions(expr):
        match part:
            case Value(value=str(word)):
                yield word
            case Ref(name=name) if name != "end":
                yield from _words(values.ref(name))
            case Property(owner=Value(value=str(owner)), name=name) if name == "object":
                yield from _words(values.property(owner, name))


def _words(value: object) -> Iterator[str]:
    for item in value if isinstance(value, tuple) else (value,):
        if isinstance(item, str):
            yield item


# ---------------------------------------------------------------- where it is


def swept_boxes(values: Evaluator, name: str) -> Iterator[Box]:
    """Yield the axis-aligned boxes of an object, at the start and where its own actions take it."""
    low, high = bounds(pieces(values, name), values.pose(name))
    if not values.flag(name, "fixed") and name not in carriers(values):
        low = (low[0], low[1], min(low[2], 0.0))  # it may fall to the ground
    yield low, high
    here = values.pose(name).position
    for verb in (*PLACING, "launch", "slide"):
        for action in values.actions_on(verb, name):
            for there in _reached_points(values, action):
                gone = add(there, scale(-1.0, here))
                yield _union((low, high), (add(low, gone), add(high, gone)))


def _reached_points(values: Evaluator, action: Entity) -> tuple[Vector, ...]:
    """Return the extreme positions that an action takes its object to."""
    name, verb = action.name, action.verb
    if verb in PLACING:
        stand = placement_before(values, action)
        through = timed_path(values, action, stand.pose.position)[0] if verb == "follow" else ()
        return (*through, placement_after(values, action, stand).pose.position)
    slides = verb == "slide"
    far = values.number(name, "distance") if slides else values.number(name, "speed") * values.end
    ahead = heading_vector(heading_of(values.direction(name)))
    return (add(values.pose(values.reference(name, "object")).position, scale(far, ahead)),)


def _union(a: Box, b: Box) -> Box:
    """Return the box around two boxes."""
    (p, q), (r, s) = a, b
    return (min(p[0], r[0]), min(p[1], r[1]), min(p[2], r[2])), (max(q[0], s[0]), max(q[1], s[1]), max(q[2], s[2]))


# ---------------------------------------------------------------- what is in view


def is_in_view(values: Evaluator, camera: str, box: Box) -> bool:
    """Whether no side of the picture excludes the whole box."""
    eye = values.vector(camera, "at")
    forward, right, up = _axes(eye, values.vector(camera, "look_at"))
    edge = math.tan(values.number(camera, "fov") / 2)
    sides = [forward] + [add(scale(edge, forward), scale(sign, side)) for side in (right, up) for sign in (1, -1)]
    seen = [add(corner, scale(-1.0, eye)) for corner in corners(box)]
    return all(any(dot(side, corner) > 0 for corner in seen) for side in sides)


def _axes(eye: Vector, target: Vector) -> tuple[Vector, Vector, Vector]:
    """Return forward, right and up of a camera with a level horizon."""
    ahead = add(target, scale(-1.0, eye))
    forward = scale(1 / math.hypot(*ahead), ahead)
    aside = cross(forward, (0.0, 0.0, 1.0))
    right = scale(1 / math.hypot(*aside), aside) if math.hypot(*aside) > 1e-9 else (1.0, 0.0, 0.0)
    return forward, right, cross(right, forward)
