"""The Newton implementation of `wmspec.sim.scene.physics.episode.World`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from wmspec.core.native_output import silence
from wmspec.sim.scene.model.transform import conjugate, rotate
from wmspec.sim.scene.physics.episode import TOUCH_BEGIN, Grip
from wmspec.sim.scene.physics.rigid import Assembly

from .build import HEAVY, WORLD, build

with silence():
    import newton

MOST_DENSE = 60  # degrees of freedom of which MuJoCo-Warp can make a dense Jacobian
NEVER = -1e3  # m: a margin at which shapes never touch
XYZW = [4, 5, 6, 3]  # from a pose (x, y, z, w, i, j, k) to Newton's order of quaternions


def options(assembly: Assembly, model: Any) -> dict[str, Any]:
    """Return the options of the solver."""
    return {
        "solver": "newton",
        "integrator": "implicitfast" if any(limb.drive for tree in assembly.trees for limb in tree) else "euler",
        "cone": "elliptic",
        "jacobian": "dense" if model.joint_dof_count <= MOST_DENSE * max(1, model.world_count) else "sparse",
        "iterations": 100,
        "tolerance": 1e-10,
        "enable_multiccd": True,
    }


class World:
    """A Newton model of the given bodies in order, with frames at their centres of mass, executed on the processor.

    `ties`: `solref` of grips, loop closures and mimic joints. The solver is Newton's on top of MuJoCo, whose data this
    class reads for what Newton does not return: contacts, and equality constraints that change during an episode.
    """

    def __init__(self, assembly: Assembly, grips: tuple[Grip, ...], contacts: Any, limits: Any, ties: Any) -> None:
        self.assembly, self.step_size = assembly, assembly.step
        built = build(assembly, contacts, limits)
        self.builder, self.links, self.joints, self.shapes = built.builder, built.links, built.joints, built.shapes
        self.trees = {limb.body: tree for tree in assembly.trees for limb in tree}
        self.held: set[int] = set()
        self.met: set[tuple[int, int]] = set()
        self.tie(self.builder, grips, ties)
        self.enter()

    def enter(self) -> None:
        """Make the model and its solver, and set the start."""
        self.model = self.builder.finalize(device="cpu")
        self.model.set_gravity(tuple(self.assembly.gravity))
        self.solver = newton.solvers.SolverMuJoCo(
            self.model, use_mujoco_cpu=True, njmax=4000, nconmax=1000, **options(self.assembly, self.model)
        )
        self.now, self.after, self.control = self.model.state(), self.model.state(), self.model.control()
        self.data = self.solver.mj_data
        self.begin()

    def tie(self, builder: Any, grips: tuple[Grip, ...], ties: Any) -> None:
        """Add loop closures, grips that are inactive at first, and mimic joints.

        Newton's own mimic joints have no parameters: they are soft, and within one articulation only.
        """
        self.grips: dict[int, list[int]] = {}
        rows = 0
        for closure in self.assembly.loop_closures:
            first, second = self.links.get(closure.first, WORLD), self.links.get(closure.second, WORLD)
            points = closure.below if second != WORLD else closure.above
            ends = (second, first) if second != WORLD else (first, second)
            for point in points:
                newton.solvers.mujoco.add_equality_connect(builder, *ends, anchor=point, solref=ties)
                rows += 1
        for number, grip in enumerate(grips):
            self.grips[number] = []
            for point in grip.points:
                ends = self.links[grip.hand], self.links[grip.body]
                newton.solvers.mujoco.add_equality_connect(builder, *ends, anchor=point, solref=ties, enabled=False)
                self.grips[number].append(rows)
                rows += 1
        for gear in self.assembly.mimic_constraints:
            pair, line = (self.joints[gear.body], self.joints[gear.leader]), (gear.offset, gear.ratio)
            newton.solvers.mujoco.add_equality_joint(builder, *pair, polycoef=line, solref=ties)

    def freedom(self, body: int) -> int:
        """Return the number of the first degree of freedom of a body in MuJoCo."""
        return int(self.solver.mj_qd_start.numpy()[self.joints[body]])

    def begin(self) -> None:
        """Read the numbers of coordinates and shapes, and set damping and the initial velocities of jointed bodies."""
        newton.eval_fk(self.model, self.model.joint_q, self.model.joint_qd, self.now)
        self.number = np.array([self.shapes.get(int(shape), -1) for shape in self.order()])
        self.coordinates, self.rates = self.model.joint_q_start.numpy(), self.model.joint_qd_start.numpy()
        self.start, self.start_poses = self.now.joint_q.numpy().copy(), self.now.body_q.numpy().copy()
        self.damp()
        speeds = self.now.joint_qd.numpy()
        for limb in (limb for tree in self.assembly.trees for limb in tree):
            at = self.rates[self.joints[limb.body]]
            if limb.kind == "free" and self.assembly.bodies[limb.body].velocity:
                speeds[at : at + 6] = self.assembly.bodies[limb.body].velocity
            elif limb.kind == "ball" and limb.rate:  # in the joint frame, not in that of the body
                speeds[at : at + 3] = rotate(conjugate(np.array(limb.below[3:])), np.array(limb.rate))
            elif limb.rate:
                speeds[at : at + len(limb.rate)] = limb.rate
        newton.eval_fk(self.model, self.now.joint_q, self.now.joint_qd, self.now)

    def order(self) -> Any:
        """Return Newton's number of each shape of MuJoCo."""
        return self.solver.mjc_geom_to_newton_shape.numpy()[0]

    def column(self, name: str) -> Any:
        """Return an array of MuJoCo's model or data, into which one may write."""
        return getattr(self.data if name == "eq_active" else self.solver.mj_model, name)

    def damp(self) -> None:
        """Set the damping of free bodies, which Newton's free joints do not have."""
        for number, body in enumerate(self.assembly.bodies):
            if body.motion == "dynamic" and number not in self.trees and any(body.damping):
                at, (linear, angular) = self.freedom(number), body.damping
                rates = [linear * body.mass] * 3 + [angular * moment for moment in body.moments]
                self.column("dof_damping")[at : at + 6] = rates

    def kick(self, body: int, linear: Any, angular: Any, at: Any = None) -> None:
        """Set the velocities of a free body, and its pose if `at` is given."""
        if at is not None:
            self.place(body, at)
        speed = self.rates[self.joints[body]]
        self.now.joint_qd.numpy()[speed : speed + 6] = [*linear, *angular]

    def driven(self, paths: Mapping[int, tuple[Any, Any, Any]]) -> Callable[[int], None]:
        """Return a function that resets kinematic bodies to their paths before step i."""
        ways = []
        for body, (here, _, speeds) in paths.items():
            joint = self.joints[body]
            poses = np.concatenate([here[:, :3], here[:, XYZW]], axis=1)
            ways.append((self.coordinates[joint], self.rates[joint], poses, speeds))

        def drive(i: int) -> None:
            places, rates = self.now.joint_q.numpy(), self.now.joint_qd.numpy()
            for q, qd, poses, speeds in ways:
                places[q : q + 7] = poses[i]
                rates[qd : qd + 6] = speeds[i]

        return drive

    def push(self, body: int, force: Any, torque: Any) -> None:
        """Apply a force and a torque at the centre of mass of a dynamic body during the next step."""
        self.now.body_f.numpy()[self.links[body]] += [*force, *torque]

    def aim(self, joint: int, target: float) -> None:
        """Set the target of a drive."""
        body = next(limb.body for tree in self.assembly.trees for limb in tree if limb.joint == joint)
        self.control.joint_target_q.numpy()[self.coordinates[self.joints[body]]] = target

    def collide(self, one: int, other: int, collides: bool) -> None:
        """Set whether two bodies collide: with a margin far below zero, MuJoCo finds no contact of a pair."""
        model = self.solver.mj_model
        bodies = np.sort(self.number[np.stack([model.pair_geom1, model.pair_geom2], axis=1)], axis=1)
        self.column("pair_margin")[(bodies == sorted((one, other))).all(axis=1)] = 0.0 if collides else NEVER

    def hold(self, body: int, at: Any = None) -> None:
        """Reset a dynamic body to its start or to `at`.

        A free body becomes as heavy as a kinematic one and is held against gravity.
        """
        if body in self.trees:
            for limb in self.trees[body]:
                self.rest(limb.body)
            newton.eval_fk(self.model, self.now.joint_q, self.now.joint_qd, self.now)
            return
        if body not in self.held:
            self.held.add(body)
            self.weigh(body, HEAVY, [HEAVY] * 3)
        self.rest(body)
        if at is not None:
            self.place(body, at)
        self.push(body, -HEAVY * np.array(self.assembly.gravity), np.zeros(3))

    def place(self, body: int, at: Any) -> None:
        """Set the pose of a free body."""
        pose = np.asarray(at)[[0, 1, 2, *XYZW]]
        q = self.coordinates[self.joints[body]]
        self.now.joint_q.numpy()[q : q + 7] = pose
        self.now.body_q.numpy()[self.links[body]] = pose

    def rest(self, body: int) -> None:
        """Reset the joint of a body to its start, at rest."""
        joint, link = self.joints[body], self.links[body]
        places, speeds = (slice(starts[joint], starts[joint + 1]) for starts in (self.coordinates, self.rates))
        self.now.joint_q.numpy()[places] = self.start[places]
        self.now.joint_qd.numpy()[speeds] = 0
        self.now.body_q.numpy()[link] = self.start_poses[link]
        self.now.body_qd.numpy()[link] = 0

    def free(self, body: int) -> None:
        """Release a held body."""
        if body not in self.trees:
            self.held.remove(body)
            self.weigh(body, self.assembly.bodies[body].mass, self.assembly.bodies[body].moments)

    def weigh(self, body: int, mass: float, moments: Any) -> None:
        """Set mass and moments of inertia."""
        link = self.links[body]
        self.model.body_mass.numpy()[link] = mass
        self.model.body_inv_mass.numpy()[link] = 1 / mass
        self.model.body_inertia.numpy()[link] = np.diag(moments)
        self.model.body_inv_inertia.numpy()[link] = np.diag(1 / np.asarray(moments))
        self.reweigh()

    def reweigh(self) -> None:
        """Tell the solver that masses have changed."""
        self.solver.notify_model_changed(newton.ModelFlags.BODY_INERTIAL_PROPERTIES)

    def grip(self, number: int, grip: Grip, anchors: Any) -> None:
        """Tie points of a hand to anchors in the frame of a body."""
        for tie, point, anchor in zip(self.grips[number], grip.points, anchors, strict=True):
            self.column("eq_data")[tie, :6] = [*point, *anchor]
            self.column("eq_active")[tie] = 1

    def loose(self, number: int, grip: Grip) -> None:  # noqa: ARG002  the interface of worlds
        """Release a grip."""
        for tie in self.grips[number]:
            self.column("eq_active")[tie] = 0

    def leave_out(self, first: int, most: int) -> int:  # noqa: ARG002  the interface of worlds
        """Return 0: bodies sleep in MuJoCo."""
        return 0

    def step(self) -> None:
        """Advance one step. Raises FloatingPointError if MuJoCo warns, after which it silently resets."""
        self.solver.step(self.now, self.after, self.control, None, self.step_size)
        self.now.clear_forces()
        self.now, self.after = self.after, self.now
        if self.data.warning.number.any():
            raise FloatingPointError(f"MuJoCo warnings: {self.data.warning.number} at {self.data.time:.4f} s")

    def state(self, body: int) -> Any:
        """Return position, quaternion, linear and angular velocity of a body in world axes (13,)."""
        link = self.links[body]
        pose, speed = self.now.body_q.numpy()[link], self.now.body_qd.numpy()[link]
        return np.concatenate([pose[:3], pose[[6, 3, 4, 5]], speed]).astype(float)

    def contacts(self) -> tuple[Any, Any]:
        """Return MuJoCo's shapes (n, 2) and the gaps (n,), m, of the contacts of the last step."""
        return self.data.contact.geom, self.data.contact.dist

    def touching(self) -> set[tuple[int, int]]:
        """Return the pairs that touched in the last step."""
        shapes, gaps = self.contacts()
        pairs = np.sort(self.number[shapes], axis=1).tolist()
        near = set(map(tuple, pairs))
        close = {tuple(pair) for pair, gap in zip(pairs, gaps.tolist(), strict=True) if gap < TOUCH_BEGIN}
        met = close | (near & self.met)
        if met != self.met:  # an equal set is the same object, which makes intervals quick to find
            self.met = met
        return self.met
