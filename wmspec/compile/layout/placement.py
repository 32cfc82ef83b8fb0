"""Where objects are: placed outright, resting on a surface exactly, or in the hollow of a compound object."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmspec.compile.layout import assets, scatter
from wmspec.compile.layout.geometry import own_turn
from wmspec.compile.layout.solids import Face, reach
from wmspec.compile.layout.surfaces import Spot, is_point, under
from wmspec.core.space import Pose, add, inverse, multiply, rotate, tilt, times, turn

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values


def pose(values: Values, owner: str) -> Pose:
    """Where an object is at the start: its resting place, or above it if it is going to be dropped.

    A link of an asset is where its asset and the joints between take it.
    """
    base = assets.base(values, owner)
    if base is None:
        return _placed(values, owner)
    return frame(values, base).then(assets.within(values, owner))


def frame(values: Values, base: str) -> Pose:
    """Where the frame of an asset is, by its base."""
    return values.once((base, "frame"), lambda: _placed(values, base))


def _placed(values: Values, owner: str) -> Pose:
    """Where an object is itself placed, or the frame of an asset by its base."""
    at = scatter.place(values, owner) if values.has(owner, "scatter") else values.spot(owner)
    resting = rest(values, owner, at, *own_turn(values, owner))
    links = assets.links(values, owner)
    heights = [values.number(a.name, "height") for link in links for a in values.acting("drop", link)]
    return Pose(add(resting.position, (0.0, 0.0, max(heights))), resting.orientation) if heights else resting


def rest(values: Values, owner: str, at: Spot, yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Pose:
    """Where an object turned like that would be with this `at`: (x, y) on what holds it, else (x, y) or (x, y, z)."""
    own = turn(yaw, pitch, roll)
    face = under(values, owner, at)
    if face is None:
        if is_point(at) and len(at) == 3:
            return Pose(at, own)
        x, y = at[-2:]
        face = Face((x, y, 0.0))
    depth = reach(assets.pieces(values, owner), rotate(inverse(own), (0.0, 0.0, -1.0)))
    return Pose(add(face.middle, times(depth, face.normal)), multiply(tilt(face.normal), own))
