"""A plan in the making: how each arm is, where things are by then, and the ways that were decided so far."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from wmspec.compile.robots.arm import Arm, Array
from wmspec.compile.robots.legs import Leg, OutOfReachError, joints, times
from wmspec.compile.robots.manipuland import Goods, goods
from wmspec.compile.robots.schedule import lasts
from wmspec.core.diagnostics import Diagnostic, ImpossibleValue, Note
from wmspec.core.space import Pose
from wmspec.lang.check.ir.ir import Thing

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

ABOVE = 0.12  # m: so high above where it takes or touches something the hand comes and goes
STILL = np.eye(4)
TAKES = ("pick", "grasp", "lift", "open", "close")
"""The verbs that take a thing."""
PUSHES = (0.43, 0.63)
OPENS = (0.37, 0.66)
"""From when to when a hand that pushes, or opens, moves what it does so to, in shares of the time that it takes."""


@dataclass(frozen=True)
class Hold:
    """The `object` is held from `start` to `stop` (s) by `points` (m) of the hand's frame."""

    object: str
    start: float
    stop: float
    points: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Reach:
    """The way of an arm during an action: its joints' `values` (n, k) at `times` (n,), s after the action starts."""

    robot: str
    times: tuple[float, ...]
    values: Array
    hold: Hold | None


@dataclass
class State:
    """How an arm is while a plan is made: its joints, how wide it is open, and what it holds since which action.

    `wanted` is what it took last, or tried to take, and has not let go since.
    """

    arm: Arm
    base: Array
    q: Array
    width: float
    held: str = ""
    since: str = ""
    wanted: str = ""

    @property
    def tool(self) -> Array:
        """Where its tool is."""
        return self.arm.tool(self.q, self.base)

    def drawn_back(self, tool: Array) -> Array:
        """The place of a hand that is drawn back, turned as it is at `tool`."""
        rest = tool.copy()
        rest[:3, 3] = self.arm.tool(self.arm.rest, self.base)[:3, 3]
        return rest


class Unable(Exception):
    """One try at a plan fails at an action, if known after so much (s) of it."""

    def __init__(self, action: Thing, reason: str, help: str = "", after: float | None = None) -> None:
        self.action, self.reason, self.help, self.after = action, reason, help, after


class Blocked(Unable):
    """Something is in the way."""


@dataclass
class Plan:
    """A plan in the making. `choice` is which of the ways to take things is tried.

    `opened` is how far (rad or m) joints have been moved from where they began, and `moved` by which motion (4, 4)
    things are elsewhere than at the start.
    """

    values: Values
    choice: int
    arms: dict[str, State]
    things: dict[str, Goods] = field(default_factory=dict)
    reaches: dict[str, Reach] = field(default_factory=dict)
    opened: dict[str, float] = field(default_factory=dict)
    moved: dict[str, Array] = field(default_factory=dict)

    def thing(self, action: Thing) -> Goods:
        """What an action is done to, as it is by then."""
        name = self.values.reference(action.name, "object")
        self._stays(action, name)
        if name not in self.things:
            try:
                self.things[name] = goods(self.values, name).put(self.motion(name))
            except ImpossibleValue as error:
                raise ImpossibleValue.of(_used(d, action) for d in error.diagnostics) from None
        return self.things[name]

    def motion(self, name: str) -> Array:
        """How a thing has moved since the start (4, 4)."""
        return self.moved.get(name, STILL)

    def frame(self, name: str) -> Array:
        """Where a thing is by then (4, 4)."""
        return np.asarray(self.motion(name) @ matrix(self.values.pose(name)))

    def _stays(self, action: Thing, name: str) -> None:
        """Complain if something else than a robot moves a thing before an arm has done with it."""
        ends = self.number(action, "start") + self.lasts(action)
        for other in moving(self.values):
            if self.values.reference(other.name, "object") == name and self.number(other, "start") < ends:
                raise ImpossibleValue(
                    f"`{other.name}` moves `{name}`, and a plan does not know where to",
                    action.place,
                    f"let `{action.of}` handle what no other action moves, or do it before that",
                    notes=(Note(f"`{other.name}` is here", other.place),),
                )

    def number(self, action: Thing, name: str) -> float:
        """An argument of an action."""
        return self.values.number(action.name, name)

    def lasts(self, action: Thing) -> float:
        """How long (s) an action takes."""
        return lasts(self.values, action)

    def go(self, action: Thing, legs: Sequence[Leg]) -> None:
        """Note the way of the arm, which is then where it ends."""
        arm = self.arms[action.of]
        try:
            angles = joints(arm.arm, arm.base, arm.q, arm.width, legs)
        except OutOfReachError as error:
            raise Unable(action, str(error), error.help, error.after) from None
        self.reaches[action.name] = Reach(action.of, times(legs[-1].until), angles, None)
        arm.q, arm.width = angles[-1, : len(arm.q)], legs[-1].width

    def hold(self, action: Thing, name: str, start: float, points: Sequence[tuple[float, float, float]]) -> None:
        """Let the arm hold a thing from `start` (s) on, by points as its tool sees them."""
        arm, end = self.arms[action.of], self.values.end
        ahead = tuple((x, y, z + arm.arm.reach) for x, y, z in points)
        held = Hold(name, start, max(end, start), ahead)
        self.reaches[action.name] = replace(self.reaches[action.name], hold=held)
        arm.held, arm.since = name, action.name

    def let_go(self, action: Thing, moment: float) -> None:
        """Let the arm let go at `moment` (s) of what it holds."""
        arm = self.arms[action.of]
        reach = self.reaches.get(arm.since)
        if reach and reach.hold:
            self.reaches[arm.since] = replace(reach, hold=replace(reach.hold, stop=moment))
        arm.held = arm.since = arm.wanted = ""

    def free(self, action: Thing) -> None:
        """Complain if the arm holds something."""
        if held := self.arms[action.of].held:
            raise ImpossibleValue(
                f"`{action.of}` holds `{held}`, so it cannot {action.verb}",
                action.place,
                "let it `place` or `drop` that first",
            )

    def wields(self, action: Thing) -> None:
        """Complain if the arm never took the thing that it is to move with its hand, or another one holds it, too."""
        name, arm = self.values.reference(action.name, "object"), self.arms[action.of]
        left_out = (t for t in self.values.spec.things if t.of == action.of and not self.values.there(t.name))
        if arm.wanted != name and not any(t.verb in TAKES for t in left_out):
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
        """The heading for a tool, of these or their opposites, that it has to turn least for; or another `choice`."""
        tool = self.arms[robot].tool
        fore = float(np.arctan2(tool[1, 0], tool[0, 0]))
        turns = (_wrapped(yaw + flip - fore) for yaw in yaws for flip in (0.0, np.pi))
        ways = sorted(turns, key=lambda way: (round(abs(way), 6), way))
        return fore + ways[self.choice % len(ways)]


def only(acts: Sequence[Thing]) -> Thing:
    """The only action, or a complaint that several do one thing together."""
    if len(acts) > 1:
        raise ImpossibleValue(
            f"two arms cannot {acts[1].verb} one thing together", acts[1].place, "let them push or lift it"
        )
    return acts[0]


def moving(values: Values) -> Iterator[Thing]:
    """The actions of no robot that move an object."""
    acts = (t for t in values.spec.things if t.kind == "action" and not t.of and t.verb != "paint")
    return (t for t in acts if "object" in t.properties and values.there(t.name))


def _used(diagnostic: Diagnostic, action: Thing) -> Diagnostic:
    """The same, told where something is done to what cannot be handled."""
    if diagnostic.place is None:
        return replace(diagnostic, place=action.place)
    return replace(diagnostic, place=action.place, notes=(Note("this one", diagnostic.place), *diagnostic.notes))


def _wrapped(angle: float) -> float:
    """The angle within half a turn."""
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def matrix(pose: Pose) -> Array:
    """A pose as a matrix (4, 4)."""
    transform = np.eye(4)
    transform[:3, 3] = pose.position
    for i, axis in enumerate(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))):
        transform[:3, i] = np.array(pose.apply(axis)) - transform[:3, 3]
    return transform
