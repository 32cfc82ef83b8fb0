"""Where jointed bodies begin: a joint that is drawn apart, or outside its limits, is put where it holds them.

What hangs on a body that is moved goes with it, as the joints' own tools do it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import atan2

import numpy as np

from wmspec.core.diagnostics import Diagnostic, StageError
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import WORLD, Branch, coordinate, relative, spanning
from wmspec.sim.scene.joints.mimics import ahead
from wmspec.sim.scene.model import Body, Joint, Pose, Scene
from wmspec.sim.scene.model.transform import compose, identity, inverse, turned, turning

TOLD = 1e-5
"""m or rad: what is moved by less is not told."""


def settled(scene: Scene) -> tuple[Scene, tuple[Diagnostic, ...]]:
    """The scene with its jointed bodies where their joints hold them, and what was moved for that, as warnings."""
    told: list[Diagnostic] = []
    for tree in spanning(scene):
        for branch in tree:
            if branch.joint >= 0 and (moved := _moved(scene.joints[branch.joint], scene.bodies, branch)):
                scene = _carried(scene, tree, branch, moved, told)
    names = {joint.name: joint for joint in scene.joints}
    for tree in spanning(scene):
        for branch in tree:
            if branch.joint >= 0 and (moved := _matched(scene, scene.joints[branch.joint], names, branch)):
                scene = _carried(scene, tree, branch, moved, told)
    return scene, tuple(told)


_Move = tuple[Pose, float, float]
"""How a body is moved in the world, by how much (m, rad)."""


def _carried(scene: Scene, tree: tuple[Branch, ...], branch: Branch, moved: _Move, told: list[Diagnostic]) -> Scene:
    """The scene in which a body, and what hangs on it, is moved; it is told if that is more than round-off."""
    step, gap, turn = moved
    below = set(_below(tree, branch.body))
    bodies = [
        replace(body, pose=compose(step, body.pose)) if i in below else body for i, body in enumerate(scene.bodies)
    ]
    reason = f"it starts {1e3 * gap:.3g} mm and {turn:.3g} rad from where its joint and its limits let it be"
    place = PrimPlace(scene.joints[branch.joint].path)
    if max(gap, turn) > TOLD:
        told.append(Diagnostic(f"{reason}; {bodies[branch.body].path} is moved there", place, severity="warning"))
    return replace(scene, bodies=tuple(bodies))


def _matched(scene: Scene, joint: Joint, names: dict[str, Joint], branch: Branch) -> _Move | None:
    """The same of what a joint holds that mimics another."""
    if joint.mimic is None or joint.mimic.leader not in names or abs(off := ahead(scene, joint, names)) < 1e-12:
        return None
    named = {body.name: body for body in scene.bodies}
    between = relative(named, joint.first, joint.second, joint.first_frame, joint.second_frame)
    back = -off * np.array([1.0, 0.0, 0.0])
    still = identity()
    step = Pose(back, still.orientation) if joint.kind == "slider" else Pose(np.zeros(3), turning(back))
    return _put(joint, named, branch, between, compose(between, step))


def _moved(joint: Joint, bodies: Sequence[Body], branch: Branch) -> _Move | None:
    """How a body is to be moved so that its joint fits and is within its limits; None if it may stay."""
    named = {body.name: body for body in bodies}
    between = relative(named, joint.first, joint.second, joint.first_frame, joint.second_frame)
    try:
        coordinate(joint, between)
    except StageError:
        wanted = _nearest(joint, between)
    else:
        return None
    return _put(joint, named, branch, between, wanted)


def _put(joint: Joint, named: dict[str, Body], branch: Branch, between: Pose, wanted: Pose) -> _Move:
    """How a body is to be moved so that a joint's second frame is as `wanted` in its first; it is `between` now."""
    body = list(named.values())[branch.body]
    here = body.pose
    if body.name == joint.second:
        first = named[joint.first].pose if joint.first is not None else identity()
        there = compose(compose(compose(first, joint.first_frame), wanted), inverse(joint.second_frame))
    else:
        second = compose(named[joint.second].pose, joint.second_frame)
        there = compose(compose(second, inverse(wanted)), inverse(joint.first_frame))
    off = compose(inverse(between), wanted)
    size = float(np.linalg.norm(off.position)), float(np.linalg.norm(turned(off.orientation)))
    return compose(there, inverse(here)), *size


def _nearest(joint: Joint, between: Pose) -> Pose:
    """The nearest that the joint allows to where its second frame is in its first."""
    low, high = joint.limits if joint.limits and joint.kind != "ball" else (-np.inf, np.inf)
    x, still = np.array([1.0, 0.0, 0.0]), identity()
    match joint.kind:
        case "slider":
            return Pose(x * min(max(between.position[0], low), high), still.orientation)
        case "hinge":
            q = between.orientation
            angle = (2 * atan2(q[1], q[0]) + np.pi) % (2 * np.pi) - np.pi
            options = [angle + 2 * np.pi * k for k in (0, -1, 1)]
            best = min(options, key=lambda a: abs(a - min(max(a, low), high)))
            return Pose(still.position, turning(x * min(max(best, low), high)))
        case "ball":
            return Pose(still.position, between.orientation)
        case _:
            return still


def _below(tree: tuple[Branch, ...], body: int) -> Iterator[int]:
    hanging = {body}
    yield body
    for branch in tree:
        if branch.parent in hanging and branch.parent != WORLD:
            hanging.add(branch.body)
            yield branch.body
