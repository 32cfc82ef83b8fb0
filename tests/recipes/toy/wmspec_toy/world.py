"""Free bodies between steps: gravity, pushes, damping; angular momentum is kept, so that spinning bodies tumble."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import combinations
from typing import Any

import numpy as np

from wmspec.core.diagnostics import EngineError
from wmspec.sim.scene.joints.com_frame import com_frame
from wmspec.sim.scene.model import Pose, Scene
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.scene.model.transform import from_rotation_vector, multiply, rotation
from wmspec.sim.scene.physics.contact import can_collide, colliders, non_colliding_pairs


class World:
    """The scene's bodies by number, in their centre-of-mass frames: `wmspec.sim.scene.physics.episode.World`."""

    def __init__(self, scene: Scene, step: float) -> None:
        self.bodies = [com_frame(body) for body in scene.bodies]
        self.h, self.gravity, self.now = step, scene.gravity, 0.0
        self.position = np.array([body.pose.position for body in self.bodies])
        self.turn = np.array([body.pose.orientation for body in self.bodies])
        self.velocity, self.momentum = np.zeros_like(self.position), np.zeros_like(self.position)  # momentum: angular
        self.force, self.torque = np.zeros_like(self.position), np.zeros_like(self.position)
        self.held: set[int] = set()
        self.solid = {i: colliders(body) for i, body in enumerate(self.bodies) if colliders(body)}
        pairs = set(combinations(self.solid, 2)) - non_colliding_pairs(scene)
        self.pairs = [(i, j) for i, j in pairs if can_collide(self.bodies[i], self.bodies[j])]

    def kick(self, body: int, linear: Any, angular: Any, at: Any = None) -> None:
        if at is not None:
            self.position[body], self.turn[body] = np.array(at[:3]), np.array(at[3:])
        self.velocity[body], self.momentum[body] = linear, self.inertia(body) @ angular

    def driven(self, paths: Mapping[int, tuple[Any, Any, Any]]) -> Callable[[int], None]:
        def drive(i: int) -> None:
            for body, (_, there, _) in paths.items():
                self.position[body], self.turn[body] = there[i, :3], there[i, 3:]

        return drive

    def push(self, body: int, force: Any, torque: Any) -> None:
        self.force[body] += force
        self.torque[body] += torque

    def hold(self, body: int, at: Any = None) -> None:
        self.held.add(body)
        if at is not None:
            self.position[body], self.turn[body] = np.array(at[:3]), np.array(at[3:])

    def free(self, body: int) -> None:
        self.held.discard(body)

    def collide(self, one: int, other: int, collides: bool) -> None:
        self.pairs = [pair for pair in self.pairs if {*pair} != {one, other}] + [(one, other)] * collides

    def aim(self, joint: int, target: float) -> None:
        raise AssertionError("there are no joints")

    def grip(self, number: int, grip: Any, anchors: Any) -> None:
        raise AssertionError("there are no hands")

    def loose(self, number: int, grip: Any) -> None:
        raise AssertionError("there are no hands")

    def leave_out(self, first: int, most: int) -> int:
        return 0

    def step(self) -> None:
        """Velocities first, then positions with them: exact for free flight, as the kicks are half a step of g less."""
        self.now += self.h
        for i, body in enumerate(self.bodies):
            if body.inertia is None or i in self.held:
                continue
            self.velocity[i] += self.h * (self.gravity + self.force[i] / body.inertia.mass)
            self.momentum[i] += self.h * self.torque[i]
            self.velocity[i] *= np.exp(-body.linear_damping * self.h)
            self.momentum[i] *= np.exp(-body.angular_damping * self.h)
            self.position[i] += self.h * self.velocity[i]
            self.turn[i] = multiply(from_rotation_vector(self.h * self.spin(i)), self.turn[i])
        self.force[:] = self.torque[:] = 0

    def state(self, body: int) -> Any:
        return np.concatenate([self.position[body], self.turn[body], self.velocity[body], self.spin(body)])

    def touching(self) -> set[tuple[int, int]]:
        """Nothing ever touches. Raises EngineError where the boxes around two bodies overlap."""
        box = {i: world_box(geoms, Pose(self.position[i], self.turn[i])) for i, geoms in self.solid.items()}
        for i, j in self.pairs:
            if np.all(box[i][0] < box[j][1]) and np.all(box[j][0] < box[i][1]):
                met = f"{self.bodies[i].path} and {self.bodies[j].path}"
                raise EngineError(f"Toy knows free flight only, and {met} meet at {self.now:.3f} s; keep them apart")
        return set()

    def inertia(self, body: int) -> Any:
        """The tensor of inertia (3, 3) about the centre of mass, in the world's axes."""
        own, turn = self.bodies[body].inertia, rotation(self.turn[body])
        return turn @ np.diag(own.moments if own else np.ones(3)) @ turn.T

    def spin(self, body: int) -> Any:
        """The angular velocity (3,), rad/s."""
        return np.linalg.solve(self.inertia(body), self.momentum[body])
