"""The PyBullet implementation of `wmspec.sim.scene.physics.episode.World`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import exp, sqrt
from typing import Any

import numpy as np

from wmspec.core.native_output import silence
from wmspec.sim.scene.joints.articulations import Link, LoopClosure, MimicConstraint
from wmspec.sim.scene.physics.episode import TOUCH_BEGIN, TOUCH_END, Grip
from wmspec.sim.scene.physics.rest import RestingWorld
from wmspec.sim.scene.physics.rigid import Assembly, CollisionShape, Rigid

from .articulations import add_multibody, reset_tree
from .shapes import IDENTITY_POSE, shape, xyzw

with silence():
    import pybullet

SOLVER_ITERATIONS = 200, 250  # with 100 a stack of five creeps twice as far; with 200 hands turn pushed bodies
SOLVER_RESIDUAL = 1e-15  # squared change of speed (m²/s²) that ends the iteration; with 1e-13 balls push 1 % less far
HEAVY_MASS, HEAVY_INERTIA = 1e4, 1e6  # kg, kg m²: immovable by other bodies
DYNAMIC, PRESCRIBED = 1, 2  # collision groups: bodies with prescribed motion do not collide with each other
ROUND = ("sphere", "capsule")  # shapes whose margin is their radius
SOFT_ERP = 0.02  # overlap corrected per step; links gain speed from it, free bodies do not
TIE_FORCE = 1e6  # N: maximum force of a grip point
MAX_JOINT_SPEED = 1e4  # rad/s or m/s of a joint; PyBullet's default is 100


class World(RestingWorld):
    """A client with the bodies of a scene in order. Close it after use."""

    def __init__(self, assembly: Assembly) -> None:
        super().__init__(assembly)
        self.client = pybullet.connect(pybullet.DIRECT)
        self.lift = list(-HEAVY_MASS * np.array(assembly.gravity))
        pybullet.setGravity(*assembly.gravity, physicsClientId=self.client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=assembly.step,
            numSubSteps=0,
            numSolverIterations=SOLVER_ITERATIONS[
                any(body.motion == "kinematic" and body.pieces for body in self.bodies)
            ],
            solverResidualThreshold=SOLVER_RESIDUAL,
            useSplitImpulse=1,
            splitImpulsePenetrationThreshold=0.0,
            restitutionVelocityThreshold=0.0,
            erp=0.2,
            contactERP=SOFT_ERP if assembly.trees else 0.2,
            enableConeFriction=1,
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        self.parts: dict[int, list[tuple[int, int]]] = {}
        for i, body in enumerate(self.bodies):
            if i not in self.trees:
                self.parts[i] = self.add(body)
            elif i not in self.parts:
                self.parts |= self.grow(self.trees[i])
        self.index = {part: body for body, parts in self.parts.items() for part in parts}
        self.pairs: dict[tuple[int, int, int, int], tuple[int, int]] = {}
        self.ids = [self.parts[i][0] if self.parts[i] else (-1, -1) for i in range(len(self.bodies))]
        self.drives = {limb.joint: limb for tree in assembly.trees for limb in tree if limb.drive}
        self.targets = {joint: limb.drive[2] for joint, limb in self.drives.items()}
        self.fresh = set(self.drives)
        self.held: set[int] = set()
        self.lifted: set[int] = set()
        for a, b in assembly.non_colliding_pairs:
            for one, other in [(one, other) for one in self.parts[a] for other in self.parts[b]]:
                pybullet.setCollisionFilterPair(one[0], other[0], one[1], other[1], 0, physicsClientId=self.client)

        for tie in assembly.loop_closures:
            self.tie(tie)
        for gear in assembly.mimic_constraints:
            self.gear(gear)

    def tie(self, tie: LoopClosure) -> None:
        """Close a loop."""
        first, second, above, below = tie.first, tie.second, tie.above, tie.below
        if first < 0:  # the world can only be the second body
            first, second, above, below = second, first, below, above
        other = self.ids[second] if second >= 0 else (-1, -1)
        for one, two in zip(above, below, strict=True):
            self.point(self.ids[first], other, one, two)

    def point(self, one: tuple[int, int], other: tuple[int, int], here: Any, there: Any) -> int:
        """Hold a point of a body or link to one of another, or of the world."""
        ends = (*one, *other, pybullet.JOINT_POINT2POINT, [0.0, 0.0, 0.0], list(here), list(there))
        made: int = pybullet.createConstraint(*ends, physicsClientId=self.client)
        pybullet.changeConstraint(made, maxForce=TIE_FORCE, erp=0.2, physicsClientId=self.client)
        return made

    def gear(self, gear: MimicConstraint) -> None:
        """Add a mimic constraint."""
        made = pybullet.createConstraint(
            *self.ids[gear.body],
            *self.ids[gear.leader],
            pybullet.JOINT_GEAR,
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            physicsClientId=self.client,
        )
        pybullet.changeConstraint(
            made,
            gearRatio=-gear.ratio,
            relativePositionTarget=gear.offset,
            erp=0.2,
            maxForce=TIE_FORCE,
            physicsClientId=self.client,
        )

    def add(self, body: Rigid) -> list[tuple[int, int]]:
        """Add a body; a static one becomes one per shape, because only then materials may differ."""
        wholes = [(piece,) for piece in body.pieces] if body.motion == "static" else [body.pieces]
        return [(self.make(body, pieces), -1) for pieces in wholes]

    def make(self, body: Rigid, pieces: tuple[CollisionShape, ...]) -> int:
        """Add one PyBullet body; a kinematic one is a heavy free body whose state is set before every step."""
        heavy = body.motion == "kinematic"
        mass = HEAVY_MASS if heavy else body.mass
        place = [body.start[:3], xyzw(body.start[3:])]
        handle: int = pybullet.createMultiBody(
            mass,
            shape(pieces, IDENTITY_POSE, self.client),
            -1,
            *place,
            useMaximalCoordinates=1,
            physicsClientId=self.client,
        )
        damping = {  # PyBullet's damping is the fraction lost per second
            "linearDamping": 1 - exp(-body.damping[0]),
            "angularDamping": 1 - exp(-body.damping[1]),
        }
        moments = [HEAVY_INERTIA] * 3 if heavy else body.moments
        self.settle((handle, -1), pieces, mass, moments, **damping)
        group, mask = (DYNAMIC, DYNAMIC | PRESCRIBED) if body.motion == "dynamic" else (PRESCRIBED, DYNAMIC)
        pybullet.setCollisionFilterGroupMask(handle, -1, group, mask, physicsClientId=self.client)
        return handle

    def grow(self, tree: tuple[Link, ...]) -> dict[int, list[tuple[int, int]]]:
        """Add the bodies of a tree in joint coordinates."""
        pieces = [self.bodies[limb.body].pieces for limb in tree]
        shapes = [shape(p, limb.below, self.client) for p, limb in zip(pieces, tree, strict=True)]
        made = add_multibody(tree, self.bodies, shapes, self.client)
        whole = {"linearDamping": 0.0, "angularDamping": 0.0, "maxJointVelocity": MAX_JOINT_SPEED}
        pybullet.changeDynamics(made[tree[0].body][0], -1, physicsClientId=self.client, **whole)
        for limb, own in zip(tree, pieces, strict=True):
            body, part = self.bodies[limb.body], made[limb.body]
            joint = {"jointDamping": 0.0} if part[1] >= 0 else {}
            if limb.limits:
                joint |= {"jointLowerLimit": limb.limits[0], "jointUpperLimit": limb.limits[1]}
            self.settle(part, own, body.mass, body.moments, **joint)
            pybullet.setCollisionFilterGroupMask(*part, DYNAMIC, DYNAMIC | PRESCRIBED, physicsClientId=self.client)
        reset_tree(tree, made, self.bodies, self.client, moving=True)
        return {body: [part] for body, part in made.items()}

    def settle(
        self, part: tuple[int, int], pieces: tuple[CollisionShape, ...], mass: float, moments: Any, **more: float
    ) -> None:
        """Set dynamics and material of a body or link.

        PyBullet applies some settings of a link to the base: these are set separately, and the margin of a link stays.
        """
        settings: dict[str, Any] = {
            "rollingFriction": 0.0,
            "spinningFriction": 0.0,
            "contactProcessingThreshold": 0.0,  # the default degrades restitution at small steps
            **more,
        }
        if pieces:  # PyBullet multiplies materials: square roots give the geometric mean
            settings |= {"lateralFriction": sqrt(pieces[0].material[1]), "restitution": sqrt(pieces[0].material[2])}
        if mass:  # setting one alone resets the other to zero
            settings |= {"mass": mass, "localInertiaDiagonal": moments}
        pybullet.changeDynamics(*part, physicsClientId=self.client, **settings)
        base: dict[str, Any] = {"activationState": pybullet.ACTIVATION_STATE_DISABLE_SLEEPING}
        if part[1] < 0 and pieces and pieces[0].kind not in ROUND:
            base |= {"collisionMargin": 0.0}
        pybullet.changeDynamics(part[0], -1, physicsClientId=self.client, **base)

    def kick(self, body: int, linear: Any, angular: Any, at: Any = None) -> None:
        """Set the velocities of a free body, and its pose if `at` is given."""
        self.stir()
        if at is not None:
            place, turn = list(at[:3]), xyzw(at[3:])
            pybullet.resetBasePositionAndOrientation(self.ids[body][0], place, turn, physicsClientId=self.client)
        pybullet.resetBaseVelocity(self.ids[body][0], list(linear), list(angular), physicsClientId=self.client)

    def driven(self, paths: Mapping[int, tuple[Any, Any, Any]]) -> Callable[[int], None]:
        """Return a function that resets kinematic bodies to their paths before step i.

        Distant ones are reset at times only.
        """
        self.moves = [(body, np.concatenate([here, speeds], axis=1)) for body, (here, _, speeds) in paths.items()]
        self.rest_detector.follow(paths)

        def drive(i: int) -> None:
            if self.skipped is not None:
                self.resume()
            if self.moves:
                self.move(i, self.rest_detector.neighbours(i, self.state) if not self.loop_closures else None)

        return drive

    def move(self, i: int, near: set[int] | None = None) -> None:
        """Reset kinematic bodies to their paths before step i, all or those in `near`."""
        for body, states in self.moves:
            if near is None or body in near:
                x, y, z, c, u, v, w, *speeds = states[i].tolist()
                self.reset(self.ids[body][0], (x, y, z), (u, v, w, c), speeds[:3], speeds[3:])

    def drive(self, body: int, here: Any, speeds: Any) -> None:
        """Reset a kinematic body to its path and hold it against gravity."""
        self.reset(self.ids[body][0], list(here[:3]), xyzw(here[3:]), list(speeds[:3]), list(speeds[3:]))

    def reset(self, handle: int, place: Any, turn: Any, speed: Any, spin: Any) -> None:
        """Reset a heavy body, given PyBullet's quaternion (x, y, z, w), and hold it against gravity."""
        client = self.client
        pybullet.resetBasePositionAndOrientation(handle, place, turn, physicsClientId=client)
        pybullet.resetBaseVelocity(handle, speed, spin, physicsClientId=client)
        if handle not in self.lifted:
            self.lifted.add(handle)
            pybullet.applyExternalForce(handle, -1, self.lift, place, pybullet.WORLD_FRAME, physicsClientId=client)

    def push(self, body: int, force: Any, torque: Any) -> None:
        """Apply a force and a torque at the centre of mass of a body during the next step."""
        self.stir()
        part, here = self.ids[body], self.state(body)[:3]
        where = {"flags": pybullet.WORLD_FRAME, "physicsClientId": self.client}
        pybullet.applyExternalForce(*part, list(force), list(here), **where)
        if np.any(torque):
            pybullet.applyExternalTorque(*part, list(torque), **where)

    def aim(self, joint: int, target: float) -> None:
        """Set the target of a drive."""
        self.stir()
        self.targets[joint] = target

    def collide(self, one: int, other: int, collides: bool) -> None:
        """Set whether two bodies collide."""
        self.stir()
        for a, b in [(a, b) for a in self.parts[one] for b in self.parts[other]]:
            pybullet.setCollisionFilterPair(a[0], b[0], a[1], b[1], int(collides), physicsClientId=self.client)

    def hold(self, body: int, at: Any = None) -> None:
        """Reset a dynamic body to its start or to `at`; a free one becomes as heavy as a kinematic one."""
        place = tuple(self.bodies[body].start if at is None else at)
        if self.places.get(body) != place:
            self.stir()
            self.places[body] = place
        if not self.rest_detector.idle:
            self.keep(body)

    def keep(self, body: int) -> None:
        """Reset a held body to its place."""
        self.states.clear()
        if body in self.trees:
            made = {limb.body: self.ids[limb.body] for limb in self.trees[body]}
            reset_tree(self.trees[body], made, self.bodies, self.client, moving=False)
            self.fresh |= {limb.joint for limb in self.trees[body] if limb.drive}
            return
        if body not in self.held:
            self.held.add(body)
            self.weigh(body, HEAVY_MASS, [HEAVY_INERTIA] * 3)
        self.drive(body, self.places[body], (0.0,) * 6)

    def free(self, body: int) -> None:
        """Release a held body, without the force that held it against gravity."""
        place = self.places.pop(body)
        self.stir()
        if body not in self.trees:
            self.held.remove(body)
            if (handle := self.ids[body][0]) in self.lifted:
                down = [-force for force in self.lift]
                pybullet.applyExternalForce(
                    handle, -1, down, place[:3], pybullet.WORLD_FRAME, physicsClientId=self.client
                )
            self.weigh(body, self.bodies[body].mass, self.bodies[body].moments)

    def grip(self, number: int, grip: Grip, anchors: Any) -> None:
        """Tie points of a hand to anchors in the frame of a body."""
        self.stir()
        ends = [(self.ids[grip.hand], grip.points), (self.ids[grip.body], anchors)]
        if grip.body in self.trees:  # constraints go from link to free body only
            ends.reverse()
        (one, here), (other, there) = ends
        self.loop_closures[number] = [self.point(one, other, *both) for both in zip(here, there, strict=True)]

    def loose(self, number: int, _grip: Grip) -> None:
        """Release a grip."""
        self.stir()
        for tie in self.loop_closures.pop(number):
            pybullet.removeConstraint(tie, physicsClientId=self.client)

    def weigh(self, body: int, mass: float, moments: Any) -> None:
        """Set mass and moments of inertia."""
        weight = {"mass": mass, "localInertiaDiagonal": moments}
        pybullet.changeDynamics(*self.ids[body], physicsClientId=self.client, **weight)

    def step(self) -> None:
        """Advance one step with the forces of drives, which PyBullet's motors lack.

        Half of them in the first step makes the motion exact, as with gravity.
        """
        for joint, limb in self.drives.items():
            stiffness, damping, _, velocity, most = limb.drive
            place, speed = pybullet.getJointState(*self.ids[limb.body], physicsClientId=self.client)[:2]
            force = stiffness * (self.targets[joint] - place) + damping * (velocity - speed)
            force *= 0.5 if joint in self.fresh else 1.0
            pybullet.setJointMotorControl2(
                *self.ids[limb.body],
                pybullet.TORQUE_CONTROL,
                force=max(-most, min(most, force)),
                physicsClientId=self.client,
            )
        self.fresh.clear()
        pybullet.stepSimulation(physicsClientId=self.client)
        self.lifted.clear()
        self.states.clear()
        self.rest_detector.check(self.state, bool(self.loop_closures))

    def read_state(self, body: int) -> Any:
        """Return the state of a body from PyBullet."""
        handle, link = self.ids[body]
        if link < 0:
            position, turn = pybullet.getBasePositionAndOrientation(handle, physicsClientId=self.client)
            linear, angular = pybullet.getBaseVelocity(handle, physicsClientId=self.client)
        else:
            state = pybullet.getLinkState(handle, link, 1, 1, physicsClientId=self.client)
            position, turn, linear, angular = state[0], state[1], state[6], state[7]
        return [*position, turn[3], *turn[:3], *linear, *angular]

    def touching(self) -> set[tuple[int, int]]:
        """Return the pairs that touched in the last step."""
        met, pairs, last = set(), self.pairs, self.met
        for point in pybullet.getContactPoints(physicsClientId=self.client):
            key = point[1:5]
            pair = pairs.get(key)
            if pair is None:
                one, other = self.index[point[1], point[3]], self.index[point[2], point[4]]
                pair = pairs[key] = (min(one, other), max(one, other))
            if pair not in met and point[8] < (TOUCH_END if pair in last else TOUCH_BEGIN):
                met.add(pair)
        if met != last:
            self.met = met
        return self.met

    def close(self) -> None:
        """Free the client; there are only 1024."""
        pybullet.disconnect(physicsClientId=self.client)
