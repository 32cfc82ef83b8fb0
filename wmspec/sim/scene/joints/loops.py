"""Loops of joints of which none is only a matter of points that stay together.

There a body is split in two halves, which weigh half each and are held together: what had been a loop is a tree again,
and every joint of it keeps its limits and its drive.
"""

from __future__ import annotations

from dataclasses import replace

from wmspec.sim.scene.joints.articulations import closes, closing, paired
from wmspec.sim.scene.model import Body, Joint, Scene
from wmspec.sim.scene.model.transform import identity


def opened(scene: Scene) -> Scene:
    """The scene in which points can close every loop."""
    for number in closing(scene):
        joint = scene.joints[number]
        if not closes(joint, paired(scene)):
            scene = _split(scene, number)
    return scene


def _split(scene: Scene, number: int) -> Scene:
    joint = scene.joints[number]
    name = f"{joint.name}_half"
    body = next(body for body in scene.bodies if body.name == joint.second)
    halved = _halved(body)
    half = replace(halved, name=name, path=joint.path, geoms=())
    weld = Joint(f"{joint.name}_weld", joint.path, "fixed", body.name, name, identity(), identity())
    joints = [replace(joint, second=name) if i == number else one for i, one in enumerate(scene.joints)]
    bodies = [halved if one.name == body.name else one for one in scene.bodies]
    apart = [] if joint.collides or joint.first is None else [_ordered(scene, joint.first, body.name)]
    filtered = tuple(sorted({*scene.filtered, *apart}))
    return replace(scene, bodies=(*bodies, half), joints=(*joints, weld), filtered=filtered)


def _ordered(scene: Scene, one: str, other: str) -> tuple[str, str]:
    """The names of two bodies in the order of the scene."""
    names = [body.name for body in scene.bodies]
    return (one, other) if names.index(one) < names.index(other) else (other, one)


def _halved(body: Body) -> Body:
    if body.inertia is None:
        return body
    inertia = replace(body.inertia, mass=body.inertia.mass / 2, moments=body.inertia.moments / 2)
    return replace(body, inertia=inertia)
