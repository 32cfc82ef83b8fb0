"""The beauty look in SAPIEN's path tracer (Vulkan ray tracing; without a GPU on Mesa's lavapipe).

Light is traced from a soft sun and the surroundings, over several bounces, and developed by us. Numbers of bodies and
distances come from the parity look.
"""

from __future__ import annotations

import math
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from wmspec.scene.camera import seeing
from wmspec.scene.color import to_bytes, to_linear, to_srgb
from wmspec.scene.environment import PEAK, cube, radiance
from wmspec.scene.model import Array, Camera, Frame, Scene, Shot
from wmspec.scene.shadow import Casters
from wmspec.scene.silence import silence
from wmspec.scene.tonemap import shrink, tonemap

from .denoise import denoise
from .render import Renderer as Parity
from .render import bodies, eye, place, stand

with silence():
    import sapien

SAMPLES = 16
"""Paths a pixel, where none are asked for."""

BOUNCES = 3

SUN, SKY = 0.9, 1.2
"""How much stronger than in the parity look the light is, since its bytes are not linear."""

AWAY, WIDTH = 30.0, 1.6
"""The sun is a square lamp of this half width, so far away (m): the softness of its shadows."""


class Renderer:
    """Draws one scene."""

    def __init__(self, scene: Scene, width: int, height: int, samples: int) -> None:
        self._scene, self._casters, self._size, self._samples = (
            scene,
            Casters(scene),
            (2 * width, 2 * height),
            max(1, samples // 4),
        )
        self._parity = Parity(scene, width, height)
        self._world: Any = sapien.Scene([sapien.render.RenderSystem()])
        self._bodies = bodies(self._world, scene, linear=True)
        self._world.render_system.cubemap, _ = _surroundings()
        self._scale = max(scene.light.ambient, 0.05) * SKY * PEAK  # of what the bytes of the surroundings stand for
        self._sun = _sun(self._world, scene, self._scale)
        self._eyes: dict[str, Any] = {}

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies where the shot places them."""
        frame, camera = self._parity.draw(shot, depth=depth), seeing(self._scene, shot)
        if camera.name not in self._eyes:
            self._eyes[camera.name] = _eye(self._world, camera, *self._size, self._samples)
        stand(self._eyes[camera.name], camera)
        place(self._bodies, shot)
        region, toward = self._casters.region(camera, shot), self._scene.light.direction
        self._sun.pose = _facing(region.center - toward * AWAY, region.center)
        self._world.update_render()
        self._eyes[camera.name].take_picture()
        return Frame(tonemap(shrink(self._light(self._eyes[camera.name]), 2)), frame.ids, frame.depth)

    def _light(self, seen: Any) -> Array:
        """Linear light, twice as wide and high as the picture."""
        drawn = {name: seen.get_picture(name) for name in ("HdrColor", "Albedo", "Normal", "Position")}
        light, color, normal, place = (np.nan_to_num(image[..., :3]) for image in drawn.values())
        empty = ~normal.any(axis=-1, keepdims=True)
        smooth = denoise(light * np.float32(self._scale), color, normal, place)
        return np.where(empty, to_linear(self._scene.background), smooth)

    def repaint(self, scene: Scene) -> bool:  # noqa: ARG002
        """Colours are taken over when a renderer is made."""
        return False

    def close(self) -> None:
        """Free the scene; the renderer can't be used any more."""
        self._parity.close()
        self._eyes.clear()
        self._bodies.clear()
        self._sun = self._world = None


def _sun(world: Any, scene: Scene, scale: float) -> Any:
    """A lamp whose light falls on a facing surface as strongly as the sun's."""
    strength = scene.light.diffuse * SUN * math.pi * AWAY**2 / (2 * WIDTH) ** 2 / scale
    color = [strength, 0.97 * strength, 0.92 * strength]
    return world.add_area_light_for_ray_tracing(sapien.Pose(), color, WIDTH, WIDTH)


def _facing(eye: Array, target: Array) -> Any:
    """The pose of a lamp at `eye` that shines at `target`."""
    turn = sapien.math.shortest_rotation([1, 0, 0], ((target - eye) / np.linalg.norm(target - eye)).tolist())
    return sapien.Pose(eye, turn)


def _eye(world: Any, camera: Camera, width: int, height: int, samples: int) -> Any:
    before = sapien.render.get_camera_shader_dir(), sapien.render.get_ray_tracing_samples_per_pixel()
    sapien.render.set_ray_tracing_samples_per_pixel(samples)
    sapien.render.set_ray_tracing_path_depth(BOUNCES)
    sapien.render.set_ray_tracing_denoiser("none")
    made = eye(world, camera, (width, height), "rt", 1)
    sapien.render.set_ray_tracing_samples_per_pixel(before[1])
    return made


@lru_cache(maxsize=1)
def _surroundings() -> Any:
    """A cube map of the surroundings, its bytes 255 for `PEAK`, and the folder of its files.

    SAPIEN reads them when it first draws, and has y and z the other way round.
    """
    folder = tempfile.TemporaryDirectory(prefix="wmspec-")
    light = radiance(cube(128)[..., [0, 2, 1]]) / PEAK
    files = [str(Path(folder.name) / f"{face}.png") for face in range(6)]
    for face, file in zip(light, files, strict=True):
        Image.fromarray(to_bytes(to_srgb(face))).save(file)
    return sapien.render.RenderCubemap(*files), folder
