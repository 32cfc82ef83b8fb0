"""The scene in MuJoCo: what the loop in `wmspec.scene.episode` does, in MuJoCo's words."""

from __future__ import annotations

from typing import Any

import numpy as np

from wmspec.scene.silence import silence
from wmspec.scene.transform import conjugate, rotate

with silence():
    import mujoco

HEAVY = 1e6  # kg and kg m²: a body that nothing in the scene can push


class World:
    """A model whose bodies are the scene's, in order, frames at their centres of mass."""

    def __init__(self, model: Any, damping: dict[int, tuple[float, float]]) -> None:
        """`damping`: body -> linear and angular rate, 1/s; MJCF has only one number for both, so it is set here."""
        self.model, self.data = model, mujoco.MjData(model)
        joints = model.body_jntadr[1:]  # body 0 is the world
        self.qpos = np.where(joints < 0, -1, model.jnt_qposadr[joints] if model.njnt else -1)
        self.qvel = np.where(joints < 0, -1, model.jnt_dofadr[joints] if model.njnt else -1)
        self.warned = self.data.warning.number  # a view
        self.pairs: dict[bytes, set[tuple[int, int]]] = {}
        self.held: dict[int, tuple[float, Any]] = {}
        self.pushed = False
        for body, (linear, angular) in damping.items():
            at = self.qvel[body]
            model.dof_damping[at : at + 3] = linear * model.body_mass[body + 1]
            model.dof_damping[at + 3 : at + 6] = angular * model.body_inertia[body + 1]

    def kick(self, body: int, linear: Any, angular: Any) -> None:
        """Set the velocities of a dynamic body."""
        at, turn = self.qvel[body], self.data.qpos[self.qpos[body] + 3 : self.qpos[body] + 7]
        self.data.qvel[at : at + 3] = linear
        self.data.qvel[at + 3 : at + 6] = rotate(conjugate(turn), angular)

    def drive(self, body: int, pose: Any, speeds: Any) -> None:
        """Put a kinematic body back on its path, undoing whatever pushed it."""
        place, speed = self.qpos[body], self.qvel[body]
        self.data.qpos[place : place + 7] = pose
        self.data.qvel[speed : speed + 3] = speeds[:3]
        self.data.qvel[speed + 3 : speed + 6] = rotate(conjugate(pose[3:]), speeds[3:])

    def push(self, body: int, force: Any) -> None:
        """Let a force act at the centre of mass of a dynamic body during the next step."""
        self.data.xfrc_applied[body + 1, :3] += force
        self.pushed = True

    def hold(self, body: int) -> None:
        """Put a dynamic body back where it began, as heavy as a kinematic one, and hold it against gravity."""
        if body not in self.held:
            self.held[body] = self.model.body_mass[body + 1], self.model.body_inertia[body + 1].copy()
            self.weigh(body, HEAVY, np.full(3, HEAVY))
        self.drive(body, self.model.qpos0[self.qpos[body] : self.qpos[body] + 7], np.zeros(6))
        self.push(body, -HEAVY * self.model.opt.gravity)

    def free(self, body: int) -> None:
        """Let go of what has been held."""
        self.weigh(body, *self.held.pop(body))

    def weigh(self, body: int, mass: float, moments: Any) -> None:
        """Set the mass and the moments of inertia; of a free body, MuJoCo takes them from its degrees of freedom."""
        self.model.body_mass[body + 1], self.model.body_inertia[body + 1] = mass, moments
        self.model.dof_M0[self.qvel[body] : self.qvel[body] + 6] = [mass] * 3 + list(moments)

    def step(self) -> None:
        """Advance. On a warning MuJoCo would silently start over: that is an error here."""
        mujoco.mj_step(self.model, self.data)
        if self.warned.any():
            raise FloatingPointError(f"MuJoCo's warnings are {self.warned} at {self.data.time:.4f} s")
        if self.pushed:
            self.data.xfrc_applied[:] = 0
            self.pushed = False

    def state(self, body: int) -> Any:
        """Position, quaternion, linear and angular velocity of a body in world axes, (13,)."""
        pose = self.data.qpos[self.qpos[body] : self.qpos[body] + 7]
        speed = self.data.qvel[self.qvel[body] : self.qvel[body] + 6]
        return np.concatenate([pose, speed[:3], rotate(pose[3:], speed[3:])])

    def touching(self) -> set[tuple[int, int]]:
        """The pairs of bodies in contact in the last step; mostly the same geometries as in the step before."""
        if not self.data.ncon:
            return set()
        geoms = self.data.contact.geom
        key = geoms.tobytes()
        if key not in self.pairs:
            bodies = np.sort(self.model.geom_bodyid[geoms] - 1, axis=1)
            self.pairs[key] = set(map(tuple, bodies.tolist()))
        return self.pairs[key]
