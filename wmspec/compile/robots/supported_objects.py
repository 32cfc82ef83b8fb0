"""What comes along with what an arm moves: what joints hold to it, and what lies on it or in it."""

from __future__ import annotations

import numpy as np

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import bounds
from wmspec.compile.robots.arm import Array
from wmspec.compile.robots.manipuland import together
from wmspec.compile.robots.planning import Plan
from wmspec.core.space import HERE
from wmspec.lang.check.ir.ir import Thing

BELOW, ABOVE = 0.002, 0.005  # m: what lies on or in something begins no lower than it, and no higher than so above it


def gang(made: Plan, action: Thing) -> set[str]:
    """What an action is done to, with all that joints hold to it, but for the joint that it opens."""
    values, name = made.values, made.values.reference(action.name, "object")
    but = values.reference(action.name, "joint") if action.verb in ("open", "close") else ""
    return {other for other in together(values, name, but) if not values.flag(other, "fixed")}


def riders(made: Plan, carriers: set[str]) -> set[str]:
    """The things that lie on these or in these, or on or in what does."""
    values, found, new = made.values, set[str](), carriers
    others = (t.name for t in values.spec.things if t.kind == "object" and t.name not in carriers)
    left = [name for name in others if values.there(name) and not values.flag(name, "fixed")]
    while new:
        new = {name for name in left if any(_lies(made, name, carrier) for carrier in new)}
        found |= new
        left = [name for name in left if name not in new]
    return found


def move(made: Plan, action: Thing, motion: Array) -> None:
    """Note that what an action is done to has moved (4, 4), and all that comes along."""
    carriers = gang(made, action)
    for name in carriers | riders(made, carriers):
        if name in made.things and name != made.values.reference(action.name, "object"):
            made.things[name] = made.things[name].put(motion)
        made.moved[name] = motion @ made.motion(name)


def _lies(made: Plan, name: str, carrier: str) -> bool:
    """Whether the middle of a thing is above the box of another, or in it, and its lower end no higher."""
    middle, half = _box(made, name)
    frame, (low, high) = made.frame(carrier), np.array(bounds(pieces(made.values, carrier), HERE))
    own = frame[:3, :3].T @ (middle - frame[:3, 3])
    across = ((low[:2] <= own[:2]) & (own[:2] <= high[:2])).all()
    return bool(across and low[2] - BELOW <= own[2] - half <= high[2] + ABOVE)


def _box(made: Plan, name: str) -> tuple[Array, float]:
    """The middle (3,) of a thing as it is by then, and half of how high it was at the start, m."""
    low, high = np.array(bounds(pieces(made.values, name), made.values.pose(name)))
    middle = made.motion(name) @ [*(low + high) / 2, 1.0]
    return middle[:3], float((high - low)[2] / 2)
