"""Still scenes, built by hand."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from wmspec.sim.scene.model import Body, Camera, Geom, Light, Motion, Pose, Scene, Surface
from wmspec.sim.scene.model.transform import identity, quaternion
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.shapes import Mesh, Shape

SUN = np.array([0.35, 0.45, -1.0]) / np.linalg.norm([0.35, 0.45, -1.0])
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
LYING = quaternion(np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]))


def turned(angle: float) -> Any:
    """The orientation of a body turned by `angle` (radians) around z."""
    return np.array([math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)])


def body(name: str, motion: Motion, at: Any, shape: Shape, look: Surface, *, turn: Any = UPRIGHT) -> Body:
    """A body of one geometry."""
    geom = Geom(name, shape, identity(), look)
    return Body(
        name, f"/World/{name}", motion, Pose(np.array(at, float), turn), (geom,), None, np.zeros(3), np.zeros(3)
    )


def scene(*bodies: Body, cameras: tuple[Camera, ...]) -> Scene:
    """A still scene."""
    sky = (0.82, 0.87, 0.93)
    return Scene("still", np.array([0.0, 0.0, -9.81]), bodies, (), cameras, Light(SUN), sky, (), 1.0)


def views(fovy: float = math.radians(34)) -> tuple[Camera, ...]:
    """Front, side, top and an oblique view of the origin."""
    eyes = {"front": (0, -1.5, 0.62), "side": (1.5, 0, 0.5), "top": (0, 0, 1.7), "oblique": (0.9, -1.1, 0.8)}
    return tuple(Camera(name, look_at(eye, (0, 0, 0.03)), fovy, 0.05, 20.0) for name, eye in eyes.items())


def riding(body: str) -> Camera:
    """A camera on a body, to its side and above it, that looks past it."""
    pose = look_at((0.05, 0.35, 0.3), (-0.25, -0.35, -0.05))
    return Camera("riding", pose, math.radians(50), 0.02, 20.0, body)


def wedge() -> Mesh:
    """A ramp: a mesh with sharp creases, and faces of different sizes."""
    low, high = np.array([-0.06, -0.05, -0.04]), np.array([0.06, 0.05, 0.04])
    x, y, z = np.stack([low, high], axis=1)
    points = [(x[0], y[0], z[0]), (x[1], y[0], z[0]), (x[1], y[0], z[1]), (x[0], y[1], z[0]), (x[1], y[1], z[0])]
    points.append((x[1], y[1], z[1]))
    faces = [(0, 1, 2), (3, 5, 4), (0, 3, 4), (0, 4, 1), (1, 4, 5), (1, 5, 2), (0, 2, 5), (0, 5, 3)]
    return Mesh(np.array(points), np.array(faces, np.int32))


def grain(path: Path) -> str:
    """A picture of wood: smooth, as textures of things should be that are seen from afar."""
    y, x = np.mgrid[0:128, 0:256] / 128
    ring = 0.5 + 0.5 * np.sin(22 * y + 2 * np.sin(2 * x + 3 * y))
    wood = np.array([196, 150, 105]) - ring[..., None] * np.array([26, 26, 24])
    Image.fromarray(wood.astype(np.uint8)).save(path)
    return str(path)
