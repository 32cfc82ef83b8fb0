"""Poses of objects: explicit, resting exactly on a surface, or in the cavity of a compound object; and of robots."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.compile.layout import assets, scatter, surfaces
from wmspec.compile.layout.geometry import own_rotation
from wmspec.compile.layout.solids import Face, reach
from wmspec.compile.layout.surfaces import Spot, contact_face, is_point
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import Pose, add, align_z, from_ypr, inverse, multiply, rotate, scale

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator


def pose(values: Evaluator, owner: str) -> Pose:
    """Return the initial pose of an object: its resting pose, or above it if it is dropped.

    A link of an asset is placed by the asset's frame and the joints in between.
    """
    base = assets.base(values, owner)
    if base is None:
        return _own_placement(values, owner)
    return frame(values, base).compose(assets.pose_in_asset(values, owner))


def frame(values: Evaluator, base: str) -> Pose:
    """Return the pose of an asset's frame, given its base."""
    return values.memoized((base, "frame"), lambda: _own_placement(values, base))


def _own_placement(values: Evaluator, owner: str) -> Pose:
    """Return the pose of an object by its own placement, or of an asset's frame by its base."""
    at = scatter.scattered_position(values, owner) if values.has(owner, "scatter") else values.spot(owner)
    resting = rest(values, owner, at, *own_rotation(values, owner))
    links = assets.links(values, owner)
    heights = [values.number(a.name, "height") for link in links for a in values.actions_on("drop", link)]
    return Pose(add(resting.position, (0.0, 0.0, max(heights))), resting.orientation) if heights else resting


def rest(values: Evaluator, owner: str, at: Spot, yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Pose:
    """Return the pose of an object with this rotation and `at`: (x, y) on its support, else (x, y) or (x, y, z)."""
    own = from_ypr(yaw, pitch, roll)
    face = contact_face(values, owner, at)
    if face is None:
        if is_point(at) and len(at) == 3:
            return Pose(at, own)
        x, y = at[-2:]
        face = Face((x, y, 0.0))
    depth = reach(assets.pieces(values, owner), rotate(inverse(own), (0.0, 0.0, -1.0)))
    return Pose(add(face.middle, scale(depth, face.normal)), multiply(align_z(face.normal), own))


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
