"""The action `reach`: coordinates of disabled joints as paths of the kinematic bodies that they join."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd

from wmspec.sim.scene.model import Array, Body, Follow, Pose
from wmspec.sim.scene.model.transform import from_rotation_vector, inverse, multiply, rotate
from wmspec.sim.usd.frames import StageFrame, quaternion, split_transform
from wmspec.sim.usd.prims import refuse, seconds, targets, value

PATH_RATE = 60
"""Path samples per second, Hz."""
_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
_KINDS = ("PhysicsRevoluteJoint", "PhysicsPrismaticJoint")


@dataclass(frozen=True)
class _Path:
    """Poses of a body over time: positions (n, 3), orientations (n, 4)."""

    points: Array
    turns: Array

    def then(self, inner: Pose) -> _Path:
        """Return the path of a frame of the body."""
        return _Path(self.points + rotate(self.turns, inner.position), multiply(self.turns, inner.orientation))


def joint_paths(prim: Usd.Prim, bodies: Mapping[str, Body], world: StageFrame) -> list[Follow]:
    """Return the paths of the bodies that the joints move; `bodies` by path.

    Raises: StageError: if values do not fit the joints, or a joint is enabled or joins no kinematic body.
    """
    joints = [prim.GetStage().GetPrimAtPath(path) for path in targets(prim, "wms:joints")]
    times, values = _spline(prim, len(joints))
    moves: dict[str, _Path] = {}
    for joint, coordinate in zip(joints, values.T, strict=True):
        if not joint or joint.GetTypeName() not in _KINDS or value(joint, "physics:jointEnabled", True):
            refuse(prim, "its wms:joints are not all disabled hinges and sliders", "target such joints")
        (above,), (below,) = targets(joint, "physics:body0"), targets(joint, "physics:body1")
        if below not in bodies or bodies[below].motion != "kinematic":
            refuse(joint, f"{below} is not a kinematic body, so {prim.GetPath()} cannot move it", "make it kinematic")
        outer = moves.get(above) or _still(prim.GetStage().GetPrimAtPath(above), len(times), world)
        moves[below] = _moved(joint, outer, coordinate)
    start = seconds(prim, "wms:start")
    return [
        Follow(prim.GetName(), bodies[path].name, start, times, ways.points, _near(ways.turns))
        for path, ways in moves.items()
    ]


def _spline(prim: Usd.Prim, joints: int) -> tuple[Array, Array]:
    """Return times (n,), increasing from 0, and coordinates (n, joints)."""
    from scipy.interpolate import CubicSpline

    knots = np.array(value(prim, "wms:times", ()), np.float64)
    values = np.array(value(prim, "wms:values", ()), np.float64)
    if len(knots) < 2 or knots[0] != 0 or not (np.diff(knots) > 0).all() or values.size != joints * len(knots):
        reason = f"it has {joints} wms:joints, {len(knots)} wms:times and {values.size} wms:values"
        refuse(prim, reason, "author 2 or more increasing times from 0, and one value per joint and time")
    if not math.isclose(seconds(prim, "wms:duration"), knots[-1], rel_tol=1e-9):
        refuse(prim, "wms:duration is not the last of wms:times", "author the same number for both")
    times = np.linspace(0.0, knots[-1], max(2, math.ceil(knots[-1] * PATH_RATE) + 1))
    return times, CubicSpline(knots, values.reshape(len(knots), joints), bc_type="clamped")(times)


def _still(prim: Usd.Prim, n: int, world: StageFrame) -> _Path:
    """Return the constant path of a body that no joint moves."""
    pose = split_transform(world.matrix(prim), prim).pose
    return _Path(np.tile(pose.position, (n, 1)), np.tile(pose.orientation, (n, 1)))


def _moved(joint: Usd.Prim, outer: _Path, coordinate: Array) -> _Path:
    """Return the path of the second body of a joint, given that of the first."""
    axis = np.array(_AXES[str(value(joint, "physics:axis", "X"))])
    first, second = _frame(joint, 0), _frame(joint, 1)
    here = outer.then(first)
    way = coordinate[:, None] * axis
    if joint.GetTypeName() == "PhysicsRevoluteJoint":
        there = _Path(here.points, multiply(here.turns, from_rotation_vector(way)))
    else:
        there = _Path(here.points + rotate(here.turns, way), here.turns)
    return there.then(inverse(second))


def _frame(joint: Usd.Prim, number: int) -> Pose:
    """Return the frame of a joint in one of its bodies."""
    place = value(joint, f"physics:localPos{number}", Gf.Vec3f(0))
    turn = value(joint, f"physics:localRot{number}", Gf.Quatf(1))
    return Pose(np.array(place, np.float64), quaternion(Gf.Quatd(turn).GetNormalized()))


def _near(turns: Array) -> Array:
    """Return equal orientations (n, 4) with signs closest to the predecessor."""
    flips = np.where((turns[1:] * turns[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    signs = np.concatenate([[1.0], np.cumprod(flips)])
    return np.asarray(turns * signs[:, None] / np.linalg.norm(turns, axis=1, keepdims=True))
