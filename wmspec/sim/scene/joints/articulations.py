"""Jointed bodies as trees. Every engine solves trees in joint coordinates, which keeps joints exact at any step size.

Native scripts contain a copy of `Link`; its `repr` is valid Python.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import atan2, pi

import numpy as np

from wmspec.core.diagnostics import StageError
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.com_frame import body_frame_in_com, com_frame
from wmspec.sim.scene.model import Array, Body, Follow, Glide, Joint, Pose, Scene, Teleport
from wmspec.sim.scene.model.numbers import floats, pose_numbers
from wmspec.sim.scene.model.transform import (
    apply,
    compose,
    conjugate,
    cross,
    identity,
    inverse,
    rotate,
    to_rotation_vector,
)

WORLD = -1
MAX_FRAME_GAP, MAX_FRAME_ANGLE = 1e-3, 1e-2  # m and rad: largest initial error of a joint
_HALF_TURN_Z = Pose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))  # 180° about z reverses x


@dataclass(frozen=True)
class Link:
    """A body of a tree and its joint to `parent`, a body number or -1 for the world.

    `kind` is free (a floating root), fixed, hinge, slider or ball; `joint` is the number of the joint, -1 if free.
    `above` and `below` are the joint frame, position and quaternion (w, x, y, z), in the centre-of-mass frames of
    parent (or world) and body; the joint axis is x. `start`: initial coordinate. `limits`: lowest and highest
    coordinate, or empty. `drive`: stiffness, damping, target, velocity, maximum force, or empty. `rate`: initial
    velocity of the coordinate, rad/s or m/s; of a ball joint, about the three axes of the body; or empty. `armature`:
    inertia that the coordinate has beside that of the bodies, kg m² or kg.
    """

    body: int
    parent: int
    joint: int
    kind: str
    above: tuple[float, ...]
    below: tuple[float, ...]
    start: float
    limits: tuple[float, ...]
    drive: tuple[float, ...]
    rate: tuple[float, ...] = ()
    armature: float = 0.0


Tree = tuple[Link, ...]


@dataclass(frozen=True)
class LoopClosure:
    """A joint that closes a loop: points of body `first` (-1 for the world) coincide with points of `second`.

    `above` and `below` are the points (m) in the centre-of-mass frames, one or more.
    """

    joint: int
    first: int
    second: int
    above: tuple[tuple[float, ...], ...]
    below: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class MimicConstraint:
    """A joint that mimics another: coordinate of `body` = `ratio` * coordinate of `leader` + `offset`.

    `lightness` is the acceleration per unit of force between the two, 1/kg.
    """

    joint: int
    body: int
    leader: int
    ratio: float
    offset: float
    lightness: float


@dataclass(frozen=True)
class Branch:
    """A body of a tree with the numbers of its parent and joint; -1 for the world and for no joint."""

    body: int
    parent: int
    joint: int


def trees(scene: Scene) -> tuple[Tree, ...]:
    """Return the jointed bodies as trees, parents before children, ordered by root.

    The root is the body that is jointed to the world (several if joints mimic each other), or else the first body.
    Raises StageError with the path of a joint whose frames do not fit.
    """
    return _merged_by_mimics(scene, [tuple(_link(scene, branch) for branch in tree) for tree in spanning_trees(scene)])


def _merged_by_mimics(scene: Scene, grown: list[Tree]) -> tuple[Tree, ...]:
    """Merge trees at the world if a joint of one mimics a joint of the other."""
    named = {joint.name: number for number, joint in enumerate(scene.joints)}
    for number, joint in enumerate(scene.joints):
        if joint.mimic is None or joint.mimic.leader not in named:
            continue
        both = [tree for tree in grown if {number, named[joint.mimic.leader]} & {link.joint for link in tree}]
        if len(both) == 2 and all(tree[0].kind != "free" for tree in both):
            grown[grown.index(both[0])] = both[0] + both[1]
            grown.remove(both[1])
    return tuple(grown)


def spanning_trees(scene: Scene) -> tuple[tuple[Branch, ...], ...]:
    """Return the spanning trees of the joint graph; `loop_joints` returns the remaining joints."""
    links = _links(scene)
    kept = _tree_joints(scene, links)
    seen: set[int] = set()
    grown = [tuple(_grow(root, links, kept, seen)) for root in _roots(links) if root not in seen]
    return tuple(sorted(grown, key=lambda tree: tree[0].body))


def loop_joints(scene: Scene) -> tuple[int, ...]:
    """Return the numbers of joints that close loops or attach bodies to the world a second time."""
    return tuple(sorted(set(range(len(scene.joints))) - _tree_joints(scene, _links(scene))))


def loop_closures(scene: Scene) -> tuple[LoopClosure, ...]:
    """Return the loop closures. Raises StageError if no joint of a loop can close it, or if it does not fit."""
    return tuple(_tie(scene, j) for j in loop_joints(scene))


def mimic_joint_names(scene: Scene) -> frozenset[str]:
    """Return the names of joints that mimic or are mimicked."""
    return frozenset(name for j in scene.joints if j.mimic for name in (j.name, j.mimic.leader))


def ancestors(body: int, above: Mapping[int, int]) -> list[int]:
    """Return a body, its parent, and so on up to the root."""
    way = [body]
    while way[-1] in above:
        way.append(above[way[-1]])
    return way


def subtree(tree: Sequence[Link | Branch], body: int) -> set[int]:
    """Return the numbers of a body and of those below it, given a tree with parents before children."""
    found = {body}
    for branch in tree:
        if branch.parent in found:
            found.add(branch.body)
    return found


_SPREAD = 0.1  # m: spacing of the points of a hinge or fixed joint that closes a loop
_POINTS = {
    "ball": ((0.0, 0.0, 0.0),),
    "hinge": ((-_SPREAD, 0.0, 0.0), (_SPREAD, 0.0, 0.0)),
    "fixed": ((-_SPREAD, 0.0, 0.0), (_SPREAD, 0.0, 0.0), (0.0, _SPREAD, 0.0)),
}


def _tie(scene: Scene, number: int) -> LoopClosure:
    joint = scene.joints[number]
    if not can_close_loop(joint, mimic_joint_names(scene)):
        reason = "it closes a loop of joints or attaches bodies to the world a second time"
        remedy = "close the loop with a fixed, revolute or spherical joint without limits and drive, or deactivate it"
        raise StageError(reason, PrimPlace(joint.path), remedy)
    bodies = {body.name: body for body in scene.bodies}
    joint_coordinate(joint, relative_frame(bodies, joint.first, joint.second, joint.first_frame, joint.second_frame))
    (first, above), (second, below) = (
        _points(scene, name, frame, joint.kind)
        for name, frame in ((joint.first, joint.first_frame), (joint.second, joint.second_frame))
    )
    return LoopClosure(number, first, second, above, below)


def _points(scene: Scene, name: str | None, frame: Pose, kind: str) -> tuple[int, tuple[tuple[float, ...], ...]]:
    """Return the number of a body and points of a joint in its centre-of-mass frame, or in the world if static."""
    body = next((i for i, body in enumerate(scene.bodies) if body.name == name), WORLD)
    at = frame
    if body != WORLD:
        still = scene.bodies[body].motion != "dynamic"
        at = compose(scene.bodies[body].pose if still else body_frame_in_com(scene.bodies[body]), frame)
        body = WORLD if still else body
    return body, tuple(floats(apply(at, np.array(point))) for point in _POINTS[kind])


def can_close_loop(joint: Joint, coupled: frozenset[str]) -> bool:
    """Whether coinciding points replace the joint: it has no drive, limits or armature, and no mimic joint, whose names
    are `coupled`.
    """
    plain = joint.drive is None and joint.limits is None and not joint.armature and joint.name not in coupled
    return joint.kind in _POINTS and plain


def _links(scene: Scene) -> list[tuple[int, int]]:
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    return [_ends(joint, scene.bodies, index) for joint in scene.joints]


def _tree_joints(scene: Scene, links: Sequence[tuple[int, int]]) -> frozenset[int]:
    """Return the joints of the trees: all but one joint of each loop, preferably one that points can replace."""
    above = {end: end for ends in links for end in ends}

    def top(end: int) -> int:
        while above[end] != end:
            end = above[end]
        return end

    kept, coupled = set(), mimic_joint_names(scene)
    for j in sorted(range(len(links)), key=lambda j: (can_close_loop(scene.joints[j], coupled), j)):
        first, second = map(top, links[j])
        if first != second:
            above[first] = second
            kept.add(j)
    return frozenset(kept)


def jointed_bodies(scene: Scene) -> frozenset[str]:
    """Return the names of the dynamic bodies with joints."""
    return frozenset(
        name for j in scene.joints for name in (j.first, j.second) if name and _dynamic(scene.bodies, name)
    )


def moving_kinematic_bodies(scene: Scene) -> frozenset[str]:
    """Return the names of the kinematic bodies that move."""
    moved = (a.body for a in scene.actions if isinstance(a, Glide | Follow | Teleport))
    return frozenset(name for name in moved if not _dynamic(scene.bodies, name))


def _dynamic(bodies: Sequence[Body], name: str) -> bool:
    return any(body.name == name and body.motion == "dynamic" for body in bodies)


def _ends(joint: Joint, bodies: Sequence[Body], index: Mapping[str, int]) -> tuple[int, int]:
    """Return the numbers of the two bodies; non-dynamic bodies count as the world."""
    first = WORLD if joint.first is None or not _dynamic(bodies, joint.first) else index[joint.first]
    return first, index[joint.second] if _dynamic(bodies, joint.second) else WORLD


def _roots(links: Sequence[tuple[int, int]]) -> list[int]:
    """Return candidates for roots: bodies jointed to the world first, then all others."""
    anchored = [max(ends) for ends in links if WORLD in ends]
    return [*anchored, *sorted({body for ends in links for body in ends} - {WORLD})]


def _grow(root: int, links: Sequence[tuple[int, int]], kept: frozenset[int], seen: set[int]) -> Iterator[Branch]:
    seen.add(root)
    yield Branch(root, WORLD, next((j for j in sorted(kept) if set(links[j]) == {WORLD, root}), -1))
    waiting = [root]
    while waiting:
        parent = waiting.pop(0)
        for j in sorted(kept):
            if parent not in links[j]:
                continue
            child = links[j][0] if links[j][1] == parent else links[j][1]
            if child != WORLD and child not in seen:
                seen.add(child)
                waiting.append(child)
                yield Branch(child, parent, j)


def _link(scene: Scene, branch: Branch) -> Link:
    number, parent, child = branch.joint, branch.parent, branch.body
    if number < 0:
        return Link(child, WORLD, -1, "free", pose_numbers(identity()), pose_numbers(identity()), 0.0, (), ())
    joint = scene.joints[number]
    below_first = scene.bodies[child].name != joint.second
    above, below = joint.first_frame, joint.second_frame
    upper, lower = joint.first, joint.second
    if below_first:  # reverse the axis with the bodies, so that the coordinate keeps its sign
        upper, lower = lower, str(joint.first)
        above, below = compose(joint.second_frame, _HALF_TURN_Z), compose(joint.first_frame, _HALF_TURN_Z)
    bodies = {body.name: body for body in scene.bodies}
    between = relative_frame(bodies, upper, lower, above, below)
    start = joint_coordinate(joint, between)
    if joint.kind == "ball" and joint.limits is None:  # any two frames are valid: choose equal ones at the start
        below = Pose(below.position, compose(below, inverse(between)).orientation)
    if upper is not None:
        above = compose(bodies[upper].pose if parent == WORLD else body_frame_in_com(bodies[upper]), above)
    drive = joint.drive
    return Link(
        body=child,
        parent=parent,
        joint=number,
        kind=joint.kind,
        above=pose_numbers(above),
        below=pose_numbers(compose(body_frame_in_com(bodies[lower]), below)),
        start=start,
        limits=tuple(map(float, joint.limits or ())),
        drive=floats(np.array([drive.stiffness, drive.damping, drive.target, drive.velocity, drive.max_force]))
        if drive
        else (),
        rate=_rate(joint.kind, bodies, upper, lower, below),
        armature=float(joint.armature),
    )


def _rate(kind: str, bodies: Mapping[str, Body], upper: str | None, lower: str, below: Pose) -> tuple[float, ...]:
    """Return the initial joint velocity from the velocities of its two bodies, which are assumed to fit."""
    here, there = bodies[lower], bodies[upper] if upper is not None else None
    ends = [body for body in (here, there) if body is not None]
    if kind == "fixed" or not any(body.linear_velocity.any() or body.angular_velocity.any() for body in ends):
        return ()
    frame = compose(here.pose, below)
    spin, speed = here.angular_velocity, _speed(here, frame.position)
    if there is not None:
        spin, speed = spin - there.angular_velocity, speed - _speed(there, frame.position)
    if kind == "ball":
        return floats(rotate(conjugate(com_frame(here).pose.orientation), spin))
    return floats(rotate(conjugate(frame.orientation), speed if kind == "slider" else spin)[:1])


def _speed(body: Body, point: Array) -> Array:
    """Return the velocity (3,) of a world point that moves with a body."""
    middle = com_frame(body).pose.position
    return body.linear_velocity + cross(body.angular_velocity, point - middle)


def relative_frame(bodies: Mapping[str, Body], upper: str | None, lower: str, above: Pose, below: Pose) -> Pose:
    """Return the initial pose of the lower joint frame in the upper one."""
    outer = compose(bodies[upper].pose, above) if upper is not None else above
    return compose(inverse(outer), compose(bodies[lower].pose, below))


def joint_coordinate(joint: Joint, between: Pose) -> float:
    """Return the coordinate of a joint whose second frame is at `between` in the first.

    Raises StageError if the frames do not fit.
    """
    gap, turn = between.position.copy(), to_rotation_vector(between.orientation)
    start = 0.0
    match joint.kind:
        case "slider":
            start, gap[0] = float(gap[0]), 0.0
        case "hinge":
            q = between.orientation
            start = _within(2 * atan2(q[1], q[0]), joint.limits)
            turn = np.array([0.0, 2 * q[2], 2 * q[3]])
        case "ball":
            turn = np.zeros(3)
        case "fixed":
            pass
    if np.abs(gap).max() > MAX_FRAME_GAP or np.abs(turn).max() > MAX_FRAME_ANGLE:
        reason = (
            f"its two frames are {np.linalg.norm(gap):.3g} m apart or rotated by "
            f"{np.linalg.norm(turn):.3g} rad at the start"
        )
        raise StageError(reason, PrimPlace(joint.path), "move the bodies to satisfy the joint")
    if (
        joint.limits
        and joint.kind != "ball"
        and not joint.limits[0] - MAX_FRAME_ANGLE < start < joint.limits[1] + MAX_FRAME_ANGLE
    ):
        reason = f"it starts at {start:.4g}, outside its limits {joint.limits}"
        raise StageError(reason, PrimPlace(joint.path), "put it inside")
    return start


def _within(angle: float, limits: tuple[float, float] | None) -> float:
    """Return the angle plus the multiple of 2π that brings it within the limits, if any does."""
    low, high = limits or (-pi, pi)
    options = [angle + 2 * pi * k for k in (0, -1, 1, -2, 2)]
    return next(
        (a for a in options if low - MAX_FRAME_ANGLE <= a <= high + MAX_FRAME_ANGLE), (angle + pi) % (2 * pi) - pi
    )
