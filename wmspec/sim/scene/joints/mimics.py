"""Joints that mimic others: where they begin."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, remainder

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import coordinate, relative
from wmspec.sim.scene.model import Joint, Scene

_SAME = 1e-4  # rad or m


def astray(scene: Scene) -> Iterator[Diagnostic]:
    """The joints that do not begin where what they mimic puts them."""
    names = {joint.name: joint for joint in scene.joints}
    for joint in scene.joints:
        if joint.mimic is None:
            continue
        if joint.mimic.leader not in names or names[joint.mimic.leader].kind not in ("hinge", "slider"):
            yield Diagnostic(
                f"it mimics '{joint.mimic.leader}', no hinge or slider of the scene", PrimPlace(joint.path)
            )
        elif (off := abs(ahead(scene, joint, names))) > _SAME:
            reason = f"it starts {off:.3g} from where the joint that it mimics puts it"
            yield Diagnostic(reason, PrimPlace(joint.path), "put the bodies where the joints hold them")


def ahead(scene: Scene, joint: Joint, names: dict[str, Joint]) -> float:
    """By how much (rad, m) a joint that mimics another starts beyond where that puts it."""
    assert joint.mimic is not None
    bodies = {body.name: body for body in scene.bodies}
    own, leader = (
        coordinate(j, relative(bodies, j.first, j.second, j.first_frame, j.second_frame))
        for j in (joint, names[joint.mimic.leader])
    )
    off = own - joint.mimic.ratio * leader - joint.mimic.offset
    return remainder(off, 2 * pi) if joint.kind == "hinge" else off
