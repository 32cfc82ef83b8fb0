"""What robots do is checked, but not yet executed."""

from __future__ import annotations

from wmspec.check.ir import TaskSpec
from wmspec.errors import WmsError


def refuse(spec: TaskSpec) -> None:
    """Raise WmsError with its place if the spec has robots."""
    for thing in spec.things:
        if thing.kind == "action" and thing.of:
            raise WmsError(f"{thing.place}: `{thing.of}.{thing.verb}` cannot be executed yet: it can only be checked")
    for thing in spec.things:
        if thing.kind == "robot":
            raise WmsError(f"{thing.place}: the robot `{thing.name}` cannot be executed yet: it can only be checked")


def without(spec: TaskSpec) -> TaskSpec:
    """The spec without its robots and what they do, such as can be staged."""
    kept = tuple(t for t in spec.things if t.kind != "robot" and not (t.kind == "action" and t.of))
    return spec.model_copy(update={"things": kept}) if len(kept) < len(spec.things) else spec
