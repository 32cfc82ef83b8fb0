"""Our action `reach`: the coordinates of disabled joints, as the ways of the kinematic bodies that they join."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd

from wmspec.sim.scene.model import Array, Body, Follow, Pose
from wmspec.sim.scene.model.transform import inverse, multiply, rotate, turning
from wmspec.sim.usd.frames import World, quaternion, split
from wmspec.sim.usd.prims import refuse, seconds, targets, value

RATE = 60
"""How many places of a body are computed for a second of its way, Hz."""
_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
_KINDS = ("PhysicsRevoluteJoint", "PhysicsPrismaticJoint")


@dataclass(frozen=True)
class _Ways:
    """Where a body is at all the times: positions (n, 3), orientations (n, 4)."""

    points: Array
    turns: Array

    def then(self, inner: Pose) -> _Ways:
        """A frame of the body."""
        return _Ways(self.points + rotate(self.turns, inner.position), multiply(self.turns, inner.orientation))


def follows(prim: Usd.Prim, bodies: Mapping[str, Body], world: World) -> list[Follow]:
    """The ways of the bodies that the joints move, `bodies` by their paths.

    Raises:
        StageError: if the values do not fit the joints, or a joint holds no kinematic body, or is enabled.
    """
    joints = [prim.GetStage().GetPrimAtPath(path) for path in targets(prim, "wms:joints")]
    times, values = _spline(prim, len(joints))
    moves: dict[str, _Ways] = {}
    for joint, coordinate in zip(joints, values.T, strict=True):
        if not joint or joint.GetTypeName() not in _KINDS or value(joint, "physics:jointEnabled", True):
            refuse(prim, "its wms:joints are not all disabled hinges and sliders", "target such joints")
        (above,), (below,) = targets(joint, "physics:body0"), targets(joint, "physics:body1")
        if below not in bodies or bodies[below].motion != "kinematic":
            refuse(joint, f"{below} is no kinematic body, so {prim.GetPath()} cannot move it", "make it kinematic")
        outer = moves.get(above) or _still(prim.GetStage().GetPrimAtPath(above), len(times), world)
        moves[below] = _moved(joint, outer, coordinate)
    start = seconds(prim, "wms:start")
    return [
        Follow(prim.GetName(), bodies[path].name, start, times, ways.points, _near(ways.turns))
        for path, ways in moves.items()
    ]


def _spline(prim: Usd.Prim, joints: int) -> tuple[Array, Array]:
    """Times (n,) that grow from 0, and the coordinates (n, joints) then."""
    from scipy.interpolate import CubicSpline

    knots = np.array(value(prim, "wms:times", ()), np.float64)
    values = np.array(value(prim, "wms:values", ()), np.float64)
    if len(knots) < 2 or knots[0] != 0 or not (np.diff(knots) > 0).all() or values.size != joints * len(knots):
        reason = f"it has {joints} wms:joints, {len(knots)} wms:times and {values.size} wms:values"
        refuse(prim, reason, "author 2 or more times that grow from 0, and a value of each joint for each of them")
    if not math.isclose(seconds(prim, "wms:duration"), knots[-1], rel_tol=1e-9):
        refuse(prim, "wms:duration is not the last of wms:times", "author the same number for both")
    times = np.linspace(0.0, knots[-1], max(2, math.ceil(knots[-1] * RATE) + 1))
    return times, CubicSpline(knots, values.reshape(len(knots), joints), bc_type="clamped")(times)


def _still(prim: Usd.Prim, n: int, world: World) -> _Ways:
    """What no joint moves stays where it is."""
    pose = split(world.matrix(prim), prim).pose
    return _Ways(np.tile(pose.position, (n, 1)), np.tile(pose.orientation, (n, 1)))


def _moved(joint: Usd.Prim, outer: _Ways, coordinate: Array) -> _Ways:
    """Where a joint takes its second body, for where its first is."""
    axis = np.array(_AXES[str(value(joint, "physics:axis", "X"))])
    first, second = _frame(joint, 0), _frame(joint, 1)
    here = outer.then(first)
    way = coordinate[:, None] * axis
    if joint.GetTypeName() == "PhysicsRevoluteJoint":
        there = _Ways(here.points, multiply(here.turns, turning(way)))
    else:
        there = _Ways(here.points + rotate(here.turns, way), here.turns)
    return there.then(inverse(second))


def _frame(joint: Usd.Prim, number: int) -> Pose:
    """The frame of a joint in one of its bodies."""
    place = value(joint, f"physics:localPos{number}", Gf.Vec3f(0))
    turn = value(joint, f"physics:localRot{number}", Gf.Quatf(1))
    return Pose(np.array(place, np.float64), quaternion(Gf.Quatd(turn).GetNormalized()))


def _near(turns: Array) -> Array:
    """The same orientations (n, 4), each with the sign that is nearest to the one before."""
    flips = np.where((turns[1:] * turns[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    signs = np.concatenate([[1.0], np.cumprod(flips)])
    return np.asarray(turns * signs[:, None] / np.linalg.norm(turns, axis=1, keepdims=True))
