"""What actions mean, once for all engines: when velocities change, and where kinematic bodies are."""

from __future__ import annotations

from math import ceil

import numpy as np

from wmspec.scene.centred import centred, mount
from wmspec.scene.episode import Episode, Kick, Track, Vector
from wmspec.scene.model import Array, Body, Glide, Launch, Pose, Scene


def episode(scene: Scene, steps_per_second: int) -> Episode:
    """The scene's episode in steps of an engine that makes at least `steps_per_second`, a whole number a sample."""
    substeps = ceil(steps_per_second / scene.rate)
    samples = round(scene.duration * scene.rate) + 1
    return Episode(
        rate=scene.rate,
        substeps=substeps,
        samples=samples,
        gravity=floats(scene.gravity),
        start=tuple(_pose(centred(body).pose) for body in scene.bodies),
        mounts=tuple(_pose(mount(body)) for body in scene.bodies),
        dynamic=tuple(i for i, body in enumerate(scene.bodies) if body.motion == "dynamic"),
        kicks=kicks(scene, scene.rate * substeps),
        tracks=tuple(track(scene, i) for i, body in enumerate(scene.bodies) if body.motion == "kinematic"),
    )


def kicks(scene: Scene, steps_per_second: int) -> tuple[Kick, ...]:
    """Initial velocities, then launches in order of time, each at the step nearest to it."""
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    first = [
        Kick(0, i, floats(body.linear_velocity), floats(body.angular_velocity))
        for i, body in enumerate(scene.bodies)
        if body.motion == "dynamic"
    ]
    launches = sorted((action for action in scene.actions if isinstance(action, Launch)), key=lambda a: a.start)
    later = [
        Kick(round(a.start * steps_per_second), index[a.body], floats(a.linear), floats(a.angular)) for a in launches
    ]
    return tuple(first + later)


def track(scene: Scene, index: int) -> Track:
    """The path of the kinematic body number `index`: the velocities of glides that overlap in time add up."""
    body = scene.bodies[index]
    glides = glides_of(scene, body)
    times = sorted({0.0, *(g.start for g in glides), *(g.stop for g in glides)})
    point, points, velocities = body.pose.position, [], []
    for i, time in enumerate(times):
        velocity = sum((g.velocity for g in glides if g.start <= time < g.stop), np.zeros(3))
        points.append(floats(point))
        velocities.append(floats(velocity))
        if i + 1 < len(times):
            point = point + (times[i + 1] - time) * velocity
    return Track(index, tuple(float(t) for t in times), tuple(points), tuple(velocities))


def glides_of(scene: Scene, body: Body) -> tuple[Glide, ...]:
    """The body's glides, in the scene's order."""
    return tuple(action for action in scene.actions if isinstance(action, Glide) and action.body == body.name)


def floats(values: Array) -> Vector:
    """Plain Python floats, whose text is exact."""
    return tuple(float(v) for v in np.ravel(values))


def _pose(pose: Pose) -> Vector:
    return floats(np.concatenate([pose.position, pose.orientation]))
