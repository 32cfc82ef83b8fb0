"""The views of a task: camera, time, and channels."""

from __future__ import annotations

from wmspec.lang.check.ir.evaluate import Environment, evaluate
from wmspec.lang.check.ir.ir import Channel, TaskSpec

#: A camera and a time (s).
View = tuple[str, float]


def views_of(spec: TaskSpec, values: Environment) -> list[View]:
    """Return the views that a task shows, in order."""
    return [(o.camera, time) for o in spec.observations for time in evaluate(o.times, values)]


def channels_of(spec: TaskSpec) -> frozenset[Channel]:
    """Return the channels of every shown picture: colour, and those that observations request."""
    return frozenset[Channel]({"rgb"}).union(*(o.channels for o in spec.observations))
