"""Soft contact shadows: bodies occlude ambient light on nearby surfaces.

A post-process that needs depth and camera only. Depths are equal in all engines, so the shadows are too. A shape
occludes like the nearest sphere inside its box: a sphere of radius r at distance d hides the fraction cos(n, d) r²/d²
of the light on a surface with normal n (Siegel and Howell, "Thermal Radiation Heat Transfer", configuration factors).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array, Body, Camera, Pose, Scene, Shot
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.scene.model.transform import apply, compose, identity, inverse, rotation
from wmspec.sim.scene.render.picture import Image, quantize
from wmspec.sim.scene.render.surfaces import ImageRegion, rays, surfaces
from wmspec.sim.shapes import Shape
from wmspec.sim.shapes.facets import tessellate

STRENGTH = 0.6
"""Fraction of light lost by a surface that faces a touching sphere."""

MAX_LOSS = 0.6
"""Upper bound of the loss, for any number of bodies."""

SHADOW_REACH = 3.0
"""Distance from the nearest sphere, in radii, beyond which nothing is lost."""

MAX_STATIC_SIZE = 0.4
"""Static bodies cast contact shadows if they collide and half their diagonal (m) is at most this."""

MIN_THICKNESS = 0.2
"""Shapes thinner than this fraction of the thickest shape of the body are ignored: labels, pips, stems."""

MAX_CUTS, MAX_CUT_VOLUME = 3, 0.75
"""A shape is halved up to this number of times while both boxes have at most `MAX_CUT_VOLUME` of its volume."""


@dataclass(frozen=True)
class RoundedBox:
    """A rounded box: all spheres of `radius` (m) around points of a core.

    The core is centred at `middle` (3,) in the shape frame with half edges `core` (3,). With `round`, it is a cylinder
    about that axis.
    """

    middle: Array
    core: Array
    radius: float
    round: int | None

    @property
    def reach(self) -> float:
        """Distance (m) from the centre beyond which it shades nothing."""
        return float(np.linalg.norm(self.core)) + SHADOW_REACH * self.radius

    def hidden(self, points: list[Image], normals: list[Image], frame: Pose) -> Image:
        """Return the fraction of light (0..1) hidden at `points` with `normals`, (n,) along each axis.

        Both, and the `frame` of the shape, are in camera axes.
        """
        turn = rotation(frame.orientation).astype(np.float32)
        start = (frame.position @ turn + self.middle).astype(np.float32)
        at = [_along(points, axis) - low for axis, low in zip(turn.T, start, strict=True)]
        way = [nearest - place for nearest, place in zip(self._nearest(at), at, strict=True)]
        square = np.maximum(way[0] ** 2 + way[1] ** 2 + way[2] ** 2, np.float32(1e-12))
        facing = sum((_along(normals, axis) * part for axis, part in zip(turn.T, way, strict=True)), np.float32(0))
        near = np.float32(self.radius**2) / square
        share = (np.minimum(near, 1 / near) - np.float32(SHADOW_REACH**-2)) * np.float32(1 / (1 - SHADOW_REACH**-2))
        hidden: Image = np.maximum(facing, 0) / np.sqrt(square) * np.maximum(share, 0)
        return hidden

    def _nearest(self, at: list[Image]) -> list[Image]:
        """Return the nearest points of the core, in its axes."""
        nearest = [np.clip(part, -half, half) for part, half in zip(at, self.core.astype(np.float32), strict=True)]
        if self.round is not None:
            a, b = (axis for axis in range(3) if axis != self.round)
            far = np.sqrt(at[a] ** 2 + at[b] ** 2)
            scale = np.minimum(np.float32(self.core[a]) / np.maximum(far, np.float32(1e-6)), 1)
            nearest[a], nearest[b] = at[a] * scale, at[b] * scale
        return nearest


@dataclass(frozen=True)
class ShadowCaster:
    """A rounded box in a frame of body number `body`; bodies in `own` receive no shadow from it."""

    body: int
    frame: Pose
    box: RoundedBox
    own: tuple[int, ...]


class ContactShadows:
    """The contact shadows of a scene, computed once and applied to every picture."""

    def __init__(self, scene: Scene) -> None:
        self._pieces = list(_pieces(scene)) if scene.light.shadows else []
        self._frames = stacked([piece.frame for piece in self._pieces])
        self._middles = np.array([piece.box.middle for piece in self._pieces])

    def cast(
        self,
        rgb: NDArray[np.uint8],
        ids: NDArray[np.int16],
        depth: NDArray[np.float32],
        camera: Camera,
        shot: Shot,
    ) -> NDArray[np.uint8]:
        """Return the picture (h, w, 3) with contact shadows.

        `ids` (h, w) are the visible bodies, `depth` (h, w) is in metres along the view axis; `camera` is in the world.
        """
        if not self._pieces:
            return rgb
        shaded = list(self._shaded(ids, depth, camera, shot))
        if not shaded:
            return rgb
        window = _window(shaded, ids.shape)
        visible = surfaces(camera, ids, depth, window)
        lost = np.zeros_like(visible[0][0])
        for _, parts in groupby(shaded, lambda part: part.body):
            lost += _hidden(parts, visible, window)
        left = 1 - np.minimum(np.float32(STRENGTH) * lost, np.float32(MAX_LOSS))
        picture = rgb.copy()
        picture[window] = quantize(rgb[window] * left.reshape(*ids[window].shape, 1))
        return picture

    def _shaded(
        self, ids: NDArray[np.int16], depth: NDArray[np.float32], camera: Camera, shot: Shot
    ) -> Iterator[ShadedRegion]:
        """Yield the pixels that each caster may shade, body by body, without empty ones."""
        bodies = stacked([shot.poses[piece.body] for piece in self._pieces])
        frames = compose(compose(inverse(camera.pose), bodies), self._frames)
        x, y = rays(camera, ids.shape)
        for i, (piece, middle) in enumerate(zip(self._pieces, apply(frames, self._middles).tolist(), strict=True)):
            part = _reached(piece.box.reach, middle, camera, ids.shape)
            seen, (rows, columns) = depth[part], part
            aside = [x[columns] * seen - middle[0], y[rows, None] * seen - middle[1], seen + middle[2]]
            near = aside[0] ** 2 + aside[1] ** 2 + aside[2] ** 2 < np.float32(piece.box.reach**2)
            for number in (-1, *piece.own):
                near &= ids[part] != number
            if near.any():
                yield ShadedRegion(piece.body, piece.box, Pose(frames.position[i], frames.orientation[i]), part, near)


@dataclass(frozen=True)
class ShadedRegion:
    """Pixels of a `part` of the picture that a caster may shade; its `frame` is in camera axes."""

    body: int
    box: RoundedBox
    frame: Pose
    part: ImageRegion
    pixels: NDArray[np.bool_]

    def within(self, window: ImageRegion) -> NDArray[np.intp]:
        """Return the indices of the pixels in a window around the part, row by row."""
        (rows, columns), (high, wide) = self.part, window
        row, column = np.divmod(np.flatnonzero(self.pixels), columns.stop - columns.start)
        first = (rows.start - high.start) * (wide.stop - wide.start) + columns.start - wide.start
        numbers: NDArray[np.intp] = row * (wide.stop - wide.start) + column + first
        return numbers


def stacked(poses: Sequence[Pose]) -> Pose:
    """Return all poses as one with a leading axis."""
    return Pose(np.array([pose.position for pose in poses]), np.array([pose.orientation for pose in poses]))


def _window(shaded: list[ShadedRegion], size: tuple[int, ...]) -> ImageRegion:
    """Return the region of a picture (height, width) around all shaded pixels plus one for slopes."""
    rows, columns = (
        slice(max(min(side.start for side in sides) - 1, 0), min(max(side.stop for side in sides) + 1, most))
        for sides, most in zip(zip(*(one.part for one in shaded), strict=True), size, strict=True)
    )
    return rows, columns


def _hidden(parts: Iterable[ShadedRegion], visible: tuple[list[Image], list[Image]], window: ImageRegion) -> Image:
    """Return the fraction of light hidden by the casters of a body in a window."""
    most = np.zeros_like(visible[0][0])
    for part in parts:
        pixels = part.within(window)
        points, normals = ([side.take(pixels) for side in sides] for sides in visible)
        most[pixels] = np.maximum(most.take(pixels), part.box.hidden(points, normals, part.frame))
    return most


def _pieces(scene: Scene) -> Iterator[ShadowCaster]:
    """Yield casters: movable bodies, and small static bodies that collide."""
    numbers = {body.name: i for i, body in enumerate(scene.bodies)}
    for i, body in enumerate(scene.bodies):
        if body.motion == "static" and not _is_small(body):
            continue
        jointed = [{joint.first, joint.second} for joint in scene.joints if body.name in (joint.first, joint.second)]
        own = {i} | {numbers[name] for pair in jointed for name in pair if name is not None}
        boxes = [(geom.pose, box) for geom in body.geoms if geom.visible for box in _boxes(geom.shape)]
        thick = MIN_THICKNESS * max((box.radius for _, box in boxes), default=0.0)
        yield from (ShadowCaster(i, pose, box, tuple(sorted(own))) for pose, box in boxes if box.radius > thick)


def _is_small(body: Body) -> bool:
    shown = [geom for geom in body.geoms if geom.visible]
    if not shown or not any(geom.collides for geom in body.geoms):
        return False
    low, high = world_box(shown, identity())
    return float(np.linalg.norm(high - low)) / 2 < MAX_STATIC_SIZE


@lru_cache(maxsize=256)
def _boxes(shape: Shape) -> tuple[RoundedBox, ...]:
    """Return the boxes of a shape; several if one box would be mostly empty."""
    facets = tessellate(shape)
    return tuple(_box(points) for points in _cut(facets.points[facets.faces], MAX_CUTS))


def _cut(triangles: Array, halvings: int) -> list[Array]:
    """Cut triangles (n, 3, 3) across the longest side while that saves volume; return the corners of each part."""
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    axis = int((high - low).argmax())
    middle = (low[axis] + high[axis]) / 2
    along = triangles[..., axis]
    ends = [triangles[along.min(axis=1) <= middle], triangles[along.max(axis=1) >= middle]]
    ends = [np.copy(end) for end in ends]
    np.minimum(ends[0][..., axis], middle, out=ends[0][..., axis])
    np.maximum(ends[1][..., axis], middle, out=ends[1][..., axis])
    volume = sum(float(np.prod(np.ptp(end, axis=(0, 1)))) for end in ends)
    if not halvings or volume > MAX_CUT_VOLUME * float(np.prod(high - low)):
        return [triangles.reshape(-1, 3)]
    return [part for end in ends for part in _cut(end, halvings - 1)]


def _box(points: Array) -> RoundedBox:
    """Return the rounded box around points (n, 3)."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    radius = float(half.min())
    return RoundedBox(middle, half - radius, radius, _axis(points - middle, half))


def _axis(points: Array, half: Array) -> int | None:
    """Return the axis about which points (n, 3) around the origin form a cylinder within 2 %, or None."""
    for axis in (2, 1, 0):
        a, b = (other for other in range(3) if other != axis)
        if abs(half[a] - half[b]) < 0.02 * half[a] and np.hypot(points[:, a], points[:, b]).max() < 1.02 * half[a]:
            return axis
    return None


def _reached(reach: float, middle: Sequence[float], camera: Camera, size: tuple[int, ...]) -> ImageRegion:
    """Return rows and columns of a picture (height, width) that show a sphere at `middle` (camera axes)."""
    (height, width), (x, y, z) = size, middle
    if -z - reach < camera.near:
        return slice(0, height), slice(0, width)
    focal = height / (2 * math.tan(camera.fovy / 2))
    return _part(-y, -z, reach, focal, height), _part(x, -z, reach, focal, width)


def _part(aside: float, away: float, reach: float, focal: float, size: int) -> slice:
    """Return the pixels of one axis that show a sphere of radius `reach` at `aside` and `away` (m)."""
    ends = [(aside + sign * reach) / (away + other * reach) for sign in (-1, 1) for other in (-1, 1)]
    first, last = (size / 2 + focal * end for end in (min(ends), max(ends)))
    return slice(min(max(0, math.floor(first)), size), max(0, min(size, math.ceil(last))))


def _along(parts: list[Image], axis: Array) -> Image:
    """Return the components of vectors, (n,) along each axis, along `axis` (3,)."""
    reached: Image = parts[0] * axis[0] + parts[1] * axis[1] + parts[2] * axis[2]
    return reached
