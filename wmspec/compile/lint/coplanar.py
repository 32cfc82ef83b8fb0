"""Horizontal faces of drawn things that lie in one plane: which of them a picture shows depends on the renderer."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import all_pieces
from wmspec.compile.layout.solids import Box, PlacedShape, bounds
from wmspec.compile.lint.visibility import is_in_view
from wmspec.core.space import IDENTITY, Vector, add, scale

if TYPE_CHECKING:  # imported late: few scenes have faces at equal heights, and importing numpy slows their check
    from wmspec.sim.scene import model

#: The depth buffers of renderers do not distinguish faces that are nearer than this (m).
SAME_HEIGHT = 2e-4
#: Shared width (m) below which faces only touch, and the number of points along it that are compared.
MIN_WIDTH, POINTS = 5e-3, 7
#: Share of the picture's width below which a shared place is too small to matter.
MIN_SHARE = 3 / 256
#: The properties that decide the look of a part.
_LOOK = ("color", "material")
#: What may lie above a face and hide it begins less than this (m) above it.
COVER = 2e-3


@dataclass(frozen=True)
class Coplanar:
    """Two parts, or objects without parts, with different looks and upward faces at one height (m)."""

    first: str
    second: str
    height: float


@dataclass(frozen=True)
class _Drawn:
    """A drawn piece in the world, with its axis-aligned box."""

    part: str
    look: tuple[object, ...]
    piece: PlacedShape
    low: Vector
    high: Vector


def coplanar_faces(values: Evaluator) -> Iterator[Coplanar]:
    """Yield pairs of drawn pieces whose upward faces share a place, seen from above, at the start."""
    drawn = sorted(_drawn(values), key=lambda one: one.high[2])
    for i, one in enumerate(drawn):
        for other in drawn[i + 1 :]:
            if other.high[2] - one.high[2] > SAME_HEIGHT:
                break
            if one.look != other.look and _share_a_face(values, one, other, drawn):
                yield Coplanar(one.part, other.part, other.high[2])


def _drawn(values: Evaluator) -> Iterator[_Drawn]:
    for thing in values.spec.things:
        name = thing.name
        if thing.kind != "object" or not values.is_present(name):
            continue
        pose = values.pose(name)
        for part, piece in all_pieces(values, name):
            if all(values.flag(owner, "drawn") for owner in {name, part} if values.has(owner, "drawn")):
                placed = PlacedShape(piece.solid, pose.compose(piece.pose))
                yield _Drawn(part, _look(values, part, name), placed, *bounds((placed,), IDENTITY))


def _look(values: Evaluator, part: str, name: str) -> tuple[object, ...]:
    """Return what decides the look of a part."""
    owners = [next((o for o in (part, name) if values.has(o, word)), "") for word in _LOOK]
    return tuple(values.property(o, word) if o else None for o, word in zip(owners, _LOOK, strict=True))


def _share_a_face(values: Evaluator, one: _Drawn, other: _Drawn, drawn: Sequence[_Drawn]) -> bool:
    """Whether two pieces of about the same height have upward faces that share a place that can be seen."""
    low = [max(a, b) for a, b in zip(one.low[:2], other.low[:2], strict=True)]
    high = [min(a, b) for a, b in zip(one.high[:2], other.high[:2], strict=True)]
    if any(b - a < MIN_WIDTH for a, b in zip(low, high, strict=True)):
        return False
    height = other.high[2]
    if not _is_seen(values, ((low[0], low[1], height), (high[0], high[1], height))):
        return False
    steps = [(k + 0.5) / POINTS for k in range(POINTS)]
    points = [(low[0] + s * (high[0] - low[0]), low[1] + t * (high[1] - low[1])) for s, t in product(steps, steps)]
    above = [
        each
        for each in drawn
        if each.low[2] < height + COVER < each.high[2] + COVER and each.high[2] > height + SAME_HEIGHT
    ]
    seen = [point for point in points if not any(_is_below(each, point) for each in above)]
    faces = [_top_faces(each.piece, each.high[2]) for each in (one, other)]
    return any(all(_is_on(triangles, point) for triangles in faces) for point in seen)


def _is_seen(values: Evaluator, box: Box) -> bool:
    """Whether a level rectangle is seen from above, and large enough, by an observed camera that does not ride."""
    cameras = dict.fromkeys(o.camera for o in values.spec.observations)
    still = (camera for camera in cameras if not values.has(camera, "ride"))
    return any(_is_seen_by(values, camera, box) for camera in still)


def _is_seen_by(values: Evaluator, camera: str, box: Box) -> bool:
    eye, (low, high) = values.vector(camera, "at"), box
    width = min(high[0] - low[0], high[1] - low[1])
    across = 2 * math.dist(eye, scale(0.5, add(low, high))) * math.tan(values.number(camera, "fov") / 2)
    return eye[2] > high[2] and width > MIN_SHARE * across and is_in_view(values, camera, box)


def _is_below(cover: _Drawn, point: tuple[float, float]) -> bool:
    return all(low <= x <= high for x, low, high in zip(point, cover.low[:2], cover.high[:2], strict=True))


def _top_faces(piece: PlacedShape, height: float) -> model.Array:
    """Return the corners (n, 3, 2), seen from above, of the triangles of a piece that lie at its greatest height."""
    import numpy as np

    points, faces = piece.solid.triangles()
    corners = np.array([piece.pose.apply(tuple(point)) for point in points])[faces]
    heights = corners[:, :, 2]
    level = (np.ptp(heights, axis=1) < 1e-6) & (np.abs(heights[:, 0] - height) < SAME_HEIGHT)
    found: model.Array = corners[level][:, :, :2]
    return found


def _is_on(triangles: model.Array, point: tuple[float, float]) -> bool:
    """Whether a point is within one of the triangles (n, 3, 2)."""
    import numpy as np

    edges = np.roll(triangles, -1, axis=1) - triangles
    away = np.array(point) - triangles
    sides = edges[..., 0] * away[..., 1] - edges[..., 1] * away[..., 0]
    return bool(((sides > 0).all(axis=1) | (sides < 0).all(axis=1)).any())
