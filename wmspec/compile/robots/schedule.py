"""Schedule of robots' actions: one at a time for each robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.check.ir.ir import Entity

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

HAND_OPENING_TIME = 0.4  # s


def action_duration(values: Evaluator, action: Entity) -> float:
    """Return the duration (s) of an action."""
    return values.number(action.name, "duration") if "duration" in action.properties else HAND_OPENING_TIME


def actions_in_order(values: Evaluator, models: Sequence[str]) -> list[Entity]:
    """Return the actions of robots of these models in order of time.

    Raises WmsError with its location if one begins while its robot is busy.
    """
    robots = {t.name for t in values.spec.things if t.kind == "robot" and t.model in models}
    acts = [t for t in values.spec.things if t.kind == "action" and t.of in robots and values.is_present(t.name)]
    acts.sort(key=lambda a: values.number(a.name, "start"))
    free: dict[str, float] = {}
    for action in acts:
        start = values.number(action.name, "start")
        if start < free.get(action.of, 0.0) - 1e-9:
            what = f"`{action.of}` is still busy when `{action.name}` starts"
            raise ImpossibleValue(what, action.place, f"let it start at {free[action.of]:g} s or later")
        free[action.of] = start + action_duration(values, action)
    return acts
