"""Fast impacts on thin bodies: compliant contacts let fast bodies penetrate."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmspec.sim.scene.model import Body, Follow, Glide, Impulse, Launch, Scene
from wmspec.sim.scene.physics.contact import colliders
from wmspec.sim.scene.regime_thresholds import FAST_IMPACT, FAST_SPIN, MAX_ENTERED_FRACTION


def max_speed(scene: Scene) -> tuple[float, str]:
    """Return the highest speed (m/s) that a scene prescribes, and the path of that body; (0, "") without any.

    Falling and driven bodies may become faster.
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
                step_multiplier = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(times)
                yield float(step_multiplier.max()), bodies[action.body].path


def has_gyroscopic_spin(scene: Scene) -> bool:
    """Whether a body with unequal moments of inertia, or with joints, spins fast."""
    jointed = {name for joint in scene.joints for name in (joint.first, joint.second)}
    uneven = {
        body.name: body.name in jointed
        or bool(np.ptp(body.inertia.moments) > _INERTIA_TOLERANCE * body.inertia.moments.max())
        for body in scene.bodies
        if body.inertia is not None
    }
    given = [(body.name, body.angular_velocity) for body in scene.bodies]
    given += [(action.body, action.angular) for action in scene.actions if isinstance(action, Launch)]
    return any(np.linalg.norm(spin) > FAST_SPIN for name, spin in given if uneven.get(name))


_INERTIA_TOLERANCE = 1e-3
"""Relative difference up to which moments of inertia count as equal."""


def min_thickness(scene: Scene) -> float:
    """Return the thickness (m) of the thinnest colliding body along its axes; infinite without any."""
    return min((thickness(body) for body in scene.bodies if colliders(body)), default=float("inf"))


def thickness(body: Body) -> float:
    """Return the thickness (m) of the thinnest geom of a body along its axes."""
    return min(float(np.ptp(geom.shape.bounds(np.eye(3)), axis=0).min()) for geom in colliders(body))


def step_multiplier(scene: Scene, gives: float, most: int) -> int:
    """The least of 1, 2, 4 .. `most` times as many steps with which fast impacts enter thin bodies by no more than
    `ENTERED`. A contact gives way by `gives` (s) times the speed, and by half of that with twice as many steps.
    """
    speed, _ = max_speed(scene)
    finer = 1
    while speed > FAST_IMPACT and finer < most and gives * speed / finer > MAX_ENTERED_FRACTION * min_thickness(scene):
        finer *= 2
    return finer
