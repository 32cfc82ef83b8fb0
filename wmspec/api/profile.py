"""Profiles: the tasks of another benchmark, asked as it asks them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError
from wmspec.core.wm_abench import COLUMNS, Column
from wmspec.lang.check.ir.ir import Items, TaskSpec, Value

Profile = Literal["", "wm-abench"]


def check_profile(name: str) -> Profile:
    """Return the name of a profile; "" for none. Raises WmsError if there is no such profile."""
    if name not in get_args(Profile):
        raise WmsError(f"no profile {name!r}", help="the only profile is wm-abench")
    return name  # type: ignore[return-value]


def with_profile(tasks: Sequence[Task], profile: Profile) -> tuple[Task, ...]:
    """Return the tasks of a profile among `tasks`, in its order; all of them without a profile.

    `wm-abench` has the columns of the paper. Each task asks one kind of question, with as many pictures as the paper
    shows: the first, the last, and others at even distances, at the spec's own times where it shows enough. A text that
    speaks of its pictures keeps them all.

    Raises WmsError if no task belongs to the profile.
    """
    if not profile:
        return tuple(tasks)
    by_column = {task.paper: task for task in tasks if task.paper}
    if not by_column:
        raise WmsError("none of the tasks rebuilds a column of WM-ABench", help="leave out SPECS to take all of them")
    return tuple(replace(by_column[c], spec=_faithful(by_column[c].spec, c)) for c in COLUMNS if c in by_column)


def _faithful(spec: TaskSpec, column: Column) -> TaskSpec:
    question = next((q for q in spec.questions if q.name == column.question), spec.questions[0])
    speaks_of_pictures = any("picture" in part for part in question.text if isinstance(part, str))
    first, *others = spec.observations
    if not others and isinstance(first.times, Items) and not speaks_of_pictures:
        times = _evenly(first.times, column.images)
        return replace(spec, questions=(question,), observations=(replace(first, times=times),))
    return replace(spec, questions=(question,))


def _evenly(times: Items, count: int) -> Items:
    """Return `count` of the times at even distances, from the first to the last; between them if there are fewer."""
    places = np.linspace(0, len(times.items) - 1, count)
    known = [float(item.value) for item in times.items if isinstance(item, Value)]
    if len(known) == len(times.items) < count:
        moments = np.interp(places, np.arange(len(known)), known)
        return replace(times, items=tuple(Value(value=float(moment)) for moment in moments))
    return replace(times, items=tuple(times.items[round(place)] for place in places))
