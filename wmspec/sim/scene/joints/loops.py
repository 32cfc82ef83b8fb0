"""Loops in which no joint can be replaced by coinciding points.

A body of such a loop is split into two halves of half the mass that are tied together. The loop becomes a tree, and
every joint keeps its limits and drive.
"""

from __future__ import annotations

from dataclasses import replace

from wmspec.sim.scene.joints.articulations import can_close_loop, loop_joints, mimic_joint_names
from wmspec.sim.scene.model import Body, Joint, Scene
from wmspec.sim.scene.model.transform import identity


def split_loops(scene: Scene) -> Scene:
    """Return the scene with bodies split so that points can close every loop."""
    for number in loop_joints(scene):
        joint = scene.joints[number]
        if not can_close_loop(joint, mimic_joint_names(scene)):
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
    """Return two body names in scene order."""
    names = [body.name for body in scene.bodies]
    return (one, other) if names.index(one) < names.index(other) else (other, one)


def _halved(body: Body) -> Body:
    if body.inertia is None:
        return body
    inertia = replace(body.inertia, mass=body.inertia.mass / 2, moments=body.inertia.moments / 2)
    return replace(body, inertia=inertia)
