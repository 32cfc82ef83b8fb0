"""Initial coordinates of mimic joints."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, remainder

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import joint_coordinate, relative_frame
from wmspec.sim.scene.model import Joint, Scene

_SAME = 1e-4  # rad or m


def misplaced_mimics(scene: Scene) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each joint that does not start where its leader puts it."""
    names = {joint.name: joint for joint in scene.joints}
    for joint in scene.joints:
        if joint.mimic is None:
            continue
        if joint.mimic.leader not in names or names[joint.mimic.leader].kind not in ("hinge", "slider"):
            yield Diagnostic(
                f"it mimics '{joint.mimic.leader}', which is not a hinge or slider of the scene", PrimPlace(joint.path)
            )
        elif (off := abs(mimic_error(scene, joint, names))) > _SAME:
            reason = f"it starts {off:.3g} off its mimicked coordinate"
            yield Diagnostic(reason, PrimPlace(joint.path), "move the bodies to satisfy the joints")


def mimic_error(scene: Scene, joint: Joint, names: dict[str, Joint]) -> float:
    """Return the initial error (rad, m) of a mimic joint."""
    assert joint.mimic is not None
    bodies = {body.name: body for body in scene.bodies}
    own, leader = (
        joint_coordinate(j, relative_frame(bodies, j.first, j.second, j.first_frame, j.second_frame))
        for j in (joint, names[joint.mimic.leader])
    )
    off = own - joint.mimic.ratio * leader - joint.mimic.offset
    return remainder(off, 2 * pi) if joint.kind == "hinge" else off
