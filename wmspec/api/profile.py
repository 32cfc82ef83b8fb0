"""Profiles: the tasks of another benchmark, asked as it asks them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, get_args

from wmspec.api.task import Task
from wmspec.core.diagnostics import WmsError
from wmspec.core.wm_abench import COLUMNS, Column
from wmspec.lang.check.ir.ir import Items, Observation, TaskSpec

Profile = Literal["", "wm-abench"]


def check_profile(name: str) -> Profile:
    """Return the name of a profile; "" for none. Raises WmsError if there is no such profile."""
    if name not in get_args(Profile):
        raise WmsError(f"no profile {name!r}", help="the only profile is wm-abench")
    return name  # type: ignore[return-value]


def with_profile(tasks: Sequence[Task], profile: Profile) -> tuple[Task, ...]:
    """Return the tasks of a profile among `tasks`, in its order; all of them without a profile.

    `wm-abench` has the columns of the paper. Each task asks one kind of question, with as many pictures as the paper
    shows: the first, the last, and others at even distances.

    Raises WmsError if no task belongs to the profile, or a task shows fewer pictures than the paper.
    """
    if not profile:
        return tuple(tasks)
    by_column = {task.paper: task for task in tasks if task.paper}
    if not by_column:
        raise WmsError("none of the tasks rebuilds a column of WM-ABench", help="leave out SPECS to take all of them")
    return tuple(replace(by_column[c], spec=_faithful(by_column[c].spec, c)) for c in COLUMNS if c in by_column)


def _faithful(spec: TaskSpec, column: Column) -> TaskSpec:
    question = next((q for q in spec.questions if q.name == column.question), spec.questions[0])
    shown = [observation.times for observation in spec.observations]
    lengths = [len(times.items) for times in shown if isinstance(times, Items)]
    observations = spec.observations
    if len(lengths) == len(shown) == 1:
        observations = (_thinned(spec.observations[0], column.images, spec.name),)
    return replace(spec, questions=(question,), observations=observations)


def _thinned(observation: Observation, count: int, task: str) -> Observation:
    """Return an observation with `count` of its times, evenly spaced."""
    assert isinstance(observation.times, Items)
    items = observation.times.items
    if len(items) < count:
        raise WmsError(f"`{task}` shows {len(items)} pictures, and the paper {count}")
    chosen = tuple(items[round(n * (len(items) - 1) / max(1, count - 1))] for n in range(count))
    return replace(observation, times=replace(observation.times, items=chosen))
