"""Where robots stand."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.compile.layout import surfaces
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import Pose, turn

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values


def base(values: Values, robot: str) -> Pose:
    """Where a robot stands."""
    at, yaw = values.spot(robot), values.number(robot, "yaw")
    if values.has(robot, "on"):
        if len(at) == 3:
            raise ImpossibleValue(
                f"`{robot}` stands on something, so its place there is (x, y)", values.place(robot, "at")
            )
        return Pose(surfaces.top(values, values.reference(robot, "on"), at).middle, turn(yaw))
    assert surfaces.is_point(at)
    return Pose(at if len(at) == 3 else (*at, 0.0), turn(yaw))
