"""Scenes for the physics tests, made from the contract's dataclasses alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wmspec.sim.scene.model import Action, Array, Body, Friction, Geom, Joint, Light, Pose, Scene
from wmspec.sim.scene.model.transform import identity
from wmspec.sim.scene.physics.inertia import inertia
from wmspec.sim.shapes import Box, Shape

Vector = Sequence[float] | Array

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
G = 9.81


def turn(axis: Vector, angle: float) -> Array:
    """The quaternion of a turn by `angle` (rad) about the unit vector `axis`."""
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * np.asarray(axis, float))])


def body(
    name: str,
    shape: Shape,
    position: Vector = (0, 0, 0),
    *,
    orientation: Vector = UPRIGHT,
    mass: float = 1.0,
    motion: str = "dynamic",
    friction: float = 0.5,
    restitution: float = 0.0,
    velocity: Vector = (0, 0, 0),
    spin: Vector = (0, 0, 0),
    belt: tuple[float, float, float] = (0, 0, 0),
    **damping: float,
) -> Body:
    """A body of one shape."""
    geom = Geom("shape", shape, identity(), friction=Friction(friction, friction, restitution))
    return Body(
        name=name,
        path=f"/World/{name}",
        motion=motion,  # type: ignore[arg-type]
        pose=Pose(np.array(position, float), np.array(orientation, float)),
        geoms=(geom,),
        inertia=inertia([(shape, identity(), mass)]) if motion == "dynamic" else None,
        linear_velocity=np.array(velocity, float),
        angular_velocity=np.array(spin, float),
        surface_velocity=belt,
        **damping,
    )


def floor(friction: float = 0.5, restitution: float = 0.0, orientation: Array = UPRIGHT) -> Body:
    """A big static box whose top is the plane z = 0 (turned about the origin)."""
    below = Pose(np.zeros(3), np.asarray(orientation, float))
    geom = Geom(
        "shape",
        Box((10.0, 10.0, 0.5)),
        Pose(np.array([0.0, 0.0, -0.5]), UPRIGHT),
        friction=Friction(friction, friction, restitution),
    )
    zero = np.zeros(3)
    return Body("floor", "/World/floor", "static", below, (geom,), None, zero, zero)


def scene(
    *bodies: Body,
    duration: float = 1.0,
    gravity: float = G,
    actions: tuple[Action, ...] = (),
    joints: tuple[Joint, ...] = (),
) -> Scene:
    """An episode of these bodies."""
    return Scene(
        name="test",
        gravity=np.array([0.0, 0.0, -gravity]),
        bodies=bodies,
        actions=actions,
        cameras=(),
        light=Light(np.array([0.0, 0.0, -1.0])),
        background=(1.0, 1.0, 1.0),
        observations=(),
        duration=duration,
        joints=joints,
    )
