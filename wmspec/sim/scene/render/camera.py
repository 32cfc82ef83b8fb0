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
    """Return the pose of a camera at `position` (3,) m with `target` (3,) m in the centre and `up` (3,) up.

    If the view direction is parallel to `up`, +y of the world is up. Raises WmsError if both points are equal.
    """
    eye = np.asarray(position, dtype=np.float64)
    back = eye - np.asarray(target, dtype=np.float64)
    if not np.linalg.norm(back) > 0:
        raise WmsError(f"a camera at {eye.tolist()} has its target at its own position; move either")
    back /= np.linalg.norm(back)
    right = np.cross(np.asarray(up, dtype=np.float64), back)
    if np.linalg.norm(right) < 1e-9:
        right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    return Pose(eye, quaternion(np.stack([right, np.cross(back, right), back], axis=1)))


def find_camera(scene: Scene, name: str) -> Camera:
    """Return the camera with this name. Raises WmsError with the known names."""
    for camera in scene.cameras:
        if camera.name == name:
            return camera
    known = [camera.name for camera in scene.cameras]
    raise WmsError(f"there is no camera `{name}`; {suggestion(name, known) or 'the scene has none'}")


def world_camera(scene: Scene, shot: Shot) -> Camera:
    """Return the camera of a shot in world coordinates, attached cameras included."""
    camera = find_camera(scene, shot.camera)
    if camera.body is None:
        return camera
    rides = next(i for i, body in enumerate(scene.bodies) if body.name == camera.body)
    return replace(camera, pose=compose(shot.poses[rides], camera.pose), body=None)


def view_matrix(pose: Pose) -> Array:
    """Return the world-to-camera matrix (4, 4) for column vectors."""
    view = np.eye(4)
    view[:3, :3] = rotation(pose.orientation).T
    view[:3, 3] = -view[:3, :3] @ pose.position
    return view


def projection_matrix(camera: Camera, aspect: float) -> Array:
    """Return the camera-to-clip matrix (4, 4) of OpenGL for column vectors; `aspect` is width / height."""
    focal, near, far = 1.0 / math.tan(camera.fovy / 2), camera.near, camera.far
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = focal / aspect, focal
    matrix[2, 2], matrix[2, 3] = -(far + near) / (far - near), -2 * far * near / (far - near)
    matrix[3, 2] = -1.0
    return matrix


def project(camera: Camera, points: ArrayLike, width: int, height: int) -> tuple[Array, Array]:
    """Return pixel coordinates (n, 2) and depths (n,), m along the view axis, of world points (n, 3)."""
    local = (np.atleast_2d(np.asarray(points, dtype=np.float64)) - camera.pose.position) @ rotation(
        camera.pose.orientation
    )
    depth = -local[:, 2]
    focal = height / (2 * math.tan(camera.fovy / 2))
    x = width / 2 + focal * local[:, 0] / depth
    y = height / 2 - focal * local[:, 1] / depth
    return np.stack([x, y], axis=1), depth


def pixel_rays(camera: Camera, width: int, height: int) -> tuple[Array, Array]:
    """Return the positions of pixel centres at a depth of 1 m: right (width,) and up (height,), m."""
    focal = height / (2 * math.tan(camera.fovy / 2))
    x: Array = (np.arange(width, dtype=np.float64) + 0.5 - width / 2) / focal
    y: Array = (height / 2 - np.arange(height, dtype=np.float64) - 0.5) / focal
    return x, y


def unproject(camera: Camera, depth: NDArray[np.float32]) -> Array:
    """Return the world points (h, w, 3) at the pixel centres, given `depth` (h, w) along the view axis."""
    height, width = depth.shape
    x, y = pixel_rays(camera, width, height)
    local = np.stack(np.broadcast_arrays(x[None, :], y[:, None], -1.0), axis=-1) * depth[..., None]
    turned: Array = local.astype(np.float64) @ rotation(camera.pose.orientation).T
    return turned + camera.pose.position
