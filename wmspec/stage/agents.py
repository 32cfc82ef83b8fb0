"""What arms do is executed; what cars and walkers do is checked, but not yet executed."""

from __future__ import annotations

from dataclasses import replace

from wmspec.check.ir import TaskSpec, Thing, Value
from wmspec.diagnostics import ImpossibleValue


def is_arm(model: str) -> bool:
    """Whether a robot is an arm. Planning needs numpy, which specs without robots do not wait for."""
    from wmspec.robots.plan import ARMS

    return model in ARMS


def executable(spec: TaskSpec) -> bool:
    """Whether everything in the spec can be executed: whether all robots are arms."""
    return all(is_arm(thing.model) for thing in spec.things if thing.kind == "robot")


def refuse(spec: TaskSpec) -> None:
    """Raise WmsError with its place if the spec has robots that are not arms."""
    if executable(spec):
        return
    for thing in spec.things:
        if thing.kind == "action" and thing.of and not is_arm(spec.thing(thing.of).model):
            raise ImpossibleValue(
                f"`{thing.of}.{thing.verb}` cannot be executed yet: it can only be checked", thing.place
            )
    for thing in spec.things:
        if thing.kind == "robot" and not is_arm(thing.model):
            raise ImpossibleValue(
                f"the robot `{thing.name}` cannot be executed yet: it can only be checked", thing.place
            )


def without(spec: TaskSpec) -> TaskSpec:
    """The spec without the robots that are not arms, what they do and what rides on them, such as can be staged."""
    robots = {t.name for t in spec.things if t.kind == "robot" and not is_arm(t.model)}
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
