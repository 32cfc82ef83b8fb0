"""Whether hands keep clear: of all that they do not handle, and of each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.check.ir import Thing
from wmspec.layout.geometry import pieces, touchable
from wmspec.layout.values import Values
from wmspec.robots.arm import Arm, Array, about, shift
from wmspec.robots.planning import Plan, Reach, State
from wmspec.space import Pose

SLACK = 0.002  # m: by so much less than its box a thing or a hand counts
ROUND = 0.006  # m: the same of two hands, whose corners are round
HAND = 0.25  # m: no part of a hand is further from its frame
ASIDE = "let the hand come from elsewhere, or move that out of its way"
TAKES = ("pick", "grasp", "lift", "open", "close")
_NEXT, _LAST = [1, 2, 0], [2, 0, 1]


@dataclass(frozen=True, eq=False)
class Box:
    """A box, or the same one at n times: `center` (n, 3), `axes` (n, 3, 3) as columns, `half` its edges (3,) m."""

    center: Array
    axes: Array
    half: Array

    def meets(self, other: Box, slack: float) -> NDArray[np.bool_]:
        """When (n,) the two overlap: no axis separates them (S. Gottschalk, OBBTree, 1996, section 5)."""
        turn = np.swapaxes(self.axes, 1, 2) @ other.axes
        way = ((other.center - self.center)[:, None, :] @ self.axes)[:, 0]
        size, a, b = np.abs(turn), self.half - slack, other.half - slack
        faces = np.abs(way) > a + size @ b
        others = np.abs((way[:, None, :] @ turn)[:, 0]) > (a @ size) + b
        meets = np.asarray(~(faces.any(axis=1) | others.any(axis=1)))
        if not meets.any():
            return meets
        way, turn, size = way[meets], turn[meets], size[meets]
        i, j = _NEXT, _LAST
        edge = np.abs(way[:, j, None] * turn[:, i, :] - way[:, i, None] * turn[:, j, :])
        reach = a[i][:, None] * size[:, j, :] + a[j][:, None] * size[:, i, :]
        reach = reach + size[:, :, j] * b[i] + size[:, :, i] * b[j]
        meets[meets] = ~(edge > reach + 1e-9).any(axis=(1, 2))
        return meets


def collision(made: Plan, action: Thing) -> tuple[str, str] | None:
    """What the hand goes through during an action and when, and what helps; None if it keeps clear."""
    reach, arm = made.reaches[action.name], made.arms[action.of]
    frames = np.array([arm.arm.links(q, arm.base)[-1] for q in reach.values[:, : len(arm.q)]])
    hand = list(_hand(arm.arm, frames, reach.values[:, -1]))
    for name, box in _obstacles(made, action, frames[:, :3, 3]):
        if (when := _first(hand, [box], reach, SLACK)) is not None:
            return f"its hand would go through `{name}`, {when:.2f} s after it starts", ASIDE
    own = made.things[made.values.property(action.name, "object")]
    if action.verb in TAKES and not made.values.parts(own.name):
        down = slice(0, int(frames[:, 2, 3].argmin()) + 1)
        touching = arm.arm.tip[1] * (1, 0, 1) + (0, arm.arm.pad, 0)  # of a finger the pad alone
        fingers = list(_fingers(frames[down], reach.values[down, -1], arm.arm, np.array([arm.arm.tip[0], touching])))
        box = Box(own.middle[None], own.frame[None, :3, :3], np.array(own.half))
        if _first(fingers, [box], reach, SLACK) is not None:
            return f"a finger would come down on `{own.name}`", "take it nearer to its middle, or wholly beside it"
    start = made.number(action, "start")
    for robot, other in made.arms.items():
        if robot != action.of:
            theirs = list(_other_hand(made, robot, other, start + np.array(reach.times)))
            if (when := _first(hand, theirs, reach, ROUND)) is not None:
                return (
                    f"its hand would meet that of `{robot}`, {when:.2f} s after it starts",
                    "let one go after the other",
                )
    return None


def _first(hand: list[Box], others: list[Box], reach: Reach, slack: float) -> float | None:
    """When (s) any two of these first overlap."""
    hits = np.any([mine.meets(box, slack) for mine in hand for box in others], axis=0)
    return reach.times[int(hits.argmax())] if hits.any() else None


def _hand(arm: Arm, frames: Array, slides: Array) -> Iterator[Box]:
    """The hull of the hand and its fingers, for its frames (n, 4, 4) and how far (n,) each finger has slid."""
    yield _between(frames, arm.hull)
    yield from _fingers(frames, slides, arm, arm.tip)


def _fingers(frames: Array, slides: Array, arm: Arm, corners: Array) -> Iterator[Box]:
    """The part of both fingers that is between two corners (2, 3) of their own frames."""
    for side in (0.0, np.pi):
        fingers = np.array([about(2, side) @ shift(0.0, float(slide), arm.finger) for slide in slides])
        yield _between(frames @ fingers, corners)


def _between(frames: Array, corners: Array) -> Box:
    """The box between two corners (2, 3) in these frames."""
    middle = frames[:, :3, :3] @ corners.mean(axis=0) + frames[:, :3, 3]
    return Box(middle, frames[:, :3, :3], (corners[1] - corners[0]) / 2)


def _other_hand(made: Plan, robot: str, arm: State, times: Array) -> Iterator[Box]:
    """The hand of another arm at these times (n,) s: on its ways so far, and between them where they end."""
    rows = np.tile([*arm.arm.rest, arm.arm.opening / 2], (len(times), 1))
    starts = sorted((made.values.property(name, "start"), name) for name, r in made.reaches.items() if r.robot == robot)
    for start, name in starts:
        reach, later = made.reaches[name], times >= start
        columns = [*range(len(arm.q)), -1]
        rows[later] = np.array([np.interp(times[later] - start, reach.times, reach.values[:, c]) for c in columns]).T
    frames = np.array([arm.arm.links(row[:-1], arm.base)[-1] for row in rows])
    yield from _hand(arm.arm, frames, rows[:, -1])


def _obstacles(made: Plan, action: Thing, places: Array) -> Iterator[tuple[str, Box]]:
    """All near the way of a hand (n, 3) that it does not handle; what it pushes may push what can move."""
    values, handled = made.values, together(made.values, made.values.property(action.name, "object"))
    others = {values.property(t.name, "object") for t in values.spec.things if _moves_object(t, values)}
    for thing in values.spec.things:
        name = thing.name
        if thing.kind != "object" or name in handled or name in others or not values.there(name):
            continue
        if not _solid(values, name) or (action.verb == "push" and not values.property(name, "fixed")):
            continue
        pose = values.pose(name)
        known = made.things.get(name)
        gone = known.frame[:3, 3] - known.start if known else np.zeros(3)
        for box in _boxes(values, name, pose, gone):
            if np.linalg.norm(places - box.center, axis=1).min() < HAND + float(np.linalg.norm(box.half)):
                yield name, box


def _boxes(values: Values, name: str, pose: Pose, gone: Array) -> Iterator[Box]:
    """The boxes around the solids of an object, which has gone so far (3,) from its first pose."""
    axes = np.eye(3)
    for piece in pieces(values, name):
        placed = pose.then(piece.pose)
        low, high = (np.array([sign * piece.solid.reach(tuple(sign * axis)) for axis in axes]) for sign in (-1.0, 1.0))
        turn = np.array([np.array(placed.apply(tuple(axis))) - np.array(placed.position) for axis in axes]).T
        yield Box(np.array(placed.apply(tuple((low + high) / 2)))[None] + gone, turn[None], (high - low) / 2)


def _moves_object(thing: Thing, values: Values) -> bool:
    """Whether something is an action of no robot that moves an object."""
    return thing.kind == "action" and not thing.of and "object" in thing.properties and values.there(thing.name)


def _solid(values: Values, name: str) -> bool:
    parts = values.parts(name)
    return any(touchable(values, part) for part in parts) if parts else touchable(values, name)


def together(values: Values, name: str) -> set[str]:
    """An object and all that joints join to it."""
    joined, left = {name}, [t for t in values.spec.things if t.kind == "joint"]
    ends = [{values.property(t.name, end) for end in ("of", "to") if values.has(t.name, end)} for t in left]
    for _ in ends:
        for pair in ends:
            if pair & joined:
                joined |= pair
    return joined
