"""When robots act: one thing at a time each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.check.ir.ir import Thing

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

OPENS = 0.4  # s: how long a hand takes to open


def lasts(values: Values, action: Thing) -> float:
    """How long (s) an action takes."""
    return values.number(action.name, "duration") if "duration" in action.properties else OPENS


def in_turn(values: Values, models: Sequence[str]) -> list[Thing]:
    """What robots of these models do, in order of time.

    Raises WmsError with its place if one begins while its robot is busy.
    """
    robots = {t.name for t in values.spec.things if t.kind == "robot" and t.model in models}
    acts = [t for t in values.spec.things if t.kind == "action" and t.of in robots and values.there(t.name)]
    acts.sort(key=lambda a: values.number(a.name, "start"))
    free: dict[str, float] = {}
    for action in acts:
        start = values.number(action.name, "start")
        if start < free.get(action.of, 0.0) - 1e-9:
            what = f"`{action.of}` is still busy when `{action.name}` starts"
            raise ImpossibleValue(what, action.place, f"let it start at {free[action.of]:g} s or later")
        free[action.of] = start + lasts(values, action)
    return acts
