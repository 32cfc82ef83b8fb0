"""The MuJoCo implementation of `wmspec.sim.scene.physics.episode.World`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from wmspec.core.native_output import silence
from wmspec.sim.scene.joints.articulations import Link
from wmspec.sim.scene.model.transform import conjugate, rotate
from wmspec.sim.scene.physics.episode import TOUCH_BEGIN, Grip
from wmspec.sim.scene.physics.rigid import Assembly, Rigid

from .clearance import is_clear

with silence():
    import mujoco

_WORDS = {
    "INERTIA": "an inertia is nearly singular",
    "CONTACTFULL": "there are more contacts than fit its memory",
    "CNSTRFULL": "there are more constraints than fit its memory",
    "BADQPOS": "positions grow without bound",
    "BADQVEL": "velocities grow without bound",
    "BADQACC": "accelerations grow without bound",
    "BADCTRL": "a drive has no finite target",
}

NEVER = -1e6  # m: margin of a pair of geoms without contacts
HEAVY = 1e6  # kg and kg m²: immovable by other bodies


class World:
    """A model of the bodies of a scene, with frames at their centres of mass."""

    def __init__(self, model: Any, assembly: Assembly) -> None:
        self.model, self.data, self.bodies = model, mujoco.MjData(model), assembly.bodies
        names = [body.name for body in assembly.bodies]
        self.ids = np.array([mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name) for name in names])
        known = np.flatnonzero(self.ids >= 0)  # static bodies without collision are not in the model
        self.number = np.full(model.nbody, -1)
        self.number[self.ids[known]] = known
        self.trees = {limb.body: tree for tree in assembly.trees for limb in tree}
        joints = np.where(self.ids < 0, -1, model.body_jntadr[self.ids])
        self.qpos = np.where(joints < 0, -1, model.jnt_qposadr[joints] if model.njnt else -1)
        self.qvel = np.where(joints < 0, -1, model.jnt_dofadr[joints] if model.njnt else -1)
        self.warned, self.calm = self.data.warning.number, self.data.warning.number.tobytes()  # a view, not a copy,
        self.contacts, self.sleep = self.data.contact, self.data.tree_asleep  # as are these
        self.pairs: dict[bytes, tuple[list[tuple[int, int]], set[tuple[int, int]]]] = {}
        self.close: dict[tuple[bytes, tuple[bool, ...]], set[tuple[int, int]]] = {}
        self.met: set[tuple[int, int]] = set()
        self.resting: set[tuple[int, int]] = set()
        self.asleep = self.sleep.tobytes()
        self.settled: tuple[bytes, bytes] | None = None
        self.held: set[int] = set()
        self.pushed, self.current = False, False
        self.movable = model.body_treeid[self.ids[[i for i, b in enumerate(assembly.bodies) if b.motion == "dynamic"]]]
        self.slept, self.idle, self.late, self.last = False, False, 0, 0
        self.ways: dict[int, Any] = {}
        self.clear: Any = None
        self.start, self.margins = self.data.qpos.copy(), model.pair_margin.copy()
        self.forces = self.data.xfrc_applied  # a view
        self.lift = np.concatenate([-HEAVY * model.opt.gravity, np.zeros(3)])
        self.reset_views: dict[int, tuple[Any, Any, Any]] = {}
        self.drives = {limb.joint: limb.drive for tree in assembly.trees for limb in tree if limb.drive}
        for limb in (limb for tree in assembly.trees for limb in tree):
            begun = rates(limb, assembly.bodies[limb.body])
            self.data.qvel[self.qvel[limb.body] : self.qvel[limb.body] + len(begun)] = begun
        self.actuators = {joint: i for i, joint in enumerate(self.drives)}
        self.fresh = set(self.drives)
        for joint, drive in self.drives.items():
            self.aim(joint, drive[2])
        for body, rigid in enumerate(assembly.bodies):  # MJCF has one number for both damping rates
            if rigid.motion == "dynamic" and body not in self.trees:
                at, (linear, angular) = self.qvel[body], rigid.damping
                model.dof_damping[at : at + 6] = [linear * rigid.mass] * 3 + [angular * m for m in rigid.moments]

    def kick(self, body: int, linear: Any, angular: Any, at: Any = None) -> None:
        """Set the velocities of a free body, and its pose if `at` is given."""
        self.stir()
        place, speed = self.qpos[body], self.qvel[body]
        if at is not None:
            self.data.qpos[place : place + 7] = at
        self.data.qvel[speed : speed + 3] = linear
        self.data.qvel[speed + 3 : speed + 6] = rotate(conjugate(self.data.qpos[place + 3 : place + 7]), angular)

    def driven(self, paths: Mapping[int, tuple[Any, Any, Any]]) -> Callable[[int], None]:
        """Return a function that resets kinematic bodies to their paths before step i."""
        if not paths:
            return lambda _: None
        self.ways = {int(self.ids[body]): here for body, (here, _, _) in paths.items()}
        (places, poses), (rates, speeds) = self.kinematic_states(paths)
        every_pose, every_speed = self.data.qpos, self.data.qvel
        if (np.diff(places) == 1).all():  # views of contiguous ranges are faster
            every_pose, every_speed = every_pose[places[0] : places[-1] + 1], every_speed[rates[0] : rates[-1] + 1]
            places = rates = slice(None)

        def put(i: int) -> None:
            every_pose[places] = poses[i]
            every_speed[rates] = speeds[i]

        def drive(i: int) -> None:
            self.stir()
            put(i)

        self.put = put
        return drive

    def kinematic_states(self, paths: Mapping[int, tuple[Any, Any, Any]]) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Return MuJoCo's position indices of kinematic bodies and their values before each step (T, 7 n), and the same
        of velocities (T, 6 n).
        """
        bodies = list(paths)
        places = (self.qpos[bodies][:, None] + np.arange(7)).ravel()
        rates = (self.qvel[bodies][:, None] + np.arange(6)).ravel()
        poses = np.concatenate([here for here, _, _ in paths.values()], axis=1)
        spins = [rotate(conjugate(here[:, 3:]), speeds[:, 3:]) for here, _, speeds in paths.values()]
        both = zip(paths.values(), spins, strict=True)
        speeds = np.concatenate([part for (_, _, path), spin in both for part in (path[:, :3], spin)], axis=1)
        return (places, poses), (rates, speeds)

    def stir(self) -> None:
        """Force the next step, and first perform the last skipped one.

        Only the last skipped step has an effect: it sets the poses of kinematic bodies.
        """
        self.idle = False
        if self.late:
            time, step = self.data.time, self.model.opt.timestep
            for _ in range(self.late - 1):
                time += step
            self.data.time, self.late = time, 0
            self.put(self.last)
            self.step()

    def push(self, body: int, force: Any, torque: Any) -> None:
        """Apply a force and a torque at the centre of mass of a dynamic body during the next step."""
        self.stir()
        self.forces[self.ids[body]] += [*force, *torque]
        self.pushed = True

    def aim(self, joint: int, target: float) -> None:
        """Set the target of a drive."""
        self.stir()
        stiffness, damping, _, velocity, _ = self.drives[joint]
        self.data.ctrl[self.actuators[joint]] = stiffness * target + damping * velocity

    def collide(self, one: int, other: int, collides: bool) -> None:
        """Set whether two bodies collide: with a margin far below zero, MuJoCo finds no contact of a pair."""
        self.stir()
        bodies = self.model.geom_bodyid[np.stack([self.model.pair_geom1, self.model.pair_geom2], axis=1)]
        between = (np.sort(bodies, axis=1) == np.sort(self.ids[[one, other]])).all(axis=1)
        self.model.pair_margin[between] = self.margins[between] if collides else NEVER

    def hold(self, body: int, at: Any = None) -> None:
        """Reset a dynamic body to its start or to `at`.

        A free body becomes as heavy as a kinematic one and is held against gravity.
        """
        self.stir()
        if body in self.trees:
            for limb in self.trees[body]:
                self.rest(limb.body)
            self.fresh |= {limb.joint for limb in self.trees[body] if limb.drive}
            return
        if body not in self.held:
            self.held.add(body)
            self.weigh(body, HEAVY, np.full(3, HEAVY))
        self.rest(body)
        if at is not None:
            self.data.qpos[self.qpos[body] : self.qpos[body] + 7] = at
        self.forces[self.ids[body]] += self.lift
        self.pushed = True

    def rest(self, body: int) -> None:
        """Reset the joint of a body to its start, at rest."""
        if body not in self.reset_views:
            self.reset_views[body] = self.joint_views(body)
        position, start, velocity = self.reset_views[body]
        position[:], velocity[:] = start, 0.0
        self.current = False

    def joint_views(self, body: int) -> tuple[Any, Any, Any]:
        """Return views of position, start and velocity of the joint of a body; they are empty without a joint."""
        places = speeds = 0
        if self.model.body_jntnum[self.ids[body]]:
            kind = int(self.model.jnt_type[self.model.body_jntadr[self.ids[body]]])
            places, speeds = {0: (7, 6), 1: (4, 3)}.get(kind, (1, 1))
        at, speed = self.qpos[body], self.qvel[body]
        place = slice(at, at + places)
        return self.data.qpos[place], self.start[place], self.data.qvel[speed : speed + speeds]

    def free(self, body: int) -> None:
        """Release a held body."""
        self.stir()
        if body not in self.trees:
            self.held.remove(body)
            self.weigh(body, self.bodies[body].mass, self.bodies[body].moments)

    def grip(self, number: int, grip: Grip, anchors: Any) -> None:
        """Tie points of a hand to anchors in the frame of a body."""
        self.stir()
        for i, (point, anchor) in enumerate(zip(grip.points, anchors, strict=True)):
            tie = self.model.equality(f"grip {number} {i}").id
            self.model.eq_data[tie, :6] = [*point, *anchor]
            self.data.eq_active[tie] = 1

    def loose(self, number: int, grip: Grip) -> None:
        """Release a grip."""
        self.stir()
        for i in range(len(grip.points)):
            self.data.eq_active[self.model.equality(f"grip {number} {i}").id] = 0

    def weigh(self, body: int, mass: float, moments: Any) -> None:
        """Set mass and moments of inertia; MuJoCo derives those of a free body from its degrees of freedom."""
        self.model.body_mass[self.ids[body]], self.model.body_inertia[self.ids[body]] = mass, moments
        self.model.dof_M0[self.qvel[body] : self.qvel[body] + 6] = [mass] * 3 + list(moments)

    def leave_out(self, first: int, most: int) -> int:
        """Leave out steps from `first` on while all movable bodies sleep and nothing comes close; return their number.

        At most `most` steps are left out. They are made up for later.
        """
        if not (self.idle and self.ways and most):
            return 0
        if self.clear is None:
            self.clear = is_clear(self.model, self.data, self.ways, first)
        ahead = self.clear[first : first + most]
        left_out = len(ahead) if ahead.all() else int(ahead.argmin())
        if left_out:
            self.late, self.last = self.late + left_out, first + left_out - 1
        return left_out

    def step(self) -> None:
        """Advance one step. A warning, after which MuJoCo silently resets, raises an error.

        Half of a drive's force in its first step makes the motion exact, as with gravity.
        """
        for joint in self.fresh:
            self.scale(self.actuators[joint], 0.5)
        mujoco.mj_step(self.model, self.data)
        for joint in self.fresh:
            self.scale(self.actuators[joint], 2.0)
        self.fresh.clear()
        if self.warned.tobytes() != self.calm:
            raise FloatingPointError(warning_text(self.warned, self.data.time))
        if self.pushed:
            self.forces.fill(0.0)
            self.pushed = False
        self.current = False

    def scale(self, actuator: int, factor: float) -> None:
        """Scale the force of a drive."""
        self.model.actuator_gainprm[actuator, 0] *= factor
        self.model.actuator_biasprm[actuator, 1:3] *= factor

    def state(self, body: int) -> Any:
        """Return position, quaternion, linear and angular velocity of a body in world axes (13,)."""
        if body in self.trees:
            return self.limb(self.ids[body])
        pose = self.data.qpos[self.qpos[body] : self.qpos[body] + 7]
        speed = self.data.qvel[self.qvel[body] : self.qvel[body] + 6]
        return np.concatenate([pose, speed[:3], rotate(pose[3:], speed[3:])])

    def limb(self, number: int) -> Any:
        """Return the same of a body in a tree, for which MuJoCo stores the joint state only."""
        if not self.current:
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_comPos(self.model, self.data)
            mujoco.mj_comVel(self.model, self.data)
            self.current = True
        speeds = np.zeros(6)
        mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_BODY, number, speeds, 0)
        return np.concatenate([self.data.xpos[number], self.data.xquat[number], speeds[3:], speeds[:3]])

    def touching(self) -> set[tuple[int, int]]:
        """Return the pairs that touched in the last step.

        MuJoCo reports no contacts of sleeping bodies: their pairs are kept.
        """
        geoms, asleep = self.contacts.geom, self.sleep.tobytes()
        key = geoms.tobytes()
        if (key, asleep) == self.settled:
            self.idle = self.slept and not key
            return self.met
        if key not in self.pairs:
            bodies = np.sort(self.number[self.model.geom_bodyid[geoms]], axis=1)
            each = list(map(tuple, bodies.tolist()))
            self.pairs[key] = each, set(each)
        each, near = self.pairs[key]
        if self.asleep != asleep:
            self.asleep = asleep
            self.resting = {pair for pair in self.met if self.sleeps(*pair)}
            self.slept, self.clear = bool((self.sleep[self.movable] >= 0).all()), None
        if near | self.resting == self.met:
            self.settled = key, asleep
        else:
            self.settled = None
            close = tuple([far < TOUCH_BEGIN for far in self.contacts.dist.tolist()])
            if (key, close) not in self.close:
                self.close[key, close] = {pair for pair, meets in zip(each, close, strict=True) if meets}
            self.met = self.close[key, close] | (near & self.met) | self.resting
        return self.met

    def sleeps(self, first: int, second: int) -> bool:
        """Whether MuJoCo skips two bodies, at least one of which is movable."""
        trees = self.model.body_treeid[self.ids[[first, second]]]
        return all(tree < 0 or self.sleep[tree] >= 0 for tree in trees.tolist())


def rates(limb: Link, body: Rigid) -> list[float]:
    """Return the initial joint velocity in MuJoCo's order: angular ones in body axes."""
    match limb.kind:
        case "fixed":
            return []
        case "free":
            linear, angular = body.velocity[:3] or (0.0,) * 3, body.velocity[3:] or (0.0,) * 3
            return [*linear, *rotate(conjugate(np.array(body.start[3:])), np.array(angular)).tolist()]
        case "ball":
            return [*(limb.rate or (0.0,) * 3)]
        case _:
            return [*(limb.rate or (0.0,))]


def warning_text(counts: Sequence[int], time: float) -> str:
    """Return the warnings with a count above 0 in words, and the time (s) of the state."""
    raised = [words for kind, words in _WORDS.items() if counts[int(getattr(mujoco.mjtWarning, f"mjWARN_{kind}"))]]
    return f"MuJoCo gives up at {time:.4g} s: {' and '.join(raised)}"
