"""What arms do is executed; what cars and walkers do is checked, but not yet executed."""

from __future__ import annotations

from dataclasses import replace

from wmspec.check.ir import TaskSpec, Thing, Value
from wmspec.diagnostics import ImpossibleValue
from wmspec.robots.plan import ARMS


def executable(spec: TaskSpec) -> bool:
    """Whether everything in the spec can be executed: whether all robots are arms."""
    return all(thing.model in ARMS for thing in spec.things if thing.kind == "robot")


def refuse(spec: TaskSpec) -> None:
    """Raise WmsError with its place if the spec has robots that are not arms."""
    if executable(spec):
        return
    for thing in spec.things:
        if thing.kind == "action" and thing.of and spec.thing(thing.of).model not in ARMS:
            raise ImpossibleValue(
                f"`{thing.of}.{thing.verb}` cannot be executed yet: it can only be checked", thing.place
            )
    for thing in spec.things:
        if thing.kind == "robot" and thing.model not in ARMS:
            raise ImpossibleValue(
                f"the robot `{thing.name}` cannot be executed yet: it can only be checked", thing.place
            )


def without(spec: TaskSpec) -> TaskSpec:
    """The spec without the robots that are not arms, what they do and what rides on them, such as can be staged."""
    robots = {t.name for t in spec.things if t.kind == "robot" and t.model not in ARMS}
    kept = tuple(
        t
        for t in spec.things
        if t.name not in robots and not (t.kind == "action" and t.of in robots) and not _on(t, robots)
    )
    left = {t.name for t in kept}
    seen = tuple(o for o in spec.observations if o.camera in left)
    return replace(spec, things=kept, observations=seen) if robots else spec


def _on(thing: Thing, robots: set[str]) -> bool:
    """Whether a camera rides on a robot."""
    ridden = thing.properties.get("ride") if thing.kind == "camera" else None
    return ridden is not None and isinstance(ridden.value, Value) and ridden.value.value in robots
