"""Where a body would be seen in a picture if nothing else were there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from PIL import Image, ImageDraw

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Array, Body, Camera, Pose, Scene
from wmspec.sim.scene.model.bounds import upright
from wmspec.sim.scene.model.transform import apply, compose, identity
from wmspec.sim.scene.render.camera import find, project
from wmspec.sim.shapes import Shape
from wmspec.sim.shapes.facets import tessellate

#: How wide silhouettes are drawn (px), the smaller ones larger than they are seen, because a polygon covers its edge.
WIDE, MOST_FINER = 1024, 16


@dataclass(frozen=True)
class Silhouette:
    """How many pixels (not whole ones) a body covers within the picture, and on it and around it together.

    What lies further outside than the picture is wide counts no more.
    """

    inside: float
    all: float


def silhouette(scene: Scene, index: int, look: tuple[str, tuple[Pose, ...]], size: tuple[int, int]) -> Silhouette:
    """The silhouette of body number `index` in a picture of (width, height), from a camera, bodies at their poses."""
    camera, poses = placed(scene, look[0], look[1]), look[1]
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
    finer = min(max(WIDE // int((high - low).max()), 1), MOST_FINER)
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
    """The corners (2, 2) of an upright box in the picture around body number `index`: what covers its silhouette.

    None where a part of it may be behind the camera.
    """
    camera, pose = placed(scene, *look), look[1][index]
    points, depth = project(camera, apply(pose, cached_on(scene.bodies[index], _corners)), *size)
    return np.stack([points.min(axis=0), points.max(axis=0)]) if (depth > camera.near).all() else None


def _corners(body: Body) -> Array:
    """The corners (8, 3) m of the box around all that is visible of a body, in its frame."""
    low, high = upright([geom for geom in body.geoms if geom.visible], identity())
    return np.array(list(product(*zip(low.tolist(), high.tolist(), strict=True))))


def placed(scene: Scene, camera: str, poses: tuple[Pose, ...]) -> Camera:
    """A camera of the scene in the world, also if it rides on a body."""
    declared = find(scene, camera)
    if declared.body is None:
        return declared
    carrier = next(i for i, b in enumerate(scene.bodies) if b.name == declared.body)
    return replace(declared, pose=compose(poses[carrier], declared.pose), body=None)


def _polygons(body: Body, pose: Pose, camera: Camera, size: tuple[int, int]) -> list[Array]:
    """The pixel coordinates of polygons (n, 2) that together cover what is seen of a body."""
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
    except (QhullError, ValueError):  # seen edge on, or behind the camera
        return []
