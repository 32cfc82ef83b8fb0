"""The beauty look in MuJoCo's Filament renderer (Vulkan; without a GPU on Mesa's lavapipe).

Filament's own post-processing dithers at random, so it is off: linear light is read at two exposures, supersampled, and
developed by us. Numbers of bodies and distances come from the parity look.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from wmspec.scene.camera import seeing
from wmspec.scene.model import Array, Camera, Frame, Scene, Shot
from wmspec.scene.silence import silence
from wmspec.scene.tonemap import shrink, tonemap
from wmspec.scene.transform import rotation

from .filament import filament
from .ktx import environment
from .render import Renderer as Parity
from .render import build

with silence():
    import mujoco

SAMPLES = 4
"""Samples a pixel, where none are asked for."""

EXPOSURE = 1 / (1.2 * 2**15)
"""Filament's camera: what a luminance of 1 cd/m² becomes (f/16, 1/125 s, ISO 100)."""

BRIGHTER = 12.0
"""The second picture's exposure, for what is too dark for the bytes of the first."""

SUN, SKY = 0.9, 1.2
"""How much stronger than in the parity look the light is, since its bytes are not linear."""

RADIUS = 0.35
"""Of the sun (Filament's `bulb_radius`): the softness of its shadows."""


class Renderer:
    """Draws one scene."""

    def __init__(self, scene: Scene, width: int, height: int, samples: int) -> None:
        self._scene = scene
        self._parity = Parity(scene, width, height)
        self._side = max(1, round(math.sqrt(samples)))
        size = (width * self._side, height * self._side)
        self._model: Any = _model(scene, *size)
        self._data: Any = mujoco.MjData(self._model)
        with silence():
            self._stage = _Stage(self._model, scene, *size)

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies where the shot places them."""
        frame = self._parity.draw(shot, depth=depth)
        for i, pose in enumerate(shot.poses):
            self._data.mocap_pos[i], self._data.mocap_quat[i] = pose.position, pose.orientation
        mujoco.mj_kinematics(self._model, self._data)
        light = self._stage.light(self._data, seeing(self._scene, shot))
        return Frame(tonemap(shrink(light, self._side)), frame.ids, frame.depth)

    def repaint(self, scene: Scene) -> bool:  # noqa: ARG002
        """Colours are taken over when a renderer is made."""
        return False

    def close(self) -> None:
        """Free the scene; the renderer can't be used any more."""
        self._parity.close()
        self._stage.close()


class _Stage:
    """Filament's side: the model's geometries, a sun and the surroundings."""

    def __init__(self, model: Any, scene: Scene, width: int, height: int) -> None:
        mjrf, self._context = filament()
        self._size = (width, height)
        self._scene = self._context.create_scene(mjrf.SceneParams())
        self._scene.configure_from_model(model)
        self._shapes = mjrf.ModelRenderables(self._scene, mjrf.ModelResources(self._context, model))
        sun = scene.light.diffuse * SUN * math.pi / EXPOSURE
        sky = scene.light.ambient * SKY / EXPOSURE
        self._lights = [(_sun(scene), sun), (_sky(), sky)]
        for light, _ in self._lights:
            self._scene.add_light(light)
        form = mjrf.PixelFormat.PIXEL_FORMAT_RGB8
        self._target = self._context.create_render_target(mjrf.RenderTargetConfig(color_format=form))
        self._target.resize(width, height)

    def light(self, data: Any, camera: Camera) -> Array:
        """Linear light (h, w, 3)."""
        self._shapes.update(data)
        plain = self._take(camera, 1.0)
        boosted = self._take(camera, BRIGHTER)
        clear = boosted.max(axis=-1, keepdims=True) < 250 / 255
        return np.where(clear, boosted / BRIGHTER, plain)

    def close(self) -> None:
        """Let go of what is in the scene."""
        for light, _ in self._lights:
            self._scene.remove_light(light)
        del self._shapes, self._scene, self._target, self._lights

    def _take(self, camera: Camera, exposure: float) -> Array:
        mjrf, context = filament()
        for light, intensity in self._lights:
            light.set_intensity(intensity * exposure)
        request = mjrf.RenderRequest()
        request.scene, request.target, request.post_processing = self._scene, self._target, False
        request.camera = _camera(camera, self._size[0] / self._size[1])
        request.viewport.width, request.viewport.height = self._size
        rgb = np.zeros((self._size[1], self._size[0], 3), np.uint8)
        read = mjrf.ReadRequest(target=self._target)
        read.set_buffer(rgb)
        context.wait_for_frame(context.render([request], [read]))
        return rgb / 255.0


def _model(scene: Scene, width: int, height: int) -> Any:
    """The parity look's model with physical materials."""
    spec = build(scene, width, height)
    for i, body in enumerate(scene.bodies):
        for j, geom in enumerate(body.geoms):
            if geom.visible:
                material = spec.material(f"b{i}g{j}")
                material.metallic, material.roughness = geom.surface.metallic, max(geom.surface.roughness, 0.05)
    for image in spec.textures:
        image.colorspace = mujoco.mjtColorSpace.mjCOLORSPACE_SRGB
    spec.visual.quality.offsamples = 0
    spec.add_text(name="filament.shadows.type", data="pcss")
    spec.add_numeric(name="filament.shadows.map_size", data=[2048.0], size=1)
    return spec.compile()


def _sun(scene: Scene) -> Any:
    mjrf, context = filament()
    kind = mjrf.LightType.LIGHT_DIRECTIONAL
    color = np.array([1.0, 0.97, 0.92], np.float32)
    shadows = scene.light.shadows
    sun = context.create_light(
        mjrf.LightParams(type=kind, color=color, cast_shadow=shadows, shadow_map_size=2048, bulb_radius=RADIUS)
    )
    sun.set_pose(np.zeros(3, np.float32), scene.light.direction.astype(np.float32))
    return sun


def _sky() -> Any:
    mjrf, context = filament()
    return context.create_light(mjrf.LightParams(type=mjrf.LightType.LIGHT_IMAGE, texture=_surroundings()))


@cache
def _surroundings() -> Any:
    mjrf, context = filament()
    file = environment()
    form = mjrf.TextureConfig(
        width=len(file),
        height=0,
        format=mjrf.PixelFormat.PIXEL_FORMAT_KTX,
        sampler_type=mjrf.SamplerType.TEXTURE_CUBE,
    )
    texture, data = context.create_texture(form), mjrf.TextureData()
    data.set_image(file)
    texture.upload(data)
    return texture


def _camera(camera: Camera, aspect: float) -> Any:
    mjrf, _ = filament()
    axes = rotation(camera.pose.orientation).astype(np.float32)
    top = camera.near * math.tan(camera.fovy / 2)
    made = mjrf.Camera(
        pos=camera.pose.position.astype(np.float32),
        forward=-axes[:, 2],
        up=axes[:, 1],
        frustum_bottom=-top,
        frustum_top=top,
        frustum_near=camera.near,
        frustum_far=camera.far,
    )
    made.frustum_width = top * aspect
    return made
