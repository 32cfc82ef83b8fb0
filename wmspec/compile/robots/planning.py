"""Planner state: arms, moved objects, and the motions planned so far."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from wmspec.compile.robots.arm import Arm, Array
from wmspec.compile.robots.manipuland import Manipuland, manipuland_of
from wmspec.compile.robots.schedule import action_duration
from wmspec.compile.robots.tool_path import OutOfReachError, ToolSegment, joint_knots, knot_times
from wmspec.core.diagnostics import Diagnostic, ImpossibleValue, Note
from wmspec.core.space import Pose
from wmspec.lang.check.ir.ir import Entity

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

APPROACH_HEIGHT = 0.12  # m: height of the hand above a grasp or contact, before and after
NO_MOTION = np.eye(4)
TAKING_VERBS = ("pick", "grasp", "lift", "open", "close")
"""Verbs that grasp an object."""
PUSH_SPAN = (0.43, 0.63)
OPEN_SPAN = (0.37, 0.66)
"""Start and end of the object's motion in a push or an opening, as shares of the action's duration."""


@dataclass(frozen=True)
class Hold:
    """The `object` is held from `start` to `stop` (s) by `points` (m) in the hand's frame."""

    object: str
    start: float
    stop: float
    points: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Reach:
    """The motion of an arm during an action: joint `values` (n, k) at `times` (n,) s after the action's start."""

    robot: str
    times: tuple[float, ...]
    values: Array
    hold: Hold | None


@dataclass
class ArmState:
    """The state of an arm while planning: joints, finger opening, held object and the action that grasped it.

    `intended` is the object of the last grasp, successful or not, that has not been released.
    """

    arm: Arm
    base: Array
    q: Array
    width: float
    held: str = ""
    since: str = ""
    intended: str = ""

    @property
    def tool(self) -> Array:
        """The frame of its tool."""
        return self.arm.tool(self.q, self.base)

    def retracted(self, tool: Array) -> Array:
        """Return the pose of the retracted hand, with the orientation of `tool`."""
        rest = tool.copy()
        rest[:3, 3] = self.arm.tool(self.arm.rest, self.base)[:3, 3]
        return rest


class PlanningError(Exception):
    """An attempt at a plan fails at an action, `after` (s) of it if known."""

    def __init__(self, action: Entity, reason: str, help: str = "", after: float | None = None) -> None:
        self.action, self.reason, self.help, self.after = action, reason, help, after


class PathBlockedError(PlanningError):
    """An obstacle is in the way."""


@dataclass
class Plan:
    """A plan under construction; `choice` selects one of the possible grasps.

    `opened` is the displacement (rad or m) of joints from their start, `moved` the motion (4, 4) of objects since the
    start.
    """

    values: Evaluator
    choice: int
    arms: dict[str, ArmState]
    things: dict[str, Manipuland] = field(default_factory=dict)
    reaches: dict[str, Reach] = field(default_factory=dict)
    opened: dict[str, float] = field(default_factory=dict)
    moved: dict[str, Array] = field(default_factory=dict)

    def thing(self, action: Entity) -> Manipuland:
        """Return the object of an action in its planned state."""
        name = self.values.reference(action.name, "object")
        self._require_unmoved(action, name)
        if name not in self.things:
            try:
                self.things[name] = manipuland_of(self.values, name).put(self.motion(name))
            except ImpossibleValue as error:
                raise ImpossibleValue.of(_at_action(d, action) for d in error.diagnostics) from None
        return self.things[name]

    def motion(self, name: str) -> Array:
        """Return the motion (4, 4) of an object since the start."""
        return self.moved.get(name, NO_MOTION)

    def frame(self, name: str) -> Array:
        """Return the planned frame (4, 4) of an object."""
        return np.asarray(self.motion(name) @ matrix(self.values.pose(name)))

    def _require_unmoved(self, action: Entity, name: str) -> None:
        """Raise if an action without a robot moves an object before an arm has finished with it."""
        ends = self.number(action, "start") + self.duration(action)
        for other in other_motions(self.values):
            if self.values.reference(other.name, "object") == name and self.number(other, "start") < ends:
                raise ImpossibleValue(
                    f"`{other.name}` moves `{name}`, and a plan does not know where to",
                    action.place,
                    f"let `{action.of}` handle what no other action moves, or do it before that",
                    notes=(Note(f"`{other.name}` is here", other.place),),
                )

    def number(self, action: Entity, name: str) -> float:
        """Return an argument of an action."""
        return self.values.number(action.name, name)

    def duration(self, action: Entity) -> float:
        """Return the duration (s) of an action."""
        return action_duration(self.values, action)

    def go(self, action: Entity, legs: Sequence[ToolSegment]) -> None:
        """Record the motion of the arm along segments, and its final state."""
        arm = self.arms[action.of]
        try:
            angles = joint_knots(arm.arm, arm.base, arm.q, arm.width, legs)
        except OutOfReachError as error:
            raise PlanningError(action, str(error), error.help, error.after) from None
        self.reaches[action.name] = Reach(action.of, knot_times(legs[-1].until), angles, None)
        arm.q, arm.width = angles[-1, : len(arm.q)], legs[-1].width

    def hold(self, action: Entity, name: str, start: float, points: Sequence[tuple[float, float, float]]) -> None:
        """Record that the arm holds an object from `start` (s), by points in the tool's frame."""
        arm, end = self.arms[action.of], self.values.end
        ahead = tuple((x, y, z + arm.arm.reach) for x, y, z in points)
        held = Hold(name, start, max(end, start), ahead)
        self.reaches[action.name] = replace(self.reaches[action.name], hold=held)
        arm.held, arm.since = name, action.name

    def release(self, action: Entity, moment: float) -> None:
        """Record that the arm releases its object at `moment` (s)."""
        arm = self.arms[action.of]
        reach = self.reaches.get(arm.since)
        if reach and reach.hold:
            self.reaches[arm.since] = replace(reach, hold=replace(reach.hold, stop=moment))
        arm.held = arm.since = arm.intended = ""

    def free(self, action: Entity) -> None:
        """Raise if the arm holds something."""
        if held := self.arms[action.of].held:
            raise ImpossibleValue(
                f"`{action.of}` holds `{held}`, so it cannot {action.verb}",
                action.place,
                "let it `place` or `drop` that first",
            )

    def require_held(self, action: Entity) -> None:
        """Raise if the arm has not grasped the object of the action, or if another arm holds it too."""
        name, arm = self.values.reference(action.name, "object"), self.arms[action.of]
        left_out = (t for t in self.values.spec.things if t.of == action.of and not self.values.is_present(t.name))
        if arm.intended != name and not any(t.verb in TAKING_VERBS for t in left_out):
            raise ImpossibleValue(
                f"`{action.of}` does not hold `{name}`, so it cannot {action.verb} it",
                action.place,
                "let it `pick` it first",
            )
        for robot, other in self.arms.items():
            if robot != action.of and name == other.held == arm.held and action.verb != "drop":
                raise ImpossibleValue(
                    f"`{robot}` holds `{name}`, too, so `{action.of}` cannot {action.verb} it",
                    action.place,
                    f"let `{robot}` `drop` it first",
                )

    def nearest(self, robot: str, yaws: Sequence[float]) -> float:
        """Return the tool heading, of these or their opposites, with the smallest turn; `choice` selects others."""
        tool = self.arms[robot].tool
        fore = float(np.arctan2(tool[1, 0], tool[0, 0]))
        turns = (_wrap_angle(yaw + flip - fore) for yaw in yaws for flip in (0.0, np.pi))
        ways = sorted(turns, key=lambda way: (round(abs(way), 6), way))
        return fore + ways[self.choice % len(ways)]


def require_single(acts: Sequence[Entity]) -> Entity:
    """Return the only action. Raises if several arms act on one object."""
    if len(acts) > 1:
        raise ImpossibleValue(
            f"two arms cannot {acts[1].verb} one thing together", acts[1].place, "let them push or lift it"
        )
    return acts[0]


def other_motions(values: Evaluator) -> Iterator[Entity]:
    """Yield the actions without a robot that move an object."""
    acts = (t for t in values.spec.things if t.kind == "action" and not t.of and t.verb != "paint")
    return (t for t in acts if "object" in t.properties and values.is_present(t.name))


def _at_action(diagnostic: Diagnostic, action: Entity) -> Diagnostic:
    """Return the diagnostic at the action that uses an unsuitable object."""
    if diagnostic.place is None:
        return replace(diagnostic, place=action.place)
    return replace(diagnostic, place=action.place, notes=(Note("this one", diagnostic.place), *diagnostic.notes))


def _wrap_angle(angle: float) -> float:
    """Return the angle in [-pi, pi)."""
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def matrix(pose: Pose) -> Array:
    """Return a pose as a matrix (4, 4)."""
    transform = np.eye(4)
    transform[:3, 3] = pose.position
    for i, axis in enumerate(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))):
        transform[:3, i] = np.array(pose.apply(axis)) - transform[:3, 3]
    return transform
