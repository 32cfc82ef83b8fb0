"""The silhouette of a body in a picture without occluders."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from PIL import Image, ImageDraw

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Camera, Pose, Scene, Shot
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.scene.model.transform import apply, compose, identity
from wmspec.sim.scene.render.camera import project, world_camera
from wmspec.sim.shapes import Shape
from wmspec.sim.shapes.facets import tessellate

#: Width (px) of drawn silhouettes; small ones are enlarged, because polygons cover their edges.
SILHOUETTE_WIDTH, MAX_UPSCALE = 1024, 16


@dataclass(frozen=True)
class Silhouette:
    """Pixels (fractional) that a body covers inside the picture, and in total.

    Parts further outside than the width of the picture do not count.
    """

    inside: float
    all: float


def silhouette(scene: Scene, index: int, look: tuple[str, tuple[Pose, ...]], size: tuple[int, int]) -> Silhouette:
    """Return the silhouette of body `index` in a picture (width, height), given camera and poses."""
    camera, poses = world_camera(scene, Shot(*look)), look[1]
    width, height = size
    polygons = [p for p in _polygons(scene.bodies[index], poses[index], camera, size) if len(p) > 2]
    if not polygons:
        return Silhouette(0.0, 0.0)
    points = np.concatenate(polygons)
    frame = np.array([width, height])
    low = np.floor(np.clip(points.min(axis=0), -frame, 2 * frame)).astype(int)
    high = np.ceil(np.clip(points.max(axis=0), -frame, 2 * frame)).astype(int)
    if (high <= low).any():
        return Silhouette(0.0, 0.0)
    finer = min(max(SILHOUETTE_WIDTH // int((high - low).max()), 1), MAX_UPSCALE)
    across, down = (finer * (high - low)).tolist()
    image = Image.new("1", (across, down))
    draw = ImageDraw.Draw(image)
    for corners in ((polygon - low) * finer - 0.5 for polygon in polygons):
        draw.polygon(corners.reshape(-1).tolist(), fill=1)
    mask = np.asarray(image)
    left, top = np.maximum(-low, 0) * finer
    right, bottom = (np.minimum(frame, high) - low) * finer
    within = mask[top : max(bottom, top), left : max(right, left)]
    return Silhouette(float(within.sum()) / finer**2, float(mask.sum()) / finer**2)


def box(scene: Scene, index: int, look: tuple[str, tuple[Pose, ...]], size: tuple[int, int]) -> Array | None:
    """Return the corners (2, 2) of a box in the picture around the silhouette of body `index`.

    None if part of it may be behind the camera.
    """
    camera, pose = world_camera(scene, Shot(*look)), look[1][index]
    points, depth = project(camera, apply(pose, cached_on(scene.bodies[index], _corners)), *size)
    return np.stack([points.min(axis=0), points.max(axis=0)]) if (depth > camera.near).all() else None


def _corners(body: Body) -> Array:
    """Return the corners (8, 3) m of the box around the visible geoms of a body, in its frame."""
    low, high = world_box([geom for geom in body.geoms if geom.visible], identity())
    return np.array(list(product(*zip(low.tolist(), high.tolist(), strict=True))))


def _polygons(body: Body, pose: Pose, camera: Camera, size: tuple[int, int]) -> list[Array]:
    """Return pixel polygons (n, 2) that together cover a body."""
    polygons: list[Array] = []
    for geom in body.geoms:
        if geom.visible:
            polygons += _outlines(geom.shape, compose(pose, geom.pose), camera, size)
    return polygons


def _outlines(shape: Shape, pose: Pose, camera: Camera, size: tuple[int, int]) -> list[Array]:
    from scipy.spatial import ConvexHull, QhullError

    facets = tessellate(shape)
    points, depth = project(camera, apply(pose, facets.points), *size)
    before = depth > camera.near
    if not shape.convex:
        return list(points[facets.faces[before[facets.faces].all(axis=1)]])
    points = points[before]
    try:
        return [points[ConvexHull(points).vertices]]
    except (QhullError, ValueError):  # edge-on, or behind the camera
        return []
