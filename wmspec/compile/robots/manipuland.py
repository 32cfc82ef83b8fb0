"""Things that are handled: how large and heavy they are, and where, as far as a plan knows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from wmspec.compile.layout.geometry import mass, pieces
from wmspec.compile.layout.solids import bounds
from wmspec.compile.robots.arm import Array, about, shift
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import HERE
from wmspec.sim.shapes.sphere import Sphere

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wmspec.compile.layout.values import Values

INSIDE = 0.25
"""So deep in a ball, in radii, fingers find hold: nearer to its rim they squeeze it out."""


@dataclass(frozen=True, eq=False)
class Goods:
    """A thing that stands upright: its box has half the edges `half` (3,) m in the frame `frame` (4, 4) of its middle.

    `slipped`: it was too heavy or too smooth for the hand that wanted to raise it, or the hand closed beside it.
    `ball`: the sphere that it is, if it is one.
    """

    name: str
    frame: Array
    half: tuple[float, float, float]
    mass: float
    friction: float
    slipped: bool = False
    ball: Sphere | None = None

    @property
    def middle(self) -> Array:
        """Where its middle is (3,) m."""
        return np.asarray(self.frame[:3, 3])

    @property
    def top(self) -> float:
        """How high it reaches, m."""
        return float(self.middle[2] + self.half[2])

    @property
    def yaw(self) -> float:
        """Its heading, rad."""
        return float(np.arctan2(self.frame[1, 0], self.frame[0, 0]))

    def moved(self, way: Sequence[float] | Array) -> Goods:
        """It, elsewhere; what has slipped stays."""
        return self.put(shift(*map(float, way)))

    def put(self, move: Array) -> Goods:
        """It, moved as a body (4, 4); what has slipped stays."""
        return self if self.slipped else replace(self, frame=move @ self.frame)

    def has(self, point: Array) -> bool:
        """Whether a hand at a point (3,), seen from above, is where it is: of a ball, well within it."""
        own = np.abs(self.seen(point))
        within = bool(own[0] <= self.half[0] and own[1] <= self.half[1])
        return within and (self.ball is None or self.ball.depth_at(own * (1, 1, 0))[0] > INSIDE * self.half[0])

    def seen(self, point: Array) -> Array:
        """A point (3,) in its own frame."""
        return np.asarray(self.frame[:3, :3].T @ (point - self.middle))

    def reach(self, way: Array) -> float:
        """How far (m) it reaches from its middle in a level direction, a unit vector (3,)."""
        own = np.abs(self.frame[:3, :3].T @ way)
        flat = np.maximum(np.array(self.half) / np.where(own > 1e-9, own, 1e-12), 0.0)
        return float(flat[:2].min())

    def across(self, tool: Array) -> float:
        """How wide (m) it is between the fingers of a tool."""
        own = np.abs(self.frame[:3, :3].T @ tool[:3, 1])
        return 2 * self.half[0 if own[0] > own[1] else 1]


def goods(values: Values, name: str) -> Goods:
    """A thing as it is at the start. Raises WmsError with its place if no hand can handle it."""
    made, pose = pieces(values, name), values.pose(name)
    if values.flag(name, "fixed"):
        raise ImpossibleValue(f"`{name}` is fixed, so no robot can move it", values.place(name))
    up = pose.seen((pose.position[0], pose.position[1], pose.position[2] + 1.0))
    if up[2] < 1 - 1e-6:
        raise ImpossibleValue(f"`{name}` does not stand upright, so no robot can handle it", values.place(name))
    low, high = (np.array(corner) for corner in bounds(made, HERE))
    frame = shift(*pose.position) @ about(2, values.number(name, "yaw")) @ shift(*((low + high) / 2).tolist())
    half = ((high - low) / 2).tolist()
    lone = made[0].solid if len(made) == 1 and isinstance(made[0].solid, Sphere) else None
    return Goods(
        name,
        frame,
        (half[0], half[1], half[2]),
        mass(values, name),
        values.number(name, "friction"),
        ball=lone,
    )


def together(values: Values, name: str, but: str = "") -> set[str]:
    """An object and all that joints, `but` for one, join to it."""
    joined, left = {name}, [t for t in values.spec.things if t.kind == "joint" and t.name != but]
    ends = [set(values.ends(t.name)) for t in left]
    for _ in ends:
        for pair in ends:
            if pair & joined:
                joined |= pair
    return joined
