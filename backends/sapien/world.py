"""The scene in SAPIEN: what the loop in `wmspec.scene.episode` does, in the words of SAPIEN's PhysX."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np

from wmspec.scene.episode import TOUCH, Vector
from wmspec.scene.rigid import Piece, Rigid
from wmspec.scene.silence import silence
from wmspec.scene.transform import multiply, turning

with silence():
    import sapien

CONTACT_OFFSET = 1e-5  # m: from further off, friction may act before the impact and again in it, phase by phase
FASTEST_SPIN = 1000.0  # rad/s, PhysX's default is 100
ALONG_X = (sqrt(0.5), 0.0, -sqrt(0.5), 0.0)  # PhysX's capsules and cylinders lie along x
BITS = 32
JUMP = 1e-9  # m: what is further from where it was to be has been placed there

Lanes = dict[tuple[Vector, Vector], int]


class World:
    """A scene of its own, with the given bodies in order.

    PhysX averages the materials of a pair where the geometric mean is wanted. So each pair of materials has a lane, a
    bit of the collision groups: on it a piece has a copy of its shape with the lane's material, which meets the
    other material's copies only. One material needs one copy.
    """

    def __init__(self, bodies: tuple[Rigid, ...], gravity: Vector, step: float) -> None:
        sapien.physx.set_scene_config(
            gravity=np.array(gravity, np.float32),
            bounce_threshold=0.01,  # m/s; the default of 2 swallows bounces
            enable_pcm=True,
            enable_tgs=True,
            enable_ccd=False,
            enable_enhanced_determinism=True,
            enable_friction_every_iteration=True,
        )
        self.system = sapien.physx.PhysxCpuSystem()
        self.scene = sapien.Scene([self.system])
        self.scene.set_timestep(step)
        self.step_size, self.bodies = step, bodies
        self.targets: dict[int, Any] = {}
        self.lanes = lanes(bodies)
        self.parts = [self.add(i, body) for i, body in enumerate(bodies)]

    def add(self, number: int, body: Rigid) -> Any:
        """Make a body; its entity's name is its number."""
        physx = sapien.physx
        part = physx.PhysxRigidStaticComponent() if body.motion == "static" else physx.PhysxRigidDynamicComponent()
        for piece in body.pieces:
            for pair, bit in self.lanes.items():
                if piece.material in pair:
                    part.attach(shape(piece, mean(*pair), groups(piece.material, pair, bit)))
        if body.motion == "dynamic":
            solve(part, body)
        if body.motion == "kinematic":
            part.set_kinematic(True)
        entity = sapien.Entity()
        entity.set_name(str(number))
        entity.add_component(part)
        entity.set_pose(pose(body.start))
        self.scene.add_entity(entity)
        return part

    def kick(self, body: int, linear: Any, angular: Any) -> None:
        """Set the velocities of a dynamic body."""
        self.parts[body].set_linear_velocity(np.array(linear, np.float32))
        self.parts[body].set_angular_velocity(np.array(angular, np.float32))

    def drive(self, body: int, pose_: Any, speeds: Any) -> None:
        """Tell a kinematic body where to be after the next step; put it where it's to be before, if it isn't there."""
        here, h = np.asarray(pose_), self.step_size
        if np.abs(self.targets.setdefault(body, here) - here).max() > JUMP:
            self.parts[body].entity.set_pose(pose(here))
        there = [*(here[:3] + speeds[:3] * h), *multiply(turning(speeds[3:] * h), here[3:])]
        self.targets[body] = np.array(there)
        self.parts[body].set_kinematic_target(pose(there))

    def push(self, body: int, force: Any) -> None:
        """Let a force act at the centre of mass of a dynamic body during the next step."""
        self.parts[body].add_force_torque(np.array(force, np.float32), np.zeros(3, np.float32))

    def hold(self, body: int) -> None:
        """Put a dynamic body back where it began, and make it kinematic."""
        self.parts[body].set_kinematic(True)
        self.drive(body, np.array(self.bodies[body].start), np.zeros(6))

    def free(self, body: int) -> None:
        """Let go of what has been held."""
        self.parts[body].set_kinematic(False)

    def step(self) -> None:
        """Advance."""
        self.scene.step()

    def state(self, body: int) -> Any:
        """Position, quaternion, linear and angular velocity of a body in world axes, (13,)."""
        part = self.parts[body]
        place = part.entity_pose
        return np.concatenate([place.p, place.q, part.linear_velocity, part.angular_velocity])

    def touching(self) -> set[tuple[int, int]]:
        """The pairs of bodies less than `TOUCH` apart in the last step."""
        pairs = set()
        for contact in self.system.get_contacts():
            if any(point.separation < TOUCH for point in contact.points):
                first, second = sorted(int(part.entity.name) for part in contact.bodies)
                pairs.add((first, second))
        return pairs


def lanes(bodies: tuple[Rigid, ...]) -> Lanes:
    """A number for every pair of materials of which two pieces may meet, in the order of the bodies."""
    numbers: Lanes = {}
    for i, a in enumerate(bodies):
        for b in bodies[i + 1 :]:
            if "dynamic" in (a.motion, b.motion):
                for pair in [(p.material, q.material) for p in a.pieces for q in b.pieces]:
                    numbers.setdefault(min(pair, pair[::-1]), len(numbers))
    return numbers


def mean(a: Vector, b: Vector) -> list[float]:
    """The geometric mean of two materials, number by number."""
    return [sqrt(x * y) for x, y in zip(a, b, strict=True)]


def groups(material: Vector, pair: tuple[Vector, Vector], bit: int) -> list[int]:
    """Collision groups on a lane: shapes meet if one's first word and the other's second share a bit."""
    return [(1 << bit) * (material == pair[0]), (1 << bit) * (material == pair[1]), 0, 0]


def shape(piece: Piece, material: list[float], groups: list[int]) -> Any:
    """A copy of a piece for one lane."""
    physx, place = sapien.physx, piece.pose
    stuff = physx.PhysxMaterial(*material)
    match piece.kind:
        case "box":
            made = physx.PhysxCollisionShapeBox(np.array(piece.size, np.float32), stuff)
        case "sphere":
            made = physx.PhysxCollisionShapeSphere(piece.size[0], stuff)
        case "hull":
            points = np.reshape(piece.size, (-1, 3)).astype(np.float32)
            made = physx.PhysxCollisionShapeConvexMesh(points, np.ones(3, np.float32), stuff)
        case _:
            kind = {"cylinder": physx.PhysxCollisionShapeCylinder, "capsule": physx.PhysxCollisionShapeCapsule}
            made = kind[piece.kind](piece.size[0], piece.size[1] / 2, stuff)
            place = (*piece.pose[:3], *multiply(np.array(piece.pose[3:]), np.array(ALONG_X)))
    made.set_local_pose(pose(place))
    made.set_collision_groups(groups)
    made.set_contact_offset(CONTACT_OFFSET)
    made.set_rest_offset(0.0)
    return made


def solve(part: Any, body: Rigid) -> None:
    """How a dynamic body is solved: PhysX's defaults damp spin, put bodies to sleep and iterate too little."""
    part.set_mass(body.mass)
    part.set_cmass_local_pose(sapien.Pose())
    part.set_inertia(np.array(body.moments, np.float32))
    part.set_linear_damping(body.damping[0])
    part.set_angular_damping(body.damping[1])
    part.set_sleep_threshold(0.0)
    part.set_solver_position_iterations(50)
    part.set_solver_velocity_iterations(4)
    part.set_max_angular_velocity(FASTEST_SPIN)


def pose(numbers: Any) -> Any:
    """SAPIEN's pose of position and quaternion (w, x, y, z)."""
    return sapien.Pose(np.array(numbers[:3], float), np.array(numbers[3:], float))
