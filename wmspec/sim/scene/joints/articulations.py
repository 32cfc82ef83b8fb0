"""Jointed bodies as trees, which every engine solves in joint coordinates: exactly held together, whatever the step.

The native scripts contain `Link` as it stands here, and the `repr` of one is the Python text of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import atan2, pi

import numpy as np

from wmspec.core.diagnostics import StageError
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.com_frame import com_frame, mount
from wmspec.sim.scene.model import Array, Body, Follow, Glide, Joint, Pose, Scene, Teleport
from wmspec.sim.scene.model.numbers import floats, numbers
from wmspec.sim.scene.model.transform import apply, compose, conjugate, cross, identity, inverse, rotate, turned

WORLD = -1
NEAR, ALIGNED = 1e-3, 1e-2  # m and rad: how well the two frames of a joint must fit at the start
_OVER = Pose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))  # half a turn about z: x backwards


@dataclass(frozen=True)
class Link:
    """A body of a tree and what holds it to its `parent`, a body's number or -1 for the world.

    `kind` is free (a root that floats), fixed, hinge, slider or ball; `joint` is the joint's number, -1 if free.
    `above` and `below`: the joint's frame, position and quaternion (w, x, y, z), in the parent (or the world) and in
    the body, in their centre-of-mass frames; its axis is x. `start`: the coordinate at the start. `limits`: least and
    greatest coordinate, or nothing. `drive`: stiffness, damping, target, velocity, greatest force, or nothing.
    `rate`: of the coordinate at the start, rad/s or m/s; of a ball joint, about the three axes of the body; or nothing.
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


Tree = tuple[Link, ...]


@dataclass(frozen=True)
class Tie:
    """A joint that closes a loop of two bodies' trees: points of `first`, a body's number or -1 for the world, that
    stay where those of `second` are. `above` and `below`: the points (m) in their centre-of-mass frames, one or more.
    """

    joint: int
    first: int
    second: int
    above: tuple[tuple[float, ...], ...]
    below: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Gear:
    """A joint that mimics another: the coordinate of what holds `body` is `ratio` times that of what holds `leader`,
    numbers of bodies, and `offset`. `lightness`: the acceleration that a unit of force between the two gives, 1/kg.
    """

    joint: int
    body: int
    leader: int
    ratio: float
    offset: float
    lightness: float


@dataclass(frozen=True)
class Branch:
    """A body of a tree, its parent and the joint between them by their numbers; -1 for the world and for no joint."""

    body: int
    parent: int
    joint: int


def trees(scene: Scene) -> tuple[Tree, ...]:
    """The jointed bodies, parents before children, in the order of each tree's root among the bodies.

    A tree's root is what is jointed to the world, of which it may have several if joints mimic each other, or else its
    first body. Raises StageError, with the joint's path, for joints that do not fit.
    """
    return _joined(scene, [tuple(_link(scene, branch) for branch in tree) for tree in spanning(scene)])


def _joined(scene: Scene, grown: list[Tree]) -> tuple[Tree, ...]:
    """The trees, those that the world holds as one if a joint of one mimics a joint of the other."""
    named = {joint.name: number for number, joint in enumerate(scene.joints)}
    for number, joint in enumerate(scene.joints):
        if joint.mimic is None or joint.mimic.leader not in named:
            continue
        both = [tree for tree in grown if {number, named[joint.mimic.leader]} & {link.joint for link in tree}]
        if len(both) == 2 and all(tree[0].kind != "free" for tree in both):
            grown[grown.index(both[0])] = both[0] + both[1]
            grown.remove(both[1])
    return tuple(grown)


def spanning(scene: Scene) -> tuple[tuple[Branch, ...], ...]:
    """How the bodies hang together in trees; which joints close loops of them, `closing` says."""
    links = _links(scene)
    kept = _kept(scene, links)
    seen: set[int] = set()
    grown = [tuple(_grow(root, links, kept, seen)) for root in _roots(links) if root not in seen]
    return tuple(sorted(grown, key=lambda tree: tree[0].body))


def closing(scene: Scene) -> tuple[int, ...]:
    """The numbers of the joints that close loops, or hold bodies to the world a second time."""
    return tuple(sorted(set(range(len(scene.joints))) - _kept(scene, _links(scene))))


def ties(scene: Scene) -> tuple[Tie, ...]:
    """The loops, closed. Raises StageError where one has no joint that could close it, or where it does not fit."""
    return tuple(_tie(scene, j) for j in closing(scene))


def paired(scene: Scene) -> frozenset[str]:
    """The names of the joints that mimic others, or are mimicked."""
    return frozenset(name for j in scene.joints if j.mimic for name in (j.name, j.mimic.leader))


def ascent(body: int, above: Mapping[int, int]) -> list[int]:
    """A body, what holds it, what holds that, and so on to what is not held."""
    way = [body]
    while way[-1] in above:
        way.append(above[way[-1]])
    return way


_SPREAD = 0.1  # m: how far apart the points of a hinge or a fixed joint are that closes a loop
_POINTS = {
    "ball": ((0.0, 0.0, 0.0),),
    "hinge": ((-_SPREAD, 0.0, 0.0), (_SPREAD, 0.0, 0.0)),
    "fixed": ((-_SPREAD, 0.0, 0.0), (_SPREAD, 0.0, 0.0), (0.0, _SPREAD, 0.0)),
}


def _tie(scene: Scene, number: int) -> Tie:
    joint = scene.joints[number]
    if not closes(joint, paired(scene)):
        reason = "it closes a loop of joints, or holds bodies to the world a second time"
        remedy = "close the loop by a fixed, revolute or spherical joint without limits and drive, or deactivate it"
        raise StageError(reason, PrimPlace(joint.path), remedy)
    bodies = {body.name: body for body in scene.bodies}
    coordinate(joint, relative(bodies, joint.first, joint.second, joint.first_frame, joint.second_frame))
    (first, above), (second, below) = (
        _points(scene, name, frame, joint.kind)
        for name, frame in ((joint.first, joint.first_frame), (joint.second, joint.second_frame))
    )
    return Tie(number, first, second, above, below)


def _points(scene: Scene, name: str | None, frame: Pose, kind: str) -> tuple[int, tuple[tuple[float, ...], ...]]:
    """A body's number and points of a joint in its centre-of-mass frame; of what stands still, in the world."""
    body = next((i for i, body in enumerate(scene.bodies) if body.name == name), WORLD)
    at = frame
    if body != WORLD:
        still = scene.bodies[body].motion != "dynamic"
        at = compose(scene.bodies[body].pose if still else mount(scene.bodies[body]), frame)
        body = WORLD if still else body
    return body, tuple(floats(apply(at, np.array(point))) for point in _POINTS[kind])


def closes(joint: Joint, coupled: frozenset[str]) -> bool:
    """Whether points that stay together do what the joint does, which may be one of those `coupled` with others."""
    plain = joint.drive is None and joint.limits is None and joint.name not in coupled
    return joint.kind in _POINTS and plain


def _links(scene: Scene) -> list[tuple[int, int]]:
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    return [_ends(joint, scene.bodies, index) for joint in scene.joints]


def _kept(scene: Scene, links: Sequence[tuple[int, int]]) -> frozenset[int]:
    """The joints that make trees: of each loop all but one, which is one that points can stand for, if there is one."""
    above = {end: end for ends in links for end in ends}

    def top(end: int) -> int:
        while above[end] != end:
            end = above[end]
        return end

    kept, coupled = set(), paired(scene)
    for j in sorted(range(len(links)), key=lambda j: (closes(scene.joints[j], coupled), j)):
        first, second = map(top, links[j])
        if first != second:
            above[first] = second
            kept.add(j)
    return frozenset(kept)


def jointed(scene: Scene) -> frozenset[str]:
    """The names of the bodies that have joints."""
    return frozenset(
        name for j in scene.joints for name in (j.first, j.second) if name and _dynamic(scene.bodies, name)
    )


def moves(scene: Scene) -> frozenset[str]:
    """The names of the kinematic bodies that do not stand still."""
    return frozenset(a.body for a in scene.actions if isinstance(a, Glide | Follow | Teleport))


def _dynamic(bodies: Sequence[Body], name: str) -> bool:
    return any(body.name == name and body.motion == "dynamic" for body in bodies)


def _ends(joint: Joint, bodies: Sequence[Body], index: Mapping[str, int]) -> tuple[int, int]:
    """The numbers of the two bodies; what stands still is the world."""
    first = WORLD if joint.first is None or not _dynamic(bodies, joint.first) else index[joint.first]
    return first, index[joint.second] if _dynamic(bodies, joint.second) else WORLD


def _roots(links: Sequence[tuple[int, int]]) -> list[int]:
    """Where trees may begin: at what is jointed to the world, then anywhere."""
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
        return Link(child, WORLD, -1, "free", numbers(identity()), numbers(identity()), 0.0, (), ())
    joint = scene.joints[number]
    below_first = scene.bodies[child].name != joint.second
    above, below = joint.first_frame, joint.second_frame
    upper, lower = joint.first, joint.second
    if below_first:  # the axis is turned round with the two bodies, so that the coordinate keeps its sign
        upper, lower = lower, str(joint.first)
        above, below = compose(joint.second_frame, _OVER), compose(joint.first_frame, _OVER)
    bodies = {body.name: body for body in scene.bodies}
    between = relative(bodies, upper, lower, above, below)
    start = coordinate(joint, between)
    if joint.kind == "ball" and joint.limits is None:  # any two frames do: these are the same at the start
        below = Pose(below.position, compose(below, inverse(between)).orientation)
    if upper is not None:
        above = compose(bodies[upper].pose if parent == WORLD else mount(bodies[upper]), above)
    drive = joint.drive
    return Link(
        body=child,
        parent=parent,
        joint=number,
        kind=joint.kind,
        above=numbers(above),
        below=numbers(compose(mount(bodies[lower]), below)),
        start=start,
        limits=tuple(map(float, joint.limits or ())),
        drive=floats(np.array([drive.stiffness, drive.damping, drive.target, drive.velocity, drive.max_force]))
        if drive
        else (),
        rate=_rate(joint.kind, bodies, upper, lower, below),
    )


def _rate(kind: str, bodies: Mapping[str, Body], upper: str | None, lower: str, below: Pose) -> tuple[float, ...]:
    """How fast the joint begins, by the velocities of its two bodies, which are taken to fit it."""
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
    """How fast a point (3,) in the world, taken to be the body's, moves."""
    middle = com_frame(body).pose.position
    return body.linear_velocity + cross(body.angular_velocity, point - middle)


def relative(bodies: Mapping[str, Body], upper: str | None, lower: str, above: Pose, below: Pose) -> Pose:
    """Where the lower frame is at the start, seen from the upper one."""
    outer = compose(bodies[upper].pose, above) if upper is not None else above
    return compose(inverse(outer), compose(bodies[lower].pose, below))


def coordinate(joint: Joint, between: Pose) -> float:
    """The joint's coordinate where its second frame is `between` in the first. Raises StageError if they don't fit."""
    gap, turn = between.position.copy(), turned(between.orientation)
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
    if np.abs(gap).max() > NEAR or np.abs(turn).max() > ALIGNED:
        reason = (
            f"its two frames are {np.linalg.norm(gap):.3g} m apart, or turned against each other by "
            f"{np.linalg.norm(turn):.3g} rad, at the start"
        )
        raise StageError(reason, PrimPlace(joint.path), "put the bodies where the joint holds them")
    if joint.limits and joint.kind != "ball" and not joint.limits[0] - ALIGNED < start < joint.limits[1] + ALIGNED:
        reason = f"it starts at {start:.4g}, outside its limits {joint.limits}"
        raise StageError(reason, PrimPlace(joint.path), "put it inside")
    return start


def _within(angle: float, limits: tuple[float, float] | None) -> float:
    """The angle, or one some whole turns away that lies within the limits."""
    low, high = limits or (-pi, pi)
    options = [angle + 2 * pi * k for k in (0, -1, 1, -2, 2)]
    return next((a for a in options if low - ALIGNED <= a <= high + ALIGNED), (angle + pi) % (2 * pi) - pi)
