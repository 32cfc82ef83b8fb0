"""What no engine can execute, said before one returns nonsense for it: they accept any number without complaint."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmspec.diagnostics import WmsError
from wmspec.scene.action_rules import problems as deed_problems
from wmspec.scene.action_rules import sequence
from wmspec.scene.joints import problems as joint_problems
from wmspec.scene.model import Body, Geom, Scene

_UNIT = 1e-6  # how far a quaternion's length may be from 1


def validate(scene: Scene) -> None:
    """Raise WmsError with the prim path of everything in the scene that is not physically meaningful."""
    problems = [*_whole(scene)]
    for body in scene.bodies:
        problems += [f"{body.path}: {problem}" for problem in _body(body)]
    motions = {body.name: body.motion for body in scene.bodies}
    joints = {joint.name: joint for joint in scene.joints}
    for action in scene.actions:
        problems += [f"action {action.name}: {problem}" for problem in deed_problems(action, motions, joints)]
    if not problems:
        problems += [*sequence(scene), *joint_problems(scene)]
    if problems:
        raise WmsError("\n".join(problems))


def _whole(scene: Scene) -> Iterator[str]:
    if not scene.bodies:
        yield f"{scene.name}: there is no body and no geometry, so nothing can happen; is this the right stage?"
    names = [body.name for body in scene.bodies]
    yield from (f"two bodies are named '{n}'; give each its own name" for n in sorted(set(names)) if names.count(n) > 1)
    if not (np.isfinite(scene.duration) and scene.duration >= 0 and scene.rate > 0):
        yield f"the episode lasts {scene.duration} s at {scene.rate} Hz, expected 0 s or more and a positive rate"
    if not np.isfinite(scene.gravity).all():
        yield f"gravity is {scene.gravity}, expected three finite numbers"


def _body(body: Body) -> Iterator[str]:
    numbers = [body.pose.position, body.linear_velocity, body.angular_velocity]
    if not all(np.isfinite(v).all() for v in numbers):
        yield "its position or velocity is not finite"
    if not abs(np.linalg.norm(body.pose.orientation) - 1) < _UNIT:
        yield f"its orientation {body.pose.orientation} is not a unit quaternion"
    if body.motion != "dynamic" and any(np.any(v) for v in numbers[1:]):
        yield f"it is {body.motion} but has a velocity; make it dynamic, or move it by an action"
    if min(body.linear_damping, body.angular_damping) < 0:
        yield "its damping is negative"
    if body.motion == "dynamic":
        yield from _inertia(body)
    for geom in body.geoms:
        yield from (f"{geom.name}: {problem}" for problem in _geom(geom))


def _inertia(body: Body) -> Iterator[str]:
    if body.inertia is None:
        yield "it is dynamic but has no mass; give it a mass or a density"
        return
    a, b, c = np.sort(body.inertia.moments)
    if not (np.isfinite(body.inertia.mass) and body.inertia.mass > 0):
        yield f"its mass is {body.inertia.mass} kg, expected a positive number"
    if not (a > 0 and np.isfinite(c) and a + b >= c * (1 - _UNIT)):
        yield (
            f"its moments of inertia {body.inertia.moments} belong to no solid: "
            "expected positive ones, none above the sum of the others"
        )


def _geom(geom: Geom) -> Iterator[str]:
    sizes = np.array(geom.shape.sizes)
    if not (np.isfinite(sizes).all() and (sizes > 0).all()):
        yield f"its size {sizes} is not positive"
    if not abs(np.linalg.norm(geom.pose.orientation) - 1) < _UNIT:
        yield f"its orientation {geom.pose.orientation} is not a unit quaternion"
    f = geom.friction
    if not (0 <= f.dynamic < np.inf and 0 <= f.static < np.inf):
        yield f"its friction is {f.static} (static), {f.dynamic} (dynamic), expected numbers from 0 up"
    if f.static != f.dynamic and geom.collides:
        yield (
            f"its static friction {f.static:g} differs from its dynamic friction {f.dynamic:g}, "
            "but the engines have one coefficient; make them equal"
        )
    if not 0 <= f.restitution <= 1:
        yield f"its restitution is {f.restitution}, expected a number from 0 to 1"
