"""What makes sense of joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import jointed, moves, trees
from wmspec.sim.scene.joints.mimics import astray
from wmspec.sim.scene.joints.momentum import misfits
from wmspec.sim.scene.model import Body, Drive, Joint, Launch, Release, Scene, Vanish


def problems(scene: Scene) -> Iterator[Diagnostic]:
    """What no engine can do with the scene's joints. Raises WmsError for loops and for frames that don't fit."""
    bodies = {body.name: body for body in scene.bodies}
    for first, second in scene.filtered:
        if first not in bodies or second not in bodies:
            yield Diagnostic(f"the filtered pair {first}, {second} names no two bodies")
    wrong = [(joint, problem) for joint in scene.joints for problem in _joint(joint, bodies, moves(scene))]
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
        yield Diagnostic("it joins nothing that is dynamic", help="deactivate it")
    if any(name in moving for name in ends):
        yield Diagnostic(
            "it joins a kinematic body that moves, which only some engines could",
            help="drive a joint to the world instead",
        )
    frames = [joint.first_frame, joint.second_frame]
    if not all(np.isfinite(f.position).all() and abs(np.linalg.norm(f.orientation) - 1) < 1e-6 for f in frames):
        yield Diagnostic("its frames are not finite, or not turned by unit quaternions")
    if joint.limits is not None and (joint.kind == "fixed" or not joint.limits[0] <= joint.limits[1]):
        yield Diagnostic(f"its limits are {joint.limits}, expected the lower one first, and none of a fixed joint")
    if joint.drive is not None:
        yield from _drive(joint, joint.drive)
    if joint.mimic is not None and joint.kind not in ("hinge", "slider"):
        yield Diagnostic(
            f"a {joint.kind} joint has no one coordinate that could mimic another", help="remove its mimic"
        )


def _drive(joint: Joint, drive: Drive) -> Iterator[Diagnostic]:
    if joint.kind not in ("hinge", "slider"):
        yield Diagnostic(f"a {joint.kind} joint has no one coordinate to drive", help="remove its drive")
    if not (0 <= drive.stiffness < np.inf and 0 <= drive.damping < np.inf and drive.max_force >= 0):
        yield Diagnostic("its drive has a negative or infinite stiffness or damping, or a negative greatest force")
    if not np.isfinite([drive.target, drive.velocity]).all():
        yield Diagnostic("its drive's target is not finite")


def _tied(scene: Scene) -> Iterator[Diagnostic]:
    """What can't be done with bodies that have joints."""
    tied = jointed(scene)
    yield from misfits(scene)
    yield from astray(scene)
    for action in scene.actions:
        if isinstance(action, Launch | Vanish) and action.body in tied:
            remedy = "give it an impulse instead" if isinstance(action, Launch) else "let what has no joints vanish"
            yield Diagnostic(f"'{action.body}' has joints", PrimPlace(f"action {action.name}"), remedy)
    releases = {a.body: a.start for a in scene.actions if isinstance(a, Release)}
    for tree in trees(scene):
        names = [scene.bodies[link.body].name for link in tree]
        held = [name for name in names if name in releases]
        if len(held) > 1:
            yield Diagnostic(
                f"{', '.join(held)} hang together by joints", help="release one of them, which lets go of all"
            )
