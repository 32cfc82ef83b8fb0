"""One camera for all engines: a pinhole in USD's axes (looks along -z, +y up, +x right).

Pixel coordinates are continuous, x to the right and y down; pixel (i, j) covers [i, i + 1) x [j, j + 1).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.sim.scene.model import Array, Camera, Pose, Scene, Shot
from wmspec.sim.scene.model.transform import compose, quaternion, rotation


def look_at(position: ArrayLike, target: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> Pose:
    """The pose of a camera at `position` (3,) m that sees `target` (3,) m in its middle, `up` (3,) pointing up.

    Looking along `up` itself, +y of the world is up in the picture. Raises WmsError if both points are the same.
    """
    eye = np.asarray(position, dtype=np.float64)
    back = eye - np.asarray(target, dtype=np.float64)
    if not np.linalg.norm(back) > 0:
        raise WmsError(f"a camera at {eye.tolist()} can't look at its own position; move it or its target")
    back /= np.linalg.norm(back)
    right = np.cross(np.asarray(up, dtype=np.float64), back)
    if np.linalg.norm(right) < 1e-9:
        right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    return Pose(eye, quaternion(np.stack([right, np.cross(back, right), back], axis=1)))


def find(scene: Scene, name: str) -> Camera:
    """The scene's camera of that name. Raises WmsError, naming those there are."""
    for camera in scene.cameras:
        if camera.name == name:
            return camera
    known = [camera.name for camera in scene.cameras]
    raise WmsError(f"there is no camera `{name}`; {suggestion(name, known) or 'the scene has none'}")


def seeing(scene: Scene, shot: Shot) -> Camera:
    """The camera of a shot, placed in the world: one that rides on a body goes where the shot has that body."""
    camera = find(scene, shot.camera)
    if camera.body is None:
        return camera
    rides = next(i for i, body in enumerate(scene.bodies) if body.name == camera.body)
    return replace(camera, pose=compose(shot.poses[rides], camera.pose), body=None)


def view_matrix(pose: Pose) -> Array:
    """World to camera, (4, 4), for column vectors."""
    view = np.eye(4)
    view[:3, :3] = rotation(pose.orientation).T
    view[:3, 3] = -view[:3, :3] @ pose.position
    return view


def projection_matrix(camera: Camera, aspect: float) -> Array:
    """Camera to OpenGL's clip space, (4, 4), for column vectors; `aspect` is width / height."""
    focal, near, far = 1.0 / math.tan(camera.fovy / 2), camera.near, camera.far
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = focal / aspect, focal
    matrix[2, 2], matrix[2, 3] = -(far + near) / (far - near), -2 * far * near / (far - near)
    matrix[3, 2] = -1.0
    return matrix


def project(camera: Camera, points: ArrayLike, width: int, height: int) -> tuple[Array, Array]:
    """Pixel coordinates (n, 2) and depths (n,) in metres along the view axis of `points` (n, 3) in the world."""
    local = (np.atleast_2d(np.asarray(points, dtype=np.float64)) - camera.pose.position) @ rotation(
        camera.pose.orientation
    )
    depth = -local[:, 2]
    focal = height / (2 * math.tan(camera.fovy / 2))
    x = width / 2 + focal * local[:, 0] / depth
    y = height / 2 - focal * local[:, 1] / depth
    return np.stack([x, y], axis=1), depth


def rays(camera: Camera, width: int, height: int) -> tuple[Array, Array]:
    """Where the centres of the pixels lie at a depth of 1 m: to the right (width,) and up (height,), in metres."""
    focal = height / (2 * math.tan(camera.fovy / 2))
    x: Array = (np.arange(width, dtype=np.float64) + 0.5 - width / 2) / focal
    y: Array = (height / 2 - np.arange(height, dtype=np.float64) - 0.5) / focal
    return x, y


def unproject(camera: Camera, depth: NDArray[np.float32]) -> Array:
    """The points of the world (h, w, 3) seen at the centres of the pixels, from `depth` (h, w) along the view axis."""
    height, width = depth.shape
    x, y = rays(camera, width, height)
    local = np.stack(np.broadcast_arrays(x[None, :], y[:, None], -1.0), axis=-1) * depth[..., None]
    turned: Array = local.astype(np.float64) @ rotation(camera.pose.orientation).T
    return turned + camera.pose.position
