"""Plans all arms before the episode: joint trajectories and holds.

A plan depends on initial poses and earlier actions of the arms only; no measurements.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from wmspec.compile.layout.placement import base
from wmspec.compile.robots import grasps, moves
from wmspec.compile.robots.arm import Arm
from wmspec.compile.robots.collision import collision
from wmspec.compile.robots.franka import PANDA
from wmspec.compile.robots.manipuland import Manipuland
from wmspec.compile.robots.planning import ArmState, PathBlockedError, Plan, PlanningError, Reach, matrix
from wmspec.compile.robots.schedule import actions_in_order
from wmspec.compile.robots.supported_objects import record_motion
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.check.ir.ir import Entity
from wmspec.lang.parse.files import resolve_display_path

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

ARMS = ("panda", "arm")
"""Robot models that are arms."""

_VERBS: dict[str, Callable[[Plan, Sequence[Entity], Manipuland], Manipuland]] = {
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
"""Planner of each verb, given its simultaneous actions and the object; returns the object afterwards."""


def arm_of(values: Evaluator, robot: str) -> Arm:
    """Return the arm of a robot. Raises WmsError with its location if its file has none."""
    if values.spec.thing(robot).model == "panda":
        return PANDA
    from wmspec.compile.robots.arm_assets import read_arm

    try:
        return read_arm(resolve_display_path(values.text(robot, "model")))
    except ImpossibleValue as error:
        raise error.at(values.source_location(robot, "model")) from None


def plan(values: Evaluator) -> dict[str, Reach]:
    """Return the motions of all arms, by the names of the actions.

    Raises WmsError with its location for infeasible actions.
    """
    return values.memoized(("", "robots"), lambda: _plan(values))


def _plan(values: Evaluator) -> dict[str, Reach]:
    """Return the first successful plan; a hand can grasp an object in several ways."""
    problems: list[PlanningError] = []
    for choice in range(4):
        try:
            return _attempt(values, choice)
        except PlanningError as unable:
            problems.append(unable)
    # a collision is a better explanation than an unreachable alternative grasp
    problem = min(problems, key=lambda unable: not isinstance(unable, PathBlockedError))
    action = problem.action
    raise ImpossibleValue(f"`{action.of}` cannot {action.verb} so: {problem.reason}", action.place, problem.help)


def _attempt(values: Evaluator, choice: int) -> dict[str, Reach]:
    arms = {
        t.name: ArmState(arm := arm_of(values, t.name), matrix(base(values, t.name)), arm.rest, arm.opening)
        for t in values.spec.things
        if t.kind == "robot" and t.model in ARMS
    }
    made = Plan(values, choice, arms)
    acts = actions_in_order(values, ARMS)
    for _, together in groupby(
        acts, key=lambda a: (a.verb, made.number(a, "start"), values.reference(a.name, "object"))
    ):
        every = list(together)
        thing = made.thing(every[0])
        after = _VERBS[every[0].verb](made, every, thing)
        for action in every:
            if touched := collision(made, action, thing):
                raise PathBlockedError(action, *touched)
        made.things[thing.name] = after
        if after.frame is not thing.frame:
            record_motion(made, every[0], after.frame @ np.linalg.inv(thing.frame))
    return made.reaches
