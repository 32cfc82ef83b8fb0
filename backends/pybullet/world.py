"""The scene in PyBullet: what the loop in `wmspec.scene.episode` does, in PyBullet's words."""

from __future__ import annotations

from math import exp, sqrt
from typing import Any

import numpy as np

from wmspec.scene.episode import TOUCH, Vector
from wmspec.scene.rigid import Piece, Rigid
from wmspec.scene.silence import silence

with silence():
    import pybullet

HEAVY_MASS, HEAVY_INERTIA = 1e4, 1e6  # kg, kg m²: a body that nothing in the scene can push
DYNAMIC, GIVEN = 1, 2  # collision groups: bodies whose motion is given pass through each other

ROUND = ("sphere", "capsule")  # their margin is their radius
HERE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
KINDS = {
    "box": "GEOM_BOX",
    "sphere": "GEOM_SPHERE",
    "cylinder": "GEOM_CYLINDER",
    "capsule": "GEOM_CAPSULE",
    "hull": "GEOM_MESH",
}


class World:
    """A client of its own, with the scene's bodies in order. Close it when done."""

    def __init__(self, bodies: tuple[Rigid, ...], gravity: Vector, step: float) -> None:
        self.client = pybullet.connect(pybullet.DIRECT)
        self.bodies, self.gravity = bodies, np.array(gravity)
        pybullet.setGravity(*gravity, physicsClientId=self.client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=step,
            numSubSteps=0,
            numSolverIterations=100,
            solverResidualThreshold=0.0,
            useSplitImpulse=1,
            splitImpulsePenetrationThreshold=0.0,
            restitutionVelocityThreshold=0.0,
            erp=0.2,
            contactERP=0.2,
            enableConeFriction=1,
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        self.index: dict[int, int] = {}
        self.held: set[int] = set()
        self.ids = [self.add(i, body) for i, body in enumerate(bodies)]

    def add(self, number: int, body: Rigid) -> int:
        """Make a body; a static one is made of one per piece, as only there PyBullet lets pieces differ in material."""
        wholes = [(piece,) for piece in body.pieces] if body.motion == "static" else [body.pieces]
        ids = [self.make(body, pieces) for pieces in wholes]
        self.index |= dict.fromkeys(ids, number)
        return ids[0] if ids else -1

    def make(self, body: Rigid, pieces: tuple[Piece, ...]) -> int:
        """One body of PyBullet's; a kinematic one is a heavy free body whose state is set before every step."""
        heavy = body.motion == "kinematic"
        mass = HEAVY_MASS if heavy else body.mass
        place, shape = [body.start[:3], xyzw(body.start[3:])], self.shape(pieces)
        handle: int = pybullet.createMultiBody(
            mass, shape, -1, *place, useMaximalCoordinates=1, physicsClientId=self.client
        )
        settings: dict[str, Any] = {
            "rollingFriction": 0.0,
            "spinningFriction": 0.0,
            "linearDamping": 1 - exp(-body.damping[0]),  # PyBullet's is the part lost in a second
            "angularDamping": 1 - exp(-body.damping[1]),
            "contactProcessingThreshold": 0.0,  # with the default, restitution gets worse as the step shrinks
            "activationState": pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
        }
        if pieces:  # PyBullet multiplies the materials of a pair: the roots make that the geometric mean
            settings |= {"lateralFriction": sqrt(pieces[0].material[1]), "restitution": sqrt(pieces[0].material[2])}
        if pieces and pieces[0].kind not in ROUND:
            settings |= {"collisionMargin": 0.0}
        if mass:  # either of the two alone sets the other to zero
            settings |= {"mass": mass, "localInertiaDiagonal": [HEAVY_INERTIA] * 3 if heavy else body.moments}
        pybullet.changeDynamics(handle, -1, physicsClientId=self.client, **settings)
        group, mask = (DYNAMIC, DYNAMIC | GIVEN) if body.motion == "dynamic" else (GIVEN, DYNAMIC)
        pybullet.setCollisionFilterGroupMask(handle, -1, group, mask, physicsClientId=self.client)
        return handle

    def shape(self, pieces: tuple[Piece, ...]) -> int:
        """The collision shape of some pieces, -1 for none. Only a single piece may be a hull."""
        if not pieces:
            return -1
        one: int
        if len(pieces) == 1:
            one = pybullet.createCollisionShape(physicsClientId=self.client, **single(pieces[0]))
        else:
            one = pybullet.createCollisionShapeArray(physicsClientId=self.client, **several(pieces))
        return one

    def kick(self, body: int, linear: Any, angular: Any) -> None:
        """Set the velocities of a dynamic body."""
        pybullet.resetBaseVelocity(self.ids[body], list(linear), list(angular), physicsClientId=self.client)

    def drive(self, body: int, pose: Any, speeds: Any) -> None:
        """Put a kinematic body back on its path, undoing whatever pushed it, and hold it against gravity."""
        handle, place = self.ids[body], list(pose[:3])
        pybullet.resetBasePositionAndOrientation(handle, place, xyzw(pose[3:]), physicsClientId=self.client)
        pybullet.resetBaseVelocity(handle, list(speeds[:3]), list(speeds[3:]), physicsClientId=self.client)
        self.push(body, -HEAVY_MASS * self.gravity)

    def push(self, body: int, force: Any) -> None:
        """Let a force act at the centre of mass of a body during the next step."""
        handle, here = self.ids[body], self.state(body)[:3]
        pybullet.applyExternalForce(handle, -1, list(force), here, pybullet.WORLD_FRAME, physicsClientId=self.client)

    def hold(self, body: int) -> None:
        """Put a dynamic body back where it began, as heavy as a kinematic one."""
        if body not in self.held:
            self.held.add(body)
            self.weigh(body, HEAVY_MASS, [HEAVY_INERTIA] * 3)
        start = self.bodies[body].start
        self.drive(body, start, (0.0,) * 6)

    def free(self, body: int) -> None:
        """Let go of what has been held."""
        self.held.remove(body)
        self.weigh(body, self.bodies[body].mass, self.bodies[body].moments)

    def weigh(self, body: int, mass: float, moments: Any) -> None:
        """Set the mass and the moments of inertia."""
        pybullet.changeDynamics(
            self.ids[body], -1, mass=mass, localInertiaDiagonal=moments, physicsClientId=self.client
        )

    def step(self) -> None:
        """Advance."""
        pybullet.stepSimulation(physicsClientId=self.client)

    def state(self, body: int) -> Any:
        """Position, quaternion, linear and angular velocity of a body in world axes, (13,)."""
        position, turn = pybullet.getBasePositionAndOrientation(self.ids[body], physicsClientId=self.client)
        linear, angular = pybullet.getBaseVelocity(self.ids[body], physicsClientId=self.client)
        return [*position, turn[3], *turn[:3], *linear, *angular]

    def touching(self) -> set[tuple[int, int]]:
        """The pairs of bodies less than `TOUCH` apart after the last step."""
        points = pybullet.getContactPoints(physicsClientId=self.client)
        pairs = {(self.index[point[1]], self.index[point[2]]) for point in points if point[8] < TOUCH}
        return {(min(pair), max(pair)) for pair in pairs}

    def close(self) -> None:
        """Free the client; there are only 1024 of them."""
        pybullet.disconnect(physicsClientId=self.client)


def xyzw(turn: Any) -> Vector:
    """PyBullet's order of a quaternion (w, x, y, z)."""
    return (*turn[1:], turn[0])


def single(piece: Piece) -> dict[str, Any]:
    """A piece in the words of `createCollisionShape`."""
    words: dict[str, Any] = {"shapeType": getattr(pybullet, KINDS[piece.kind])}
    match piece.kind:
        case "box":
            words |= {"halfExtents": piece.size}
        case "sphere":
            words |= {"radius": piece.size[0]}
        case "hull":
            return words | {"vertices": np.reshape(piece.size, (-1, 3)).tolist()}
        case _:
            words |= {"radius": piece.size[0], "height": piece.size[1]}
    if piece.pose == HERE:  # an offset, even of zero, would make it a compound shape
        return words
    return words | {"collisionFramePosition": piece.pose[:3], "collisionFrameOrientation": xyzw(piece.pose[3:])}


def several(pieces: tuple[Piece, ...]) -> dict[str, Any]:
    """Pieces in the words of `createCollisionShapeArray`, which has no hulls."""
    return {
        "shapeTypes": [getattr(pybullet, KINDS[piece.kind]) for piece in pieces],
        "halfExtents": [piece.size if piece.kind == "box" else (0.0, 0.0, 0.0) for piece in pieces],
        "radii": [0.0 if piece.kind == "box" else piece.size[0] for piece in pieces],
        "lengths": [piece.size[1] if piece.kind in ("cylinder", "capsule") else 0.0 for piece in pieces],
        "collisionFramePositions": [piece.pose[:3] for piece in pieces],
        "collisionFrameOrientations": [xyzw(piece.pose[3:]) for piece in pieces],
    }
