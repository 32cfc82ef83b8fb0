"""What is fast for how thin things are: engines whose contacts are springs let fast bodies into thin ones."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmspec.sim.scene.model import Body, Follow, Glide, Impulse, Launch, Scene
from wmspec.sim.scene.physics.contact import colliders
from wmspec.sim.scene.regime_thresholds import ENTERED, FAST, SPINS


def fastest(scene: Scene) -> tuple[float, str]:
    """The greatest speed (m/s) that the scene gives to a body, and that body's path; 0 and nothing without any.

    What falls or is driven by a joint may become faster.
    """
    return max(_speeds(scene), default=(0.0, ""))


def _speeds(scene: Scene) -> Iterator[tuple[float, str]]:
    bodies = {body.name: body for body in scene.bodies}
    yield from ((float(np.linalg.norm(body.linear_velocity)), body.path) for body in scene.bodies)
    for action in scene.actions:
        match action:
            case Launch(linear=speed) | Glide(velocity=speed):
                yield float(np.linalg.norm(speed)), bodies[action.body].path
            case Impulse(impulse=impulse) if (inertia := bodies[action.body].inertia) is not None:
                yield float(np.linalg.norm(impulse)) / inertia.mass, bodies[action.body].path
            case Follow(times=times, points=points):
                steps = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(times)
                yield float(steps.max()), bodies[action.body].path


def gyroscopic(scene: Scene) -> bool:
    """Whether the scene spins something fast whose axis may turn: with unequal moments of inertia, or with joints."""
    jointed = {name for joint in scene.joints for name in (joint.first, joint.second)}
    uneven = {
        body.name: body.name in jointed or bool(np.ptp(body.inertia.moments) > _EVEN * body.inertia.moments.max())
        for body in scene.bodies
        if body.inertia is not None
    }
    given = [(body.name, body.angular_velocity) for body in scene.bodies]
    given += [(action.body, action.angular) for action in scene.actions if isinstance(action, Launch)]
    return any(np.linalg.norm(spin) > SPINS for name, spin in given if uneven.get(name))


_EVEN = 1e-3
"""The part by which moments of inertia may differ of what turns as a ball does."""


def thinnest(scene: Scene) -> float:
    """How thick (m) the thinnest body is that can be touched, along one of its own axes; infinite without any."""
    return min((thickness(body) for body in scene.bodies if colliders(body)), default=float("inf"))


def thickness(body: Body) -> float:
    """How thick (m) the thinnest piece of a body is, along one of its own axes."""
    return min(float(np.ptp(geom.shape.bounds(np.eye(3)), axis=0).min()) for geom in colliders(body))


def steps(scene: Scene, gives: float, most: int) -> int:
    """The least of 1, 2, 4 .. `most` times as many steps with which fast impacts enter thin bodies by no more than
    `ENTERED`. A contact gives way by `gives` (s) times the speed, and by half of that with twice as many steps.
    """
    speed, _ = fastest(scene)
    finer = 1
    while speed > FAST and finer < most and gives * speed / finer > ENTERED * thinnest(scene):
        finer *= 2
    return finer
