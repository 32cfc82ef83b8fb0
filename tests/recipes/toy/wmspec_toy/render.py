"""Triangles into pixels: the nearest at each pixel's centre, lit by the sun, without shadows or textures."""

from __future__ import annotations

import numpy as np

from wmspec.sim.scene.model import Array, Frame, Scene, Shot
from wmspec.sim.scene.model.transform import compose, rotate, rotation
from wmspec.sim.scene.render.camera import pixel_rays, world_camera
from wmspec.sim.scene.render.color import to_bytes, to_linear, to_srgb
from wmspec.sim.scene.render.picture import require_all_poses
from wmspec.sim.shapes.facets import tessellate


class Painter:
    """Draws the bodies of one scene: `wmspec.sim.scene.model.Renderer`."""

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        self.scene, self.size = scene, (width, height)

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies where the shot places them."""
        require_all_poses(self.scene, shot)
        camera, light = world_camera(self.scene, shot), self.scene.light
        x, y = pixel_rays(camera, *self.size)
        near = np.full((y.size, x.size), camera.far)
        ids = np.full(near.shape, -1, np.int16)
        shade = np.tile(to_linear(self.scene.background), (*near.shape, 1))
        for i, (body, pose) in enumerate(zip(self.scene.bodies, shot.poses, strict=True)):
            for geom in (geom for geom in body.geoms if geom.visible):
                facets, frame = tessellate(geom.shape), compose(pose, geom.pose)
                points = rotate(frame.orientation, facets.points) + frame.position
                points = (points - camera.pose.position) @ rotation(camera.pose.orientation)
                facing = np.clip(-rotate(frame.orientation, facets.normals) @ light.direction, 0, None)
                for face in facets.faces:
                    lit = light.ambient + light.diffuse * facing[face].mean()
                    rows, columns = _around(points[face], x, y, camera.near)
                    distance = _distance(points[face], x[columns], y[rows])
                    seen = (distance > camera.near) & (distance < near[rows, columns])
                    near[rows, columns][seen] = distance[seen]
                    ids[rows, columns][seen] = i
                    shade[rows, columns][seen] = lit * to_linear(geom.surface.color)
        return Frame(to_bytes(to_srgb(shade)), ids, np.where(ids >= 0, near, 0).astype(np.float32) if depth else None)

    def repaint(self, scene: Scene) -> bool:
        """Draw a scene from now on that differs in colours only."""
        self.scene = scene
        return True

    def close(self) -> None:
        """There is nothing to let go of."""


def _around(corners: Array, x: Array, y: Array, near: float) -> tuple[slice, slice]:
    """The rows and columns of pixels in which a triangle (3, 3) in the camera's axes may be seen."""
    away = -corners[:, 2]
    if away.min() < near:  # it reaches behind the camera
        return slice(None), slice(None)
    right, up = corners[:, 0] / away, corners[:, 1] / away
    columns = np.searchsorted(x, [right.min(), right.max()])
    rows = y.size - np.searchsorted(y[::-1], [up.max(), up.min()])
    return slice(*rows), slice(*columns)


def _distance(corners: Array, x: Array, y: Array) -> Array:
    """How far (m, along the view axis) a triangle is on the rays (y, x) through the pixels; 0 where they miss it."""
    if abs(np.linalg.det(corners)) < 1e-15:  # seen from the edge
        return np.zeros((y.size, x.size))
    a, b, c = np.linalg.inv(corners.T)  # the ray is a sum of the corners with these weights
    weights = np.stack([w[0] * x[None, :] + w[1] * y[:, None] - w[2] for w in (a, b, c)])
    inside = (weights >= 0).all(axis=0)
    return np.where(inside, 1 / np.where(inside, weights.sum(axis=0), 1.0), 0.0)
