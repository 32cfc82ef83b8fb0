"""Base poses of robots."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.compile.layout import surfaces
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import Pose, from_ypr

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator


def base(values: Evaluator, robot: str) -> Pose:
    """Return the pose of a robot's base."""
    at, yaw = values.spot(robot), values.number(robot, "yaw")
    if values.has(robot, "on"):
        if len(at) == 3:
            raise ImpossibleValue(
                f"`{robot}` stands on something, so its place there is (x, y)", values.source_location(robot, "at")
            )
        return Pose(surfaces.top_point(values, values.reference(robot, "on"), at).middle, from_ypr(yaw))
    assert surfaces.is_point(at)
    return Pose(at if len(at) == 3 else (*at, 0.0), from_ypr(yaw))
