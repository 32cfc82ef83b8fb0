"""Whether arms keep clear: hands, what they hold and the links behind, of what they do not handle and of each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.compile.layout.geometry import pieces, touchable
from wmspec.compile.layout.values import Values
from wmspec.compile.robots.arm import Arm, Array, about, shift
from wmspec.compile.robots.boxes import Box, between, boxes, ends
from wmspec.compile.robots.grasps import CLOSED, FIRM
from wmspec.compile.robots.link_points import limbs
from wmspec.compile.robots.manipuland import Goods, together
from wmspec.compile.robots.planning import OPENS, PUSHES, TAKES, Plan, Reach, State, matrix, moving
from wmspec.compile.robots.supported_objects import gang, riders
from wmspec.lang.check.ir.ir import Thing
from wmspec.sim.shapes.shape import Shape

SLACK = 0.002  # m: by so much less than its box a thing or a hand counts
ROUND = 0.006  # m: the same of two hands, whose corners are round
HAND = 0.25  # m: no part of a hand is further from its frame
ASIDE = "let the hand take it elsewhere (`at:`), or move that out of its way"
AROUND = "raise it higher before, or let it go another way, or move that out of its way"
HELPS = {
    "push": "push it less far or another way, or move that out of its way",
    "open": "open it less far, or move that out of its way",
    "close": "close it less far, or move that out of its way",
    **dict.fromkeys(("carry", "place", "rotate", "tilt"), AROUND),
}
LEADS = {"pick": CLOSED, "grasp": CLOSED, "lift": CLOSED, "push": PUSHES[0], "open": OPENS[0], "close": OPENS[0]}
"""From which share of its time a verb leads what it is done to."""


def collision(made: Plan, action: Thing, before: Goods) -> tuple[str, str] | None:
    """What an arm goes through during an action and when, and what helps; None if it keeps clear.

    `before` is what it handles, as it was before.
    """
    reach, arm = made.reaches[action.name], made.arms[action.of]
    links = np.array([arm.arm.links(q, arm.base) for q in reach.values[:, : len(arm.q)]])
    hand = list(_hand(arm.arm, links[:, -1], reach.values[:, -1]))
    return (
        _with_things(made, action, before, links, hand)
        or _with_what_it_takes(made, action, before, links[:, -1])
        or _with_other_hands(made, action, hand)
    )


def _with_things(made: Plan, action: Thing, before: Goods, links: Array, hand: list[Box]) -> tuple[str, str] | None:
    """What the hand, a link or what is held or pushed goes through, of all that the arm does not handle."""
    reach, arm, frames = made.reaches[action.name], made.arms[action.of].arm, links[:, -1]
    led, carried = _led(made, action, before, frames), riders(made, gang(made, action))
    leads = LEADS.get(action.verb, 0.0) * made.lasts(action)  # what lies on it or in it comes along from then on
    for name, box in _obstacles(made, action, carried):
        when = _first(hand, [box], reach, SLACK) if _near(frames, box) else None
        what = "its hand"
        if when is None:
            when, what = _through(arm, links, box, reach), "a link of it"
        if name in carried:
            when = when if when is not None and when < leads else None
        elif when is None and (made.values.flag(name, "fixed") or action.verb == "place"):
            when, what = _meets(led, box, reach), f"`{before.name}`"
        if when is not None:
            return f"{what} would go through `{name}`, {when:.2f} s after it starts", HELPS.get(action.verb, ASIDE)
    return None


def _with_what_it_takes(made: Plan, action: Thing, before: Goods, frames: Array) -> tuple[str, str] | None:
    """Whether a finger comes down on what it is to take, or the two close on an edge of it."""
    reach, arm = made.reaches[action.name], made.arms[action.of].arm
    if action.verb not in TAKES or made.values.parts(before.name):
        return None
    lowest = int(frames[:, 2, 3].argmin())
    hits = before.has((frames[lowest] @ shift(0.0, 0.0, arm.reach))[:3, 3])
    box = Box(before.middle[None], before.frame[None, :3, :3], np.array(before.half))
    touching = arm.tip[1] * (1, 0, 1) + (0, arm.pad, 0)  # of a finger the pad alone
    closes = np.array(reach.times) <= CLOSED * made.lasts(action)
    for when, what in (
        (np.arange(len(frames)) <= lowest, f"a finger would come down on `{before.name}`"),
        (closes & (not hits), f"its fingers would close on an edge of `{before.name}` and squeeze it out"),
    ):
        fingers = _fingers(frames[when], reach.values[when, -1], arm, np.array([arm.tip[0], touching]))
        if when.any() and any(finger.meets(box, SLACK).any() for finger in fingers):
            return what, "take it nearer to its middle, or wholly beside it"
    return None


def _with_other_hands(made: Plan, action: Thing, hand: list[Box]) -> tuple[str, str] | None:
    """Whether a hand meets that of another arm."""
    reach, start = made.reaches[action.name], made.number(action, "start")
    for robot, other in made.arms.items():
        if robot != action.of:
            theirs = list(_other_hand(made, robot, other, start + np.array(reach.times)))
            if (when := _first(hand, theirs, reach, ROUND)) is not None:
                what = f"its hand would meet that of `{robot}`, {when:.2f} s after it starts"
                return what, "let one go after the other"
    return None


# ---------------------------------------------------------------- links, and what is led


def _near(frames: Array, box: Box) -> bool:
    """Whether a hand (n, 4, 4) comes near a box at any time."""
    return bool(np.linalg.norm(frames[:, :3, 3] - box.center, axis=1).min() < HAND + float(np.linalg.norm(box.half)))


def _through(arm: Arm, links: Array, box: Box, reach: Reach) -> float | None:
    """When (s) a link behind the hand, of all their frames (n, k, 4, 4), is first in a box that stands still."""
    first = len(links)
    for number, points in limbs(arm):
        middle = points.mean(axis=0)
        round_ = float(np.linalg.norm(points - middle, axis=1).max())
        frames = links[:first, number]
        centers = frames[:, :3, :3] @ middle + frames[:, :3, 3]
        outside = np.maximum(np.abs((centers - box.center) @ box.axes[0]) - box.half, 0.0)
        for i in np.flatnonzero(np.linalg.norm(outside, axis=1) < round_).tolist():
            seen = (points @ frames[i, :3, :3].T + frames[i, :3, 3] - box.center) @ box.axes[0]
            if (np.abs(seen) < box.half - SLACK).all(axis=1).any():
                first = i
                break
    return reach.times[first] if first < len(links) else None


@dataclass(frozen=True, eq=False)
class _Led:
    """A piece of what an arm leads: its solid, at these of the times of a reach in these frames (n, 4, 4)."""

    solid: Shape
    times: NDArray[np.intp]
    frames: Array
    box: Box


def _led(made: Plan, action: Thing, before: Goods, frames: Array) -> list[_Led]:
    """The pieces of what the hand (n, 4, 4) holds fast or pushes during an action, as they go with it."""
    reach = made.reaches[action.name]
    when = made.number(action, "start") + np.array(reach.times)
    holds = [r.hold for r in made.reaches.values() if r.robot == action.of and r.hold]
    spans = [(h.start, h.stop) for h in holds if h.object == before.name and len(h.points) == len(FIRM)]
    if action.verb == "push":
        start, lasts = made.number(action, "start"), made.lasts(action)
        spans = [(start + PUSHES[0] * lasts, start + PUSHES[1] * lasts)]
    during = np.array([(start <= when) & (when <= stop) for start, stop in spans]).reshape(len(spans), len(when))
    times = np.flatnonzero(during.any(axis=0))
    if not len(times):
        return []
    values = made.values
    rigid = frames[times] @ np.linalg.inv(frames[times[0]]) @ made.frame(before.name)
    found = []
    for piece in pieces(values, before.name):
        placed = rigid @ matrix(piece.pose)
        low, high = ends(piece)
        middle = placed[:, :3, :3] @ ((low + high) / 2) + placed[:, :3, 3]
        found.append(_Led(piece.solid, times, placed, Box(middle, placed[:, :3, :3], (high - low) / 2)))
    return found


def _meets(led: Sequence[_Led], box: Box, reach: Reach) -> float | None:
    """When (s) what is led is first in a box that stands still: no axis of either separates them."""
    first = None
    for piece in led:
        for i in np.flatnonzero(piece.box.meets(box, SLACK)).tolist():
            if not _parted(piece.solid, piece.frames[i], box):
                first = min(first or np.inf, reach.times[piece.times[i]])
                break
    return first


def _parted(solid: Shape, frame: Array, box: Box) -> bool:
    """Whether a side of a box, or of that around a solid, has all of the other beyond it, but for the slack."""
    for axis in (*box.axes[0].T, *frame[:3, :3].T):
        own = frame[:3, :3].T @ axis
        ahead, back = solid.reach(tuple(own.tolist())), solid.reach(tuple((-own).tolist()))
        way = float((box.center[0] - frame[:3, 3]) @ axis)
        half = float(np.abs(box.axes[0].T @ axis) @ box.half)
        if way - half > ahead - 2 * SLACK or -way - half > back - 2 * SLACK:
            return True
    return False


# ---------------------------------------------------------------- hands


def _first(hand: list[Box], others: list[Box], reach: Reach, slack: float) -> float | None:
    """When (s) any two of these first overlap."""
    hits = np.any([mine.meets(box, slack) for mine in hand for box in others], axis=0)
    return reach.times[int(hits.argmax())] if hits.any() else None


def _hand(arm: Arm, frames: Array, slides: Array) -> Iterator[Box]:
    """The hull of the hand and its fingers, for its frames (n, 4, 4) and how far (n,) each finger has slid."""
    yield between(frames, arm.hull)
    yield from _fingers(frames, slides, arm, arm.tip)


def _fingers(frames: Array, slides: Array, arm: Arm, corners: Array) -> Iterator[Box]:
    """The part of both fingers that is between two corners (2, 3) of their own frames."""
    for side in (0.0, np.pi):
        fingers = np.array([about(2, side) @ shift(0.0, float(slide), arm.finger) for slide in slides])
        yield between(frames @ fingers, corners)


def _other_hand(made: Plan, robot: str, arm: State, times: Array) -> Iterator[Box]:
    """The hand of another arm at these times (n,) s: on its ways so far, and between them where they end."""
    rows = np.tile([*arm.arm.rest, arm.arm.opening / 2], (len(times), 1))
    starts = sorted((made.values.number(name, "start"), name) for name, r in made.reaches.items() if r.robot == robot)
    for start, name in starts:
        reach, later = made.reaches[name], times >= start
        columns = [*range(len(arm.q)), -1]
        rows[later] = np.array([np.interp(times[later] - start, reach.times, reach.values[:, c]) for c in columns]).T
    frames = np.array([arm.arm.links(row[:-1], arm.base)[-1] for row in rows])
    yield from _hand(arm.arm, frames, rows[:, -1])


def _obstacles(made: Plan, action: Thing, carried: set[str]) -> Iterator[tuple[str, Box]]:
    """All that an arm does not handle; what it pushes may push what can move, but for what is `carried` along."""
    values, handled = made.values, together(made.values, made.values.reference(action.name, "object"))
    others = {values.reference(t.name, "object") for t in moving(values)}
    for thing in values.spec.things:
        name = thing.name
        if thing.kind != "object" or name in handled or name in others or not values.there(name):
            continue
        if not _solid(values, name) or (
            action.verb == "push" and name not in carried and not values.flag(name, "fixed")
        ):
            continue
        for box in boxes(values, name, made.frame(name)):
            yield name, box


def _solid(values: Values, name: str) -> bool:
    parts = values.parts(name)
    return any(touchable(values, part) for part in parts) if parts else touchable(values, name)
