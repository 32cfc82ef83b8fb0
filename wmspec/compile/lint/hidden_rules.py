"""Rules on what can be seen of a scene: things that are asked about, and that others hide."""

from __future__ import annotations

import math
from collections.abc import Iterator

from wmspec.compile.design.about import named
from wmspec.compile.layout.geometry import every_piece, pieces
from wmspec.compile.layout.solids import bounds, corners
from wmspec.compile.layout.values import Values
from wmspec.compile.lint.question_rules import asked
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import Scene
from wmspec.compile.lint.visibility import moved
from wmspec.core.diagnostics import Note
from wmspec.core.space import Pose, Vector, add, inverse, rotate, times
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.sim.shapes.box import Box


@rule("WMS605")
def hidden_thing(scene: Scene) -> Iterator[Breach]:
    """Something asked about, or moved, that one box hides wholly from every camera that looks when it begins."""
    values = scene.values
    cameras = _looking_first(values)
    if not cameras or any(values.has(camera, "ride") for camera in cameras):
        return
    things = {t.name: t for t in values.spec.things if t.kind == "object" and values.there(t.name)}
    walls = [(name, half, pose) for name in things for half, pose in _boxes(values, name)]
    questions = (question for question in values.spec.questions if asked(question, values))
    needed = {name for question in questions for name in named(question, values).union(moved(values))}
    for name in (name for name in things if name in needed and not things[name].set):
        around = list(corners(bounds(pieces(values, name), values.pose(name))))
        by = [_hiding(values.vector(camera, "at"), around, [w for w in walls if w[0] != name]) for camera in cameras]
        if all(by):
            what = f"`{name}` is moved or asked about, and hidden behind `{by[0]}` from `{cameras[0]}` {scene.where}"
            note = Note(f"`{by[0]}` is declared here", values.place(by[0] or ""))
            remedy = "move one of them or the camera, or ask only where it is seen: `ensure`"
            yield Breach(what, values.place(name, "at"), remedy, (note,), about=name)


RULES = (hidden_thing,)


def _looking_first(values: Values) -> list[str]:
    """The cameras that look at the beginning."""
    observed = (o for o in values.spec.observations if min(evaluate(o.times, values), default=1.0) < 1e-9)
    return list(dict.fromkeys(observation.camera for observation in observed))


def _boxes(values: Values, name: str) -> Iterator[tuple[Vector, Pose]]:
    """The boxes of which an object is made and that are drawn: half their edges (m), and where they are."""
    pose = values.pose(name)
    for part, piece in every_piece(values, name):
        drawn = all(values.flag(owner, "drawn") for owner in {name, part} if values.has(owner, "drawn"))
        if isinstance(piece.solid, Box) and drawn:
            yield piece.solid.half, pose.then(piece.pose)


def _hiding(eye: Vector, around: list[Vector], walls: list[tuple[str, Vector, Pose]]) -> str:
    """The thing a box of which is before all corners; empty if there is none.

    What a convex body hides from a point is convex: if it hides the corners of a box, it hides what is in the box.
    """
    return next((name for name, half, pose in walls if all(_between(eye, c, half, pose) for c in around)), "")


def _between(eye: Vector, point: Vector, half: Vector, pose: Pose) -> bool:
    """Whether a box lies between an eye outside it and a point (m). (Kay and Kajiya, Ray Tracing Complex Scenes.)"""
    a, b = (rotate(inverse(pose.orientation), add(p, times(-1.0, pose.position))) for p in (eye, point))
    enters, leaves = -math.inf, 1.0
    for start, end, edge in zip(a, b, half, strict=True):
        if abs(end - start) < 1e-12:
            if abs(start) > edge:
                return False
            continue
        first, last = sorted(((-edge - start) / (end - start), (edge - start) / (end - start)))
        enters, leaves = max(enters, first), min(leaves, last)
    return 0.0 <= enters < leaves
