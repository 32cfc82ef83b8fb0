"""Rejects scenes that are physically meaningless; engines accept any number and return nonsense."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wmspec.core.diagnostics import Diagnostic, Report, StageError
from wmspec.core.limits import EPISODE_POSES, EPISODE_SECONDS
from wmspec.core.memoize import cached_on
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.action_rules import problems as action_problems
from wmspec.sim.scene.action_rules import sequence
from wmspec.sim.scene.joints.joints import problems as joint_problems
from wmspec.sim.scene.model import Body, Geom, Scene

_UNIT = 1e-6  # tolerance of a unit quaternion's length


def validate(scene: Scene) -> None:
    """Raise StageError with the prim paths of everything that is not physically meaningful."""
    report = Report(StageError)
    report.include(_whole(scene))
    for body in scene.bodies:
        report.include(cached_on(body, _faults))
    motions = {body.name: body.motion for body in scene.bodies}
    joints = {joint.name: joint for joint in scene.joints}
    for action in scene.actions:
        report.include(d.at(PrimPlace(f"action {action.name}")) for d in action_problems(action, motions, joints))
    report.stop_if_failed()
    report.include([*sequence(scene), *joint_problems(scene)])
    report.stop_if_failed()


def _whole(scene: Scene) -> Iterator[Diagnostic]:
    if not scene.bodies:
        yield Diagnostic(
            "the stage has no body and no geometry", PrimPlace(scene.name), "check that this is the right stage"
        )
    names = Counter(body.name for body in scene.bodies)
    yield from (
        Diagnostic(f"two bodies are named '{name}'", help="give each its own name")
        for name, count in sorted(names.items())
        if count > 1
    )
    if not (np.isfinite(scene.duration) and scene.duration >= 0 and scene.rate > 0):
        yield Diagnostic(
            f"the episode lasts {scene.duration} s at {scene.rate} Hz, expected 0 s or more and a positive rate"
        )
    elif scene.duration > EPISODE_SECONDS.most:
        yield Diagnostic(
            f"the episode lasts {scene.duration:g} s and {EPISODE_SECONDS.sentence}", help=EPISODE_SECONDS.help
        )
    elif scene.duration * scene.rate * len(scene.bodies) > EPISODE_POSES.most:
        yield Diagnostic(f"the episode {EPISODE_POSES.sentence}", help=EPISODE_POSES.help)
    if not np.isfinite(scene.gravity).all():
        yield Diagnostic(f"gravity is {scene.gravity}, expected three finite numbers")


def _faults(body: Body) -> tuple[Diagnostic, ...]:
    return tuple(d.at(PrimPlace(body.path)) for d in _body(body))


def _body(body: Body) -> Iterator[Diagnostic]:
    numbers = [body.pose.position, body.linear_velocity, body.angular_velocity]
    if not all(np.isfinite(v).all() for v in numbers):
        yield Diagnostic("its position or velocity is not finite")
    if not abs(np.linalg.norm(body.pose.orientation) - 1) < _UNIT:
        yield Diagnostic(f"its orientation {body.pose.orientation} is not a unit quaternion")
    if body.motion != "dynamic" and any(np.any(v) for v in numbers[1:]):
        yield Diagnostic(f"it is {body.motion} but has a velocity", help="make it dynamic or move it with an action")
    if any(body.surface_velocity) and (body.motion != "kinematic" or not np.isfinite(body.surface_velocity).all()):
        yield Diagnostic("the velocity of its surface is not finite, or it is not kinematic")
    if min(body.linear_damping, body.angular_damping) < 0:
        yield Diagnostic("its damping is negative")
    if body.motion == "dynamic":
        yield from _inertia(body)
    for geom in body.geoms:
        yield from (replace(d, message=f"{geom.name}: {d.message}") for d in _geom(geom))


def _inertia(body: Body) -> Iterator[Diagnostic]:
    if body.inertia is None:
        yield Diagnostic("it is dynamic but has no mass", help="give it a mass or a density")
        return
    a, b, c = np.sort(body.inertia.moments)
    if not (np.isfinite(body.inertia.mass) and body.inertia.mass > 0):
        yield Diagnostic(f"its mass is {body.inertia.mass} kg, expected a positive number")
    if not (a > 0 and np.isfinite(c) and a + b >= c * (1 - _UNIT)):
        yield (
            Diagnostic(
                f"its moments of inertia {body.inertia.moments} belong to no solid: "
                "expected positive ones, none above the sum of the others"
            )
        )


def _geom(geom: Geom) -> Iterator[Diagnostic]:
    sizes = np.array(geom.shape.sizes)
    if not (np.isfinite(sizes).all() and (sizes > 0).all()):
        yield Diagnostic(f"its size {sizes} is not positive")
    if not abs(np.linalg.norm(geom.pose.orientation) - 1) < _UNIT:
        yield Diagnostic(f"its orientation {geom.pose.orientation} is not a unit quaternion")
    f = geom.friction
    if not (0 <= f.dynamic < np.inf and 0 <= f.static < np.inf):
        yield Diagnostic(f"its friction is {f.static} (static), {f.dynamic} (dynamic), expected numbers from 0 up")
    if not 0 <= f.restitution <= 1:
        yield Diagnostic(f"its restitution is {f.restitution}, expected a number from 0 to 1")
