"""What arms do, planned before anything moves: the way of their joints, and what they hold when.

A plan goes by where things are at the start and by what has been done to them since; nothing is measured.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from wmspec.compile.robots import grasps, moves
from wmspec.compile.robots.arm import Arm
from wmspec.compile.robots.base_pose import base
from wmspec.compile.robots.collision import collision
from wmspec.compile.robots.franka import PANDA
from wmspec.compile.robots.manipuland import Goods
from wmspec.compile.robots.planning import Blocked, Plan, Reach, State, Unable, matrix
from wmspec.compile.robots.schedule import in_turn
from wmspec.compile.robots.supported_objects import move
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.check.ir.ir import Thing
from wmspec.lang.parse.files import located

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

ARMS = ("panda", "arm")
"""The models of robots that are arms."""

_VERBS: dict[str, Callable[[Plan, Sequence[Thing], Goods], Goods]] = {
    "pick": grasps.pick,
    "grasp": grasps.grasp,
    "lift": grasps.lift,
    "place": grasps.place,
    "drop": grasps.drop,
    "push": moves.push,
    "carry": moves.carry,
    "rotate": moves.rotate,
    "tilt": moves.tilt,
    "open": moves.open_,
    "close": moves.close,
}
"""Verb -> what plans it, given the actions that do it together, and the thing; returns the thing as it is then."""


def arm_of(values: Values, robot: str) -> Arm:
    """The arm that a robot is. Raises WmsError with its place if its file has none."""
    if values.spec.thing(robot).model == "panda":
        return PANDA
    from wmspec.compile.robots.arm_assets import arm_in

    try:
        return arm_in(located(values.text(robot, "model")))
    except ImpossibleValue as error:
        raise error.at(values.place(robot, "model")) from None


def plan(values: Values) -> dict[str, Reach]:
    """The reaches of all arms, by the names of the actions.

    Raises WmsError with its place for what an arm cannot do.
    """
    return values.once(("", "robots"), lambda: _plan(values))


def _plan(values: Values) -> dict[str, Reach]:
    """The first plan that succeeds: a hand can take a thing in several ways."""
    problems: list[Unable] = []
    for choice in range(4):
        try:
            return _tried(values, choice)
        except Unable as unable:
            problems.append(unable)
    # that something is in the way tells more than that another hand's turn would be out of reach
    told = min(problems, key=lambda unable: not isinstance(unable, Blocked))
    action = told.action
    raise ImpossibleValue(f"`{action.of}` cannot {action.verb} so: {told.reason}", action.place, told.help)


def _tried(values: Values, choice: int) -> dict[str, Reach]:
    arms = {
        t.name: State(arm := arm_of(values, t.name), matrix(base(values, t.name)), arm.rest, arm.opening)
        for t in values.spec.things
        if t.kind == "robot" and t.model in ARMS
    }
    made = Plan(values, choice, arms)
    acts = in_turn(values, ARMS)
    for _, together in groupby(
        acts, key=lambda a: (a.verb, made.number(a, "start"), values.reference(a.name, "object"))
    ):
        every = list(together)
        thing = made.thing(every[0])
        after = _VERBS[every[0].verb](made, every, thing)
        for action in every:
            if touched := collision(made, action, thing):
                raise Blocked(action, *touched)
        made.things[thing.name] = after
        if after.frame is not thing.frame:
            move(made, every[0], after.frame @ np.linalg.inv(thing.frame))
    return made.reaches
