"""Checks of joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import jointed_bodies, moving_kinematic_bodies, trees
from wmspec.sim.scene.joints.mimics import misplaced_mimics
from wmspec.sim.scene.joints.momentum import inconsistent_velocities
from wmspec.sim.scene.model import Body, Drive, Joint, Launch, Release, Scene, Teleport, Vanish


def problems(scene: Scene) -> Iterator[Diagnostic]:
    """Yield errors of joints. Raises WmsError for unsupported loops and for frames that do not fit."""
    bodies = {body.name: body for body in scene.bodies}
    for first, second in scene.filtered:
        if first not in bodies or second not in bodies:
            yield Diagnostic(f"the filtered pair {first}, {second} does not name two bodies")
    wrong = [
        (joint, problem) for joint in scene.joints for problem in _joint(joint, bodies, moving_kinematic_bodies(scene))
    ]
    yield from (problem.at(PrimPlace(joint.path)) for joint, problem in wrong)
    if not wrong:
        yield from _tied(scene)


def _joint(joint: Joint, bodies: Mapping[str, Body], moving: frozenset[str]) -> Iterator[Diagnostic]:
    ends = [name for name in (joint.first, joint.second) if name is not None]
    missing = [name for name in ends if name not in bodies]
    if missing or len(set(ends)) < len(ends):
        yield Diagnostic(f"it joins {joint.first} and {joint.second}, expected two bodies of the scene")
        return
    if not any(bodies[name].motion == "dynamic" for name in ends):
        yield Diagnostic("it joins no dynamic body", help="deactivate it")
    if any(name in moving for name in ends):
        yield Diagnostic(
            "it joins a moving kinematic body, which not every engine supports",
            help="drive a joint to the world instead",
        )
    frames = [joint.first_frame, joint.second_frame]
    if not all(np.isfinite(f.position).all() and abs(np.linalg.norm(f.orientation) - 1) < 1e-6 for f in frames):
        yield Diagnostic("its frames are not finite or have no unit quaternion")
    if joint.limits is not None and (joint.kind == "fixed" or not joint.limits[0] <= joint.limits[1]):
        yield Diagnostic(f"its limits are {joint.limits}, expected lower then upper, and none for a fixed joint")
    if joint.drive is not None:
        yield from _drive(joint, joint.drive)
    if not 0 <= joint.armature < np.inf:
        yield Diagnostic(f"its armature is {joint.armature:g}", help="make it 0 or more")
    elif joint.armature and joint.kind not in ("hinge", "slider"):
        yield Diagnostic(f"a {joint.kind} joint does not have exactly one coordinate with an armature")
    if joint.mimic is not None and joint.kind not in ("hinge", "slider"):
        yield Diagnostic(
            f"a {joint.kind} joint does not have exactly one coordinate, so it cannot mimic", help="remove its mimic"
        )


def _drive(joint: Joint, drive: Drive) -> Iterator[Diagnostic]:
    if joint.kind not in ("hinge", "slider"):
        yield Diagnostic(f"a {joint.kind} joint does not have exactly one coordinate to drive", help="remove its drive")
    if not (0 <= drive.stiffness < np.inf and 0 <= drive.damping < np.inf and drive.max_force >= 0):
        yield Diagnostic("its drive has a negative or infinite stiffness or damping, or a negative maximum force")
    if not np.isfinite([drive.target, drive.velocity]).all():
        yield Diagnostic("its drive's target is not finite")


def _tied(scene: Scene) -> Iterator[Diagnostic]:
    """Yield actions that jointed bodies do not support."""
    tied = jointed_bodies(scene)
    yield from inconsistent_velocities(scene)
    yield from misplaced_mimics(scene)
    for action in scene.actions:
        if isinstance(action, Launch | Vanish | Teleport) and action.body in tied:
            deed = "vanish" if isinstance(action, Vanish) else "be teleported"
            push = isinstance(action, Launch)
            remedy = "give it an impulse instead" if push else f"only bodies without joints can {deed}"
            yield Diagnostic(f"'{action.body}' has joints", PrimPlace(f"action {action.name}"), remedy)
    releases = {a.body: a.start for a in scene.actions if isinstance(a, Release)}
    for tree in trees(scene):
        names = [scene.bodies[link.body].name for link in tree]
        held = [name for name in names if name in releases]
        if len(held) > 1:
            yield Diagnostic(f"{', '.join(held)} are joined", help="release one of them; this releases all")
