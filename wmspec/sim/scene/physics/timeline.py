"""Translates actions into engine-independent events: velocity changes, forces, paths of kinematic bodies."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

from wmspec.sim.scene import model
from wmspec.sim.scene.joints.articulations import jointed_bodies, trees
from wmspec.sim.scene.joints.com_frame import body_frame_in_com, com_frame
from wmspec.sim.scene.model import (
    Force,
    Impulse,
    Launch,
    PassThrough,
    Release,
    Scene,
    Steer,
    Teleport,
    Vanish,
)
from wmspec.sim.scene.model.numbers import floats, pose_numbers
from wmspec.sim.scene.physics.episode import Aim, Drag, Episode, Grip, Hold, Jump, Kick, Passage, Push
from wmspec.sim.scene.physics.paths import first_step, track, vanished_position

_REST = (0.0, 0.0, 0.0)


def episode(scene: Scene, steps_per_second: int) -> Episode:
    """Return the episode of a scene with at least `steps_per_second`, a whole number of steps per sample."""
    substeps = ceil(steps_per_second / scene.rate)
    rate = scene.rate * substeps
    held = holds(scene, rate)
    return Episode(
        rate=scene.rate,
        substeps=substeps,
        samples=round(scene.duration * scene.rate) + 1,
        gravity=floats(scene.gravity),
        start=tuple(pose_numbers(com_frame(body).pose) for body in scene.bodies),
        mounts=tuple(pose_numbers(body_frame_in_com(body)) for body in scene.bodies),
        dynamic=tuple(i for i, body in enumerate(scene.bodies) if body.motion == "dynamic"),
        kicks=kicks(scene, held, rate),
        tracks=tuple(track(scene, i, rate) for i, body in enumerate(scene.bodies) if body.motion == "kinematic"),
        pushes=pushes(scene, held, rate),
        holds=(*held, *vanished_holds(scene, rate)),
        aims=drive_targets(scene, rate),
        drags=drags(scene),
        grips=grips(scene, rate),
        untouchable=tuple(i for i, body in enumerate(scene.bodies) if not any(geom.collides for geom in body.geoms)),
        passages=passages(scene, rate),
        jumps=jumps(scene, rate),
    )


def kicks(scene: Scene, held: Sequence[Hold], rate: int) -> tuple[Kick, ...]:
    """Return initial velocities (zero for bodies released later), then launches, each at the nearest step."""
    later, tied = {hold.body: hold.until for hold in held}, jointed_bodies(scene)
    first = [
        Kick(later[i], i, _REST, _REST)
        if i in later
        else Kick(0, i, floats(body.linear_velocity), floats(body.angular_velocity))
        for i, body in enumerate(scene.bodies)
        if body.motion == "dynamic" and body.name not in tied
    ]
    launches = sorted((action for action in scene.actions if isinstance(action, Launch)), key=lambda a: a.start)
    index = _index(scene)
    return (
        *first,
        *(Kick(round(a.start * rate), index[a.body], floats(a.linear), floats(a.angular)) for a in launches),
    )


def holds(scene: Scene, rate: int) -> tuple[Hold, ...]:
    """Return the holds of bodies that a `release` frees later."""
    ends = {_index(scene)[a.body]: round(a.start * rate) for a in scene.actions if isinstance(a, Release)}
    return tuple(Hold(until, body) for body, until in sorted(ends.items()) if until)


def vanished_holds(scene: Scene, rate: int) -> tuple[Hold, ...]:
    """Return the holds of vanished bodies, far away from everything and from each other."""
    index, last = _index(scene), ceil(scene.duration * rate) + 1
    return tuple(
        Hold(
            last,
            i,
            round(action.start * rate),
            (*floats(vanished_position(i)), *floats(com_frame(scene.bodies[i]).pose.orientation)),
        )
        for action in sorted((a for a in scene.actions if isinstance(a, Vanish)), key=lambda a: a.start)
        if scene.bodies[i := index[action.body]].motion == "dynamic"
    )


def jumps(scene: Scene, rate: int) -> tuple[Jump, ...]:
    """Return the teleports of dynamic bodies in order of time."""
    index = _index(scene)
    return tuple(
        Jump(
            first_step(action.start, rate),
            index[action.body],
            floats(action.position),
            None if action.orientation is None else floats(action.orientation),
        )
        for action in sorted((a for a in scene.actions if isinstance(a, Teleport)), key=lambda a: a.start)
        if scene.bodies[index[action.body]].motion == "dynamic"
    )


def drive_targets(scene: Scene, rate: int) -> tuple[Aim, ...]:
    """Return the targets of drives in order of time."""
    joints = {joint.name: i for i, joint in enumerate(scene.joints)}
    steers = sorted((a for a in scene.actions if isinstance(a, Steer)), key=lambda a: a.start)
    return tuple(Aim(round(a.start * rate), joints[a.joint], float(a.target)) for a in steers)


def pushes(scene: Scene, held: Sequence[Hold], rate: int) -> tuple[Push, ...]:
    """Return impulses and forces, and an upward force of half the weight for jointed bodies in their first step.

    Joint velocities cannot be corrected by a kick; half a step less of gravity has the same effect.
    """
    index, tied = _index(scene), jointed_bodies(scene)
    together = {i: tree for tree in trees(scene) for i in (link.body for link in tree)}
    later = {link.body: hold.until for hold in held for link in together.get(hold.body, ())}
    lifts = [
        Push(later.get(i, 0), later.get(i, 0), i, floats(-body.inertia.mass * scene.gravity / 2))
        for i, body in enumerate(scene.bodies)
        if body.name in tied and body.inertia
    ]
    forces = [action for action in scene.actions if isinstance(action, Impulse | Force)]
    return (*lifts, *(_push(action, index[action.body], rate) for action in forces))


def drags(scene: Scene) -> tuple[Drag, ...]:
    """Return the damping of jointed bodies."""
    tied = jointed_bodies(scene)
    return tuple(
        Drag(i, float(body.inertia.mass * body.linear_damping), floats(body.inertia.moments * body.angular_damping))
        for i, body in enumerate(scene.bodies)
        if body.name in tied and body.inertia and (body.linear_damping or body.angular_damping)
    )


def grips(scene: Scene, rate: int) -> tuple[Grip, ...]:
    """Return grips in the order of the actions."""
    index = _index(scene)
    return tuple(
        Grip(
            round(action.start * rate),
            round(action.stop * rate),
            index[action.hand],
            index[action.body],
            tuple(floats(point) for point in action.points),
        )
        for action in scene.actions
        if isinstance(action, model.Grip)
    )


def passages(scene: Scene, rate: int) -> tuple[Passage, ...]:
    """Return the times during which two bodies do not collide, in the order of the actions."""
    index = _index(scene)
    return tuple(
        Passage(round(a.start * rate), round(a.stop * rate), index[a.body], index[a.through])
        for a in scene.actions
        if isinstance(a, PassThrough)
    )


def _push(action: Impulse | Force, body: int, rate: int) -> Push:
    """Return a force over whole steps with exactly the impulse of the action."""
    first = round(action.start * rate)
    if isinstance(action, Impulse):
        return Push(first, first, body, floats(action.impulse * rate))
    steps = round(action.stop * rate) - first
    return Push(first, first + steps, body, floats(action.force * (action.stop - action.start) * rate / max(steps, 1)))


def _index(scene: Scene) -> dict[str, int]:
    return {body.name: i for i, body in enumerate(scene.bodies)}
