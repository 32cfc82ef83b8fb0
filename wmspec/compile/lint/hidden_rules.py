"""Rules on visibility: entities that a question concerns and that others hide."""

from __future__ import annotations

import math
from collections.abc import Iterator

from wmspec.compile.design.about import referenced_objects
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import all_pieces, pieces
from wmspec.compile.layout.solids import bounds, corners
from wmspec.compile.lint.question_rules import is_posed, required_objects
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import LintScene
from wmspec.compile.lint.visibility import moved_objects
from wmspec.core.diagnostics import Note
from wmspec.core.space import Pose, Vector, add, inverse, rotate, scale
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.sim.shapes.box import Box


@rule("WMS605")
def hidden_object(scene: LintScene) -> Iterator[Breach]:
    """Find relevant or moved objects that one box hides from every camera that looks at the start."""
    values = scene.values
    cameras = _initial_cameras(values)
    if not cameras or any(values.has(camera, "ride") for camera in cameras):
        return
    things = {t.name: t for t in values.spec.things if t.kind == "object" and values.is_present(t.name)}
    walls = [(name, half, pose) for name in things for half, pose in _boxes(values, name)]
    questions = (question for question in values.spec.questions if is_posed(question, values))
    needed = {
        name
        for question in questions
        for name in required_objects(
            question, values, referenced_objects(question, values).union(moved_objects(values)), 0.0
        )
    }
    for name in (name for name in things if name in needed and not things[name].set):
        around = list(corners(bounds(pieces(values, name), values.pose(name))))
        by = [
            _hiding_object(values.vector(camera, "at"), around, [w for w in walls if w[0] != name])
            for camera in cameras
        ]
        if all(by):
            what = f"`{name}` is moved or asked about, and hidden behind `{by[0]}` from `{cameras[0]}` {scene.where}"
            note = Note(f"`{by[0]}` is declared here", values.source_location(by[0] or ""))
            remedy = "move one of them or the camera, or ask only where it is seen: `ensure`"
            yield Breach(what, values.source_location(name, "at"), remedy, (note,), about=name)


RULES = (hidden_object,)


def _initial_cameras(values: Evaluator) -> list[str]:
    """Return the cameras that look at the start."""
    observed = (o for o in values.spec.observations if min(evaluate(o.times, values), default=1.0) < 1e-9)
    return list(dict.fromkeys(observation.camera for observation in observed))


def _boxes(values: Evaluator, name: str) -> Iterator[tuple[Vector, Pose]]:
    """Yield the visible boxes of an object: half edges (m) and pose."""
    pose = values.pose(name)
    for part, piece in all_pieces(values, name):
        drawn = all(values.flag(owner, "drawn") for owner in {name, part} if values.has(owner, "drawn"))
        if isinstance(piece.solid, Box) and drawn:
            yield piece.solid.half, pose.compose(piece.pose)


def _hiding_object(eye: Vector, around: list[Vector], walls: list[tuple[str, Vector, Pose]]) -> str:
    """Return the object with a box in front of all corners, or an empty string.

    The region that a convex body hides from a point is convex, so hiding a box's corners hides its content.
    """
    return next((name for name, half, pose in walls if all(_is_between(eye, c, half, pose) for c in around)), "")


def _is_between(eye: Vector, point: Vector, half: Vector, pose: Pose) -> bool:
    """Whether a box lies between an eye outside it and a point (m). (Kay and Kajiya, Ray Tracing Complex Scenes.)"""
    a, b = (rotate(inverse(pose.orientation), add(p, scale(-1.0, pose.position))) for p in (eye, point))
    enters, leaves = -math.inf, 1.0
    for start, end, edge in zip(a, b, half, strict=True):
        if abs(end - start) < 1e-12:
            if abs(start) > edge:
                return False
            continue
        first, last = sorted(((-edge - start) / (end - start), (edge - start) / (end - start)))
        enters, leaves = max(enters, first), min(leaves, last)
    return 0.0 <= enters < leaves
