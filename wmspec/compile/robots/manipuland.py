"""Manipulated objects: size, mass and planned pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from wmspec.compile.layout.geometry import mass, pieces
from wmspec.compile.layout.solids import bounds
from wmspec.compile.robots.arm import Array, axis_rotation, translation
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import IDENTITY
from wmspec.sim.shapes.sphere import Sphere

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wmspec.compile.layout.evaluator import Evaluator

GRASP_DEPTH = 0.25
"""Minimum depth of a grasp in a ball, in radii; nearer to the rim the ball slips out."""


@dataclass(frozen=True, eq=False)
class Manipuland:
    """An upright object with the half edges `half` (3,) m in the frame `frame` (4, 4) of its centre.

    `slipped`: it was too heavy or too smooth for a hand that raised it, or the hand closed beside it. `ball`: its
    sphere, if it is one.
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
        """Its centre (3,) m."""
        return np.asarray(self.frame[:3, 3])

    @property
    def top(self) -> float:
        """Height of its top, m."""
        return float(self.middle[2] + self.half[2])

    @property
    def yaw(self) -> float:
        """Its heading, rad."""
        return float(np.arctan2(self.frame[1, 0], self.frame[0, 0]))

    def moved(self, way: Sequence[float] | Array) -> Manipuland:
        """Return it translated; a slipped object stays."""
        return self.put(translation(*map(float, way)))

    def put(self, move: Array) -> Manipuland:
        """Return it after a rigid motion (4, 4); a slipped object stays."""
        return self if self.slipped else replace(self, frame=move @ self.frame)

    def has(self, point: Array) -> bool:
        """Whether a point (3,), seen from above, is within it; for a ball, deep enough for a grasp."""
        own = np.abs(self.to_local(point))
        within = bool(own[0] <= self.half[0] and own[1] <= self.half[1])
        return within and (self.ball is None or self.ball.depth_at(own * (1, 1, 0))[0] > GRASP_DEPTH * self.half[0])

    def to_local(self, point: Array) -> Array:
        """Return a point (3,) in its frame."""
        return np.asarray(self.frame[:3, :3].T @ (point - self.middle))

    def reach(self, way: Array) -> float:
        """Return its support distance (m) in a horizontal direction, a unit vector (3,)."""
        own = np.abs(self.frame[:3, :3].T @ way)
        flat = np.maximum(np.array(self.half) / np.where(own > 1e-9, own, 1e-12), 0.0)
        return float(flat[:2].min())

    def across(self, tool: Array) -> float:
        """Return its width (m) between the fingers of a tool."""
        own = np.abs(self.frame[:3, :3].T @ tool[:3, 1])
        return 2 * self.half[0 if own[0] > own[1] else 1]


def manipuland_of(values: Evaluator, name: str) -> Manipuland:
    """Return an object in its initial state. Raises WmsError with its location if no hand can handle it."""
    made, pose = pieces(values, name), values.pose(name)
    if values.flag(name, "fixed"):
        raise ImpossibleValue(
            f"`{name}` is fixed, so no robot can move it", values.source_location(name), "let it be `fixed: false`"
        )
    up = pose.inverse_apply((pose.position[0], pose.position[1], pose.position[2] + 1.0))
    if up[2] < 1 - 1e-6:
        raise ImpossibleValue(
            f"`{name}` does not stand upright, so no robot can handle it", values.source_location(name)
        )
    low, high = (np.array(corner) for corner in bounds(made, IDENTITY))
    frame = (
        translation(*pose.position)
        @ axis_rotation(2, values.number(name, "yaw"))
        @ translation(*((low + high) / 2).tolist())
    )
    half = ((high - low) / 2).tolist()
    lone = made[0].solid if len(made) == 1 and isinstance(made[0].solid, Sphere) else None
    return Manipuland(
        name,
        frame,
        (half[0], half[1], half[2]),
        mass(values, name),
        values.number(name, "friction"),
        ball=lone,
    )


def joined_objects(values: Evaluator, name: str, but: str = "") -> set[str]:
    """Return an object and all objects connected to it by joints, except the joint `but`."""
    joined, left = {name}, [t for t in values.spec.things if t.kind == "joint" and t.name != but]
    ends = [set(values.ends(t.name)) for t in left]
    for _ in ends:
        for pair in ends:
            if pair & joined:
                joined |= pair
    return joined
