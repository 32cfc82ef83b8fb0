"""Collision checks of arms: hands, held objects and links against other objects and other hands."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import pieces, touchable
from wmspec.compile.robots.arm import Arm, Array, axis_rotation, translation
from wmspec.compile.robots.boxes import Box, box_between, local_corners, part_boxes
from wmspec.compile.robots.grasps import CLOSED_SHARE, FIRM_POINTS
from wmspec.compile.robots.link_points import link_points
from wmspec.compile.robots.manipuland import Manipuland, joined_objects
from wmspec.compile.robots.planning import (
    OPEN_SPAN,
    PUSH_SPAN,
    TAKING_VERBS,
    ArmState,
    Plan,
    Reach,
    matrix,
    other_motions,
)
from wmspec.compile.robots.supported_objects import rigid_group, supported_objects
from wmspec.lang.check.ir.ir import Entity
from wmspec.sim.shapes.shape import Shape

BOX_SLACK = 0.002  # m: shrinks the boxes of objects and hands
HAND_SLACK = 0.006  # m: the same between two hands, which have round corners
HAND_RADIUS = 0.25  # m: radius of a ball around a hand's frame that contains the hand
DEFAULT_REMEDY = "let the hand take it elsewhere (`at:`), or move that out of its way"
CARRY_REMEDY = "raise it higher before, or let it go another way, or move that out of its way"
REMEDIES = {
    "push": "push it less far or another way, or move that out of its way",
    "open": "open it less far, or move that out of its way",
    "close": "close it less far, or move that out of its way",
    **dict.fromkeys(("carry", "place", "rotate", "tilt"), CARRY_REMEDY),
}
MOTION_START = {
    "pick": CLOSED_SHARE,
    "grasp": CLOSED_SHARE,
    "lift": CLOSED_SHARE,
    "push": PUSH_SPAN[0],
    "open": OPEN_SPAN[0],
    "close": OPEN_SPAN[0],
}
"""Share of an action's duration after which the handled object moves with the hand."""


def collision(made: Plan, action: Entity, before: Manipuland) -> tuple[str, str] | None:
    """Return a description of the first collision of an arm during an action, and a remedy; None if it is clear.

    `before` is the handled object before the action.
    """
    reach, arm = made.reaches[action.name], made.arms[action.of]
    links = np.array([arm.arm.links(q, arm.base) for q in reach.values[:, : len(arm.q)]])
    hand = list(_hand(arm.arm, links[:, -1], reach.values[:, -1]))
    return (
        _object_collision(made, action, before, links, hand)
        or _grasp_collision(made, action, before, links[:, -1])
        or _hand_collision(made, action, hand)
    )


def _object_collision(
    made: Plan, action: Entity, before: Manipuland, links: Array, hand: list[Box]
) -> tuple[str, str] | None:
    """Return the first collision of the hand, a link or a moved object with an unhandled object."""
    reach, arm, frames = made.reaches[action.name], made.arms[action.of].arm, links[:, -1]
    led, carried = _moved_pieces(made, action, before, frames), supported_objects(made, rigid_group(made, action))
    leads = MOTION_START.get(action.verb, 0.0) * made.duration(action)  # then supported objects move along
    behind = _LinkMotions.of(arm, links)
    for name, box in _obstacles(made, action, carried):
        when = _first_overlap(hand, [box], reach, BOX_SLACK) if _is_near(frames, box) else None
        what = "its hand"
        if when is None:
            when, what = _link_contact(behind, box, reach), "a link of it"
        if name in carried:
            when = when if when is not None and when < leads else None
        elif when is None and (made.values.flag(name, "fixed") or action.verb == "place"):
            when, what = _first_contact(led, box, reach), f"`{before.name}`"
        if when is not None:
            return f"{what} would go through `{name}`, {when:.2f} s after it starts", REMEDIES.get(
                action.verb, DEFAULT_REMEDY
            )
    return None


def _grasp_collision(made: Plan, action: Entity, before: Manipuland, frames: Array) -> tuple[str, str] | None:
    """Return a collision of a finger with the object to grasp, or a grasp at its edge."""
    reach, arm = made.reaches[action.name], made.arms[action.of].arm
    if action.verb not in TAKING_VERBS or made.values.parts(before.name):
        return None
    lowest = int(frames[:, 2, 3].argmin())
    hits = before.has((frames[lowest] @ translation(0.0, 0.0, arm.reach))[:3, 3])
    box = Box(before.middle[None], before.frame[None, :3, :3], np.array(before.half))
    touching = arm.tip[1] * (1, 0, 1) + (0, arm.pad, 0)  # only the pad of a finger
    closes = np.array(reach.times) <= CLOSED_SHARE * made.duration(action)
    for when, what in (
        (np.arange(len(frames)) <= lowest, f"a finger would come down on `{before.name}`"),
        (closes & (not hits), f"its fingers would close on an edge of `{before.name}` and squeeze it out"),
    ):
        fingers = _fingers(frames[when], reach.values[when, -1], arm, np.array([arm.tip[0], touching]))
        if when.any() and any(finger.meets(box, BOX_SLACK).any() for finger in fingers):
            return what, "take it nearer to its middle, or wholly beside it"
    return None


def _hand_collision(made: Plan, action: Entity, hand: list[Box]) -> tuple[str, str] | None:
    """Return the first collision of the hand with the hand of another arm."""
    reach, start = made.reaches[action.name], made.number(action, "start")
    for robot, other in made.arms.items():
        if robot != action.of:
            theirs = list(_other_hand(made, robot, other, start + np.array(reach.times)))
            if (when := _first_overlap(hand, theirs, reach, HAND_SLACK)) is not None:
                what = f"its hand would meet that of `{robot}`, {when:.2f} s after it starts"
                return what, "let one go after the other"
    return None


# ---------------------------------------------------------------- links and moved objects


def _is_near(frames: Array, box: Box) -> bool:
    """Whether a hand (n, 4, 4) comes near a box at any time."""
    return bool(
        np.linalg.norm(frames[:, :3, 3] - box.center, axis=1).min() < HAND_RADIUS + float(np.linalg.norm(box.half))
    )


@dataclass(frozen=True, eq=False)
class _LinkMotions:
    """The k links behind the hand at n times.

    `points` (m, 3) of each in its `frames` (n, 4, 4), and a ball around them: `centers` (k, n, 3), `radii` (k, 1).
    """

    points: Sequence[Array]
    frames: Sequence[Array]
    centers: Array
    radii: Array

    @classmethod
    def of(cls, arm: Arm, links: Array) -> _LinkMotions:
        """Return the motions of the links behind the hand, given the frames (n, l, 4, 4) of all links."""
        points, frames = [p for _, p in link_points(arm)], [links[:, number] for number, _ in link_points(arm)]
        middles = [p.mean(axis=0) for p in points]
        centers = [f[:, :3, :3] @ middle + f[:, :3, 3] for f, middle in zip(frames, middles, strict=True)]
        radii = [np.linalg.norm(p - middle, axis=1).max() for p, middle in zip(points, middles, strict=True)]
        return cls(points, frames, np.array(centers).reshape(-1, len(links), 3), np.array(radii).reshape(-1, 1))


def _link_contact(links: _LinkMotions, box: Box, reach: Reach) -> float | None:
    """Return when (s) a link first enters a fixed box, or None."""
    outside = np.maximum(np.abs((links.centers - box.center) @ box.axes[0]) - box.half, 0.0)
    near = np.linalg.norm(outside, axis=2) < links.radii
    first = len(reach.times)
    for points, frames, close in zip(links.points, links.frames, near, strict=True):
        for i in np.flatnonzero(close[:first]).tolist():
            seen = (points @ frames[i, :3, :3].T + frames[i, :3, 3] - box.center) @ box.axes[0]
            if (np.abs(seen) < box.half - BOX_SLACK).all(axis=1).any():
                first = i
                break
    return reach.times[first] if first < len(reach.times) else None


@dataclass(frozen=True, eq=False)
class _MovedPiece:
    """A solid that the arm moves: the indices of its times, and its frames (n, 4, 4)."""

    solid: Shape
    times: NDArray[np.intp]
    frames: Array
    box: Box


def _moved_pieces(made: Plan, action: Entity, before: Manipuland, frames: Array) -> list[_MovedPiece]:
    """Return the solids that the hand (n, 4, 4) holds or pushes during an action."""
    reach = made.reaches[action.name]
    when = made.number(action, "start") + np.array(reach.times)
    holds = [r.hold for r in made.reaches.values() if r.robot == action.of and r.hold]
    spans = [(h.start, h.stop) for h in holds if h.object == before.name and len(h.points) == len(FIRM_POINTS)]
    if action.verb == "push":
        start, lasts = made.number(action, "start"), made.duration(action)
        spans = [(start + PUSH_SPAN[0] * lasts, start + PUSH_SPAN[1] * lasts)]
    during = np.array([(start <= when) & (when <= stop) for start, stop in spans]).reshape(len(spans), len(when))
    times = np.flatnonzero(during.any(axis=0))
    if not len(times):
        return []
    values = made.values
    rigid = frames[times] @ np.linalg.inv(frames[times[0]]) @ made.frame(before.name)
    placed = ((piece, rigid @ matrix(piece.pose)) for piece in pieces(values, before.name))
    return [_MovedPiece(piece.solid, times, at, box_between(at, local_corners(piece))) for piece, at in placed]


def _first_contact(led: Sequence[_MovedPiece], box: Box, reach: Reach) -> float | None:
    """Return when (s) moved solids first overlap a fixed box, or None."""
    first = None
    for piece in led:
        for i in np.flatnonzero(piece.box.meets(box, BOX_SLACK)).tolist():
            if not _is_separated(piece.solid, piece.frames[i], box):
                first = min(first or np.inf, reach.times[piece.times[i]])
                break
    return first


def _is_separated(solid: Shape, frame: Array, box: Box) -> bool:
    """Whether a face of a box, or of the box around a solid, separates the two, within the slack."""
    for axis in (*box.axes[0].T, *frame[:3, :3].T):
        own = frame[:3, :3].T @ axis
        ahead, back = solid.reach(tuple(own.tolist())), solid.reach(tuple((-own).tolist()))
        way = float((box.center[0] - frame[:3, 3]) @ axis)
        half = float(np.abs(box.axes[0].T @ axis) @ box.half)
        if way - half > ahead - 2 * BOX_SLACK or -way - half > back - 2 * BOX_SLACK:
            return True
    return False


# ---------------------------------------------------------------- hands


def _first_overlap(hand: list[Box], others: list[Box], reach: Reach, slack: float) -> float | None:
    """Return when (s) any two of these boxes first overlap, or None."""
    hits = np.any([mine.meets(box, slack) for mine in hand for box in others], axis=0)
    return reach.times[int(hits.argmax())] if hits.any() else None


def _hand(arm: Arm, frames: Array, slides: Array) -> Iterator[Box]:
    """Yield the boxes of a hand and its fingers, for frames (n, 4, 4) and finger displacements (n,) m."""
    yield box_between(frames, arm.hull)
    yield from _fingers(frames, slides, arm, arm.tip)


def _fingers(frames: Array, slides: Array, arm: Arm, corners: Array) -> Iterator[Box]:
    """Yield the boxes of both fingers between two corners (2, 3) of their own frames."""
    for side in (0.0, np.pi):
        fingers = np.array([axis_rotation(2, side) @ translation(0.0, float(slide), arm.finger) for slide in slides])
        yield box_between(frames @ fingers, corners)


def _other_hand(made: Plan, robot: str, arm: ArmState, times: Array) -> Iterator[Box]:
    """Yield the boxes of another arm's hand at these times (n,) s, by its planned motion so far."""
    rows = np.tile([*arm.arm.rest, arm.arm.opening / 2], (len(times), 1))
    starts = sorted((made.values.number(name, "start"), name) for name, r in made.reaches.items() if r.robot == robot)
    for start, name in starts:
        reach, later = made.reaches[name], times >= start
        columns = [*range(len(arm.q)), -1]
        rows[later] = np.array([np.interp(times[later] - start, reach.times, reach.values[:, c]) for c in columns]).T
    frames = np.array([arm.arm.links(row[:-1], arm.base)[-1] for row in rows])
    yield from _hand(arm.arm, frames, rows[:, -1])


def _obstacles(made: Plan, action: Entity, carried: set[str]) -> Iterator[tuple[str, Box]]:
    """Yield the objects that an arm must avoid; a push may also move loose objects, except `carried` ones."""
    values, handled = made.values, joined_objects(made.values, made.values.reference(action.name, "object"))
    others = {values.reference(t.name, "object") for t in other_motions(values)}
    for thing in values.spec.things:
        name = thing.name
        if thing.kind != "object" or name in handled or name in others or not values.is_present(name):
            continue
        if not _is_solid(values, name) or (
            action.verb == "push" and name not in carried and not values.flag(name, "fixed")
        ):
            continue
        for box in part_boxes(values, name, made.frame(name)):
            yield name, box


def _is_solid(values: Evaluator, name: str) -> bool:
    parts = values.parts(name)
    return any(touchable(values, part) for part in parts) if parts else touchable(values, name)
