"""Whether a camera can see anything of what a task is about."""

from __future__ import annotations

import math
from collections.abc import Iterator

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.motion import CARRYING, after, angle, before, way
from wmspec.compile.layout.solids import Box, bounds, corners
from wmspec.compile.layout.values import Values
from wmspec.core.space import Vector, add, cross, dot, heading, times
from wmspec.lang.check.ir.evaluate import parts
from wmspec.lang.check.ir.ir import Expr, Property, Ref, Said, TaskSpec, Thing, Value


def blind(values: Values) -> tuple[str, ...]:
    """The cameras that look, stand still, and have nothing in view of what is asked about or moved.

    An object counts as in view if the upright box around it, and around where its own actions take it, is not wholly
    outside the square picture. So what is hidden, or comes into view when something else strikes it, is not told apart.
    """
    boxes = list(boxes_of_matter(values))
    cameras = dict.fromkeys(o.camera for o in values.spec.observations)
    still = [camera for camera in cameras if not values.has(camera, "ride")]
    return tuple(c for c in still if boxes and not any(_in_view(values, c, box) for box in boxes))


def boxes_of_matter(values: Values) -> Iterator[Box]:
    """The upright boxes around what is asked about or moved, and around where its own actions take it."""
    for name in subjects(values):
        yield from boxes_of(values, name)


# ---------------------------------------------------------------- what matters


def subjects(values: Values) -> list[str]:
    """The objects that actions move and that answers, options and texts mention, if they are there."""
    objects = {t.name for t in values.spec.things if t.kind == "object" and values.there(t.name)}
    names = dict.fromkeys(moved(values))
    for expr in _asked(values.spec):
        names |= dict.fromkeys(mentioned(values, expr))
    return [name for name in names if name in objects]


def moved(values: Values) -> list[str]:
    """The objects that actions are done to."""
    acting = (t.name for t in values.spec.things if t.kind == "action" and "object" in t.properties)
    return [values.reference(name, "object") for name in acting if values.there(name)]


def _asked(spec: TaskSpec) -> Iterator[Expr]:
    for question in spec.questions:
        yield question.answer
        parts = (*question.text, *(part for text in question.texts for part in text.parts))
        yield from (part.value for part in parts if isinstance(part, Said))
        yield from (question.options,) if question.options else ()


def mentioned(values: Values, expr: Expr) -> Iterator[str]:
    """The words in an expression as they are in an instance, names of objects among them."""
    for part in parts(expr):
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


def boxes_of(values: Values, name: str) -> Iterator[Box]:
    """The upright boxes around an object at the start and wherever its own actions take it."""
    low, high = bounds(pieces(values, name), values.pose(name))
    yield low, high
    here = values.pose(name).position
    for verb in (*CARRYING, "launch", "slide"):
        for action in values.acting(verb, name):
            for there in _reached(values, action):
                gone = add(there, times(-1.0, here))
                yield _around((low, high), (add(low, gone), add(high, gone)))


def _reached(values: Values, action: Thing) -> tuple[Vector, ...]:
    """Where an action takes its object, at most."""
    name, verb = action.name, action.verb
    if verb in CARRYING:
        stand = before(values, action)
        through = way(values, action, stand.pose.position)[0] if verb == "follow" else ()
        return (*through, after(values, action, stand).pose.position)
    slides = verb == "slide"
    far = values.number(name, "distance") if slides else values.number(name, "speed") * values.end
    ahead = heading(angle(values.direction(name)))
    return (add(values.pose(values.reference(name, "object")).position, times(far, ahead)),)


def _around(a: Box, b: Box) -> Box:
    """The box around two."""
    (p, q), (r, s) = a, b
    return (min(p[0], r[0]), min(p[1], r[1]), min(p[2], r[2])), (max(q[0], s[0]), max(q[1], s[1]), max(q[2], s[2]))


# ---------------------------------------------------------------- what is in view


def _in_view(values: Values, camera: str, box: Box) -> bool:
    """Whether no side of the picture has the whole box beyond it."""
    eye = values.vector(camera, "at")
    forward, right, up = _axes(eye, values.vector(camera, "look_at"))
    edge = math.tan(values.number(camera, "fov") / 2)
    sides = [forward] + [add(times(edge, forward), times(sign, side)) for side in (right, up) for sign in (1, -1)]
    seen = [add(corner, times(-1.0, eye)) for corner in corners(box)]
    return all(any(dot(side, corner) > 0 for corner in seen) for side in sides)


def _axes(eye: Vector, target: Vector) -> tuple[Vector, Vector, Vector]:
    """Forward, right and up, the horizon level."""
    ahead = add(target, times(-1.0, eye))
    forward = times(1 / math.hypot(*ahead), ahead)
    aside = cross(forward, (0.0, 0.0, 1.0))
    right = times(1 / math.hypot(*aside), aside) if math.hypot(*aside) > 1e-9 else (1.0, 0.0, 0.0)
    return forward, right, cross(right, forward)
