"""The parity look in SAPIEN's rasteriser (Vulkan; without a GPU on Mesa's lavapipe)."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from wmspec.errors import WmsError
from wmspec.scene.camera import find
from wmspec.scene.color import texture
from wmspec.scene.model import Array, Camera, Frame, Geom, Pose, Scene, Shot
from wmspec.scene.picture import check, fill, halve, quantize
from wmspec.scene.shadow import SHADE, Casters
from wmspec.scene.silence import silence
from wmspec.scene.tessellate import tessellate
from wmspec.scene.transform import multiply, quaternion

with silence():
    import sapien

SHADOW_MAP = 2048
GAMMA = 2.2  # of SAPIEN's own output, which we undo
TURN = quaternion(np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]))
"""SAPIEN's camera looks along +x with +z up; this turns it into USD's."""


def renderer(scene: Scene, width: int, height: int) -> Renderer:
    """Make a renderer of `width` x `height` pixels. Raises WmsError where Vulkan is missing or too old."""
    return Renderer(scene, width, height)


class Renderer:
    """Draws one scene: bodies are entities without physics, and are moved from shot to shot."""

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        _sentinel()
        self._scene, self._casters = scene, Casters(scene)
        self._world: Any = _world()
        self._bodies = [_body(self._world, [geom for geom in body.geoms if geom.visible]) for body in scene.bodies]
        self._owner = np.full(max((body.per_scene_id for body in self._bodies), default=0) + 1, -1, np.int16)
        self._owner[[body.per_scene_id for body in self._bodies]] = np.arange(len(self._bodies))
        self._sun = _lights(self._world, scene)
        self._cameras = {
            (camera.name, scale): _camera(self._world, camera, scale * width, scale * height)
            for camera in scene.cameras
            for scale in (1, 2)
        }

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies where the shot places them."""
        check(self._scene, shot)
        self._place(shot)
        camera = find(self._scene, shot.camera)
        fine, coarse = self._cameras[camera.name, 2], self._cameras[camera.name, 1]
        fine.take_picture()
        color = 255 * fine.get_picture("Color")[..., :3].clip(0, 1) ** np.float32(GAMMA)
        rgb = halve(fill(color, self._ids(fine), self._scene.background))
        coarse.take_picture()
        ids = self._ids(coarse)
        distance = np.where(ids >= 0, -coarse.get_picture("Position")[..., 2], np.float32(0)) if depth else None
        return Frame(quantize(rgb), ids, distance)

    def close(self) -> None:
        """Free the scene; the renderer can't be used any more."""
        self._cameras.clear()
        self._bodies.clear()
        self._sun = self._world = None

    def _place(self, shot: Shot) -> None:
        for body, pose in zip(self._bodies, shot.poses, strict=True):
            body.set_pose(_pose(pose))
        camera = find(self._scene, shot.camera)
        region = self._casters.region(camera, shot)
        turn = sapien.math.shortest_rotation([1, 0, 0], self._scene.light.direction.tolist())
        self._sun.pose = sapien.Pose(region.center, turn)
        self._sun.shadow_half_size = region.half
        # what lies beyond the far end counts as shaded: nothing that can be seen may
        self._sun.shadow_near, self._sun.shadow_far = -region.reach, region.reach + camera.far
        lamp = self._sun.entity  # the size of its shadow map is taken over when it enters the scene
        self._world.remove_entity(lamp)
        self._world.add_entity(lamp)
        self._world.update_render()

    def _ids(self, camera: Any) -> Any:
        marks = camera.get_picture("Segmentation")[..., 1]
        return np.where(marks > 0, self._owner[np.minimum(marks, len(self._owner) - 1)], np.int16(-1))


@lru_cache(maxsize=1)
def _sentinel() -> Any:
    """A scene that is never closed: while one lives, SAPIEN keeps its compiled shaders (seconds of work)."""
    try:
        with silence():
            sapien.render.set_camera_shader_dir("default")
            world = _world()
            eye = world.add_camera("eye", 16, 16, 1.0, 0.1, 10.0)
            world.update_render()
            eye.take_picture()
    except Exception as error:  # SAPIEN raises RuntimeError, whatever is wrong
        raise WmsError(
            f"SAPIEN can't draw: no Vulkan device that it can use ({error}); without a GPU it needs Mesa 24.3 or newer "
            "(Debian: mesa-vulkan-drivers, from backports on Debian 12), see 'wmspec doctor'"
        ) from error
    return world, eye


def _world() -> Any:
    return sapien.Scene([sapien.render.RenderSystem()])


def _pose(pose: Pose) -> Any:
    return sapien.Pose(pose.position, pose.orientation)


def _camera(world: Any, camera: Camera, width: int, height: int) -> Any:
    eye = world.add_camera(camera.name, width, height, camera.fovy, camera.near, camera.far)
    eye.entity.set_pose(sapien.Pose(camera.pose.position, multiply(camera.pose.orientation, TURN)))
    return eye


def _lights(world: Any, scene: Scene) -> Any:
    """The ambient light and the sun, once without shadows and once with, which is returned."""
    light = scene.light
    # A facing white surface reflects 1 / pi of the light that falls on it, and SAPIEN counts that in.
    strength = math.pi * light.diffuse
    world.set_ambient_light([light.ambient] * 3)
    world.add_directional_light(light.direction.tolist(), [strength * (1 - SHADE)] * 3)
    return world.add_directional_light(
        light.direction.tolist(), [strength * SHADE] * 3, shadow=True, shadow_map_size=SHADOW_MAP
    )


def _body(world: Any, geoms: list[Geom]) -> Any:
    component = sapien.render.RenderBodyComponent()
    for geom in geoms:
        component.attach(_shape(geom))
    entity = sapien.Entity()
    entity.add_component(component)
    world.add_entity(entity)
    return entity


def _shape(geom: Geom) -> Any:
    facets = tessellate(geom.shape)
    st: Array = facets.st * [1, -1] + [0, 1]
    points, normals = facets.points.astype(np.float32), facets.normals.astype(np.float32)
    shape = sapien.render.RenderShapeTriangleMesh(
        points, facets.faces.astype(np.uint32), normals, st.astype(np.float32), _material(geom)
    )
    shape.local_pose = _pose(geom.pose)
    return shape


def _material(geom: Geom) -> Any:
    """Colours are passed as if they were linear: light is then added up in sRGB, as the other engines do."""
    material = sapien.render.RenderMaterial()
    material.roughness, material.metallic, material.specular = 1.0, 0.0, 0.0
    material.base_color = [*geom.surface.color, 1.0]
    if geom.surface.texture is not None:
        image = np.dstack(
            [texture(geom.surface.texture), np.full(texture(geom.surface.texture).shape[:2], 255, np.uint8)]
        )
        material.base_color = [1.0, 1.0, 1.0, 1.0]
        material.base_color_texture = sapien.render.RenderTexture2D(image, "R8G8B8A8Unorm", mipmap_levels=4)
    return material
