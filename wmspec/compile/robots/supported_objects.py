"""Objects that move along with a manipulated one: joined to it, on it or in it."""

from __future__ import annotations

import numpy as np

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import bounds
from wmspec.compile.robots.arm import Array
from wmspec.compile.robots.manipuland import joined_objects
from wmspec.compile.robots.planning import Plan
from wmspec.core.space import IDENTITY
from wmspec.lang.check.ir.ir import Entity

MAX_SINK, MAX_GAP = (
    0.002,
    0.005,
)  # m: of a supported object's bottom


def rigid_group(made: Plan, action: Entity) -> set[str]:
    """Return the object of an action and all movable objects joined to it, except by the joint that it opens."""
    values, name = made.values, made.values.reference(action.name, "object")
    but = values.reference(action.name, "joint") if action.verb in ("open", "close") else ""
    return {other for other in joined_objects(values, name, but) if not values.flag(other, "fixed")}


def supported_objects(made: Plan, carriers: set[str]) -> set[str]:
    """Return the objects that rest on or in these, directly or indirectly."""
    values, found, new = made.values, set[str](), carriers
    others = (t.name for t in values.spec.things if t.kind == "object" and t.name not in carriers)
    left = [name for name in others if values.is_present(name) and not values.flag(name, "fixed")]
    while new:
        new = {name for name in left if any(_is_supported(made, name, carrier) for carrier in new)}
        found |= new
        left = [name for name in left if name not in new]
    return found


def record_motion(made: Plan, action: Entity, motion: Array) -> None:
    """Apply `motion` (4, 4) to the manipulated object and everything attached to it."""
    carriers = rigid_group(made, action)
    for name in carriers | supported_objects(made, carriers):
        if name in made.things and name != made.values.reference(action.name, "object"):
            made.things[name] = made.things[name].put(motion)
        made.moved[name] = motion @ made.motion(name)


def _is_supported(made: Plan, name: str, carrier: str) -> bool:
    """Whether the centre of an object is above or in the box of another, and its bottom no lower."""
    middle, half = _center_and_half_height(made, name)
    frame, (low, high) = made.frame(carrier), np.array(bounds(pieces(made.values, carrier), IDENTITY))
    own = frame[:3, :3].T @ (middle - frame[:3, 3])
    across = ((low[:2] <= own[:2]) & (own[:2] <= high[:2])).all()
    return bool(across and low[2] - MAX_SINK <= own[2] - half <= high[2] + MAX_GAP)


def _center_and_half_height(made: Plan, name: str) -> tuple[Array, float]:
    """Return the planned centre (3,) of an object, and half its initial height (m)."""
    low, high = np.array(bounds(pieces(made.values, name), made.values.pose(name)))
    middle = made.motion(name) @ [*(low + high) / 2, 1.0]
    return middle[:3], float((high - low)[2] / 2)
