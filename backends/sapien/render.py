"""The parity look in SAPIEN's rasterizer (Vulkan; Mesa's lavapipe without a GPU).

SAPIEN draws with the shaders of a folder. `shaders/color` draws matte surfaces with shadows at four samples per pixel;
`shaders/ids` draws depth and ids at pixel centres. SAPIEN's own shaders compile for seconds at every start.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.core.crash import is_own_error
from wmspec.core.diagnostics import GraphicsError
from wmspec.core.native_output import silence
from wmspec.sim.scene.model import Body, Camera, Frame, Geom, Pose, Scene, Shot
from wmspec.sim.scene.model.transform import identity, multiply, quaternion, rotation
from wmspec.sim.scene.render.camera import world_camera
from wmspec.sim.scene.render.color import load_texture, to_bytes
from wmspec.sim.scene.render.contact_shadow import ContactShadows
from wmspec.sim.scene.render.near_plane import NearPlane
from wmspec.sim.scene.render.picture import blend_over, require_all_poses
from wmspec.sim.scene.render.shadow import SUN_SHADE, ShadowCasters
from wmspec.sim.scene.render.texcoords import texcoords
from wmspec.sim.shapes.facets import Facets, join

with silence():
    import sapien

SHADERS = Path(__file__).parent / "shaders"
SHADOW_MAP = 1024
SAMPLES = 4
SHADOWLESS_OFFSET = np.array([1e5, 1e5, 0.0])
"""m: shadow maps of lights without shadows look at empty space; the shaders know no other light."""
CAMERA_TURN = quaternion(np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]))
"""Rotation from SAPIEN's camera (along +x, +z up) to USD's."""


class Renderer:
    """Draws one scene: bodies are entities without physics that move from shot to shot.

    Raises WmsError if Vulkan is missing or too old.
    """

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        _sentinel()
        self._scene, self._casters, self._contact = scene, ShadowCasters(scene), ContactShadows(scene)
        self._near = NearPlane(scene, width / height)
        self._world: Any = _world()
        self._bodies = [add_body(self._world, merged_geoms(body)) for body in scene.bodies]
        self._owner = np.full(max((body.per_scene_id for body in self._bodies), default=0) + 1, -1, np.int16)
        self._owner[[body.per_scene_id for body in self._bodies]] = np.arange(len(self._bodies))
        self._sun = _lights(self._world, scene)
        self._eyes: dict[str, tuple[Any, Any]] = {}
        self._size = (width, height)

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies at the poses of the shot."""
        require_all_poses(self._scene, shot)
        camera = world_camera(self._scene, shot)
        if camera.name not in self._eyes:
            self._eyes[camera.name] = _eyes(self._world, camera, *self._size)
        color, shape = self._eyes[camera.name]
        near = self._near.before(camera, shot)
        place_camera(color, near)
        place_camera(shape, near)
        self._place(shot, camera)
        color.take_picture()
        shape.take_picture()  # start both before waiting for the first
        rgb, seen = blend_over(color.get_picture("Picture"), self._scene.background), shape.get_picture("Seen")
        ids, distance = self._ids(seen[..., 1]), seen[..., 0]
        return Frame(self._contact.cast(rgb, ids, distance, camera, shot), ids, distance.copy() if depth else None)

    def repaint(self, scene: Scene) -> bool:
        """Switch to a scene that differs in colours only. Return False if geoms would be merged differently."""
        parts = [merged_geoms(body) for body in scene.bodies]
        if _counts(parts) != _counts(map(merged_geoms, self._scene.bodies)):
            return False
        self._scene = scene
        for entity, geometries in zip(self._bodies, parts, strict=True):
            shapes = entity.find_component_by_type(sapien.render.RenderBodyComponent).render_shapes
            for shape, geoms in zip(shapes, geometries, strict=True):
                material = shape.parts[0].material
                if _has_palette(geoms):
                    material.base_color_texture = _palette(geoms)
                else:
                    material.base_color = [*geoms[0].surface.color, 1.0]
        return True

    def close(self) -> None:
        """Free the scene."""
        self._eyes.clear()
        self._bodies.clear()
        self._sun = self._world = None

    def _place(self, shot: Shot, camera: Camera) -> None:
        place(self._bodies, shot)
        region = self._casters.region(camera, shot)
        if not self._scene.light.shadows:  # the shaders have no shadowless light: aim its map at empty space
            region = replace(region, center=region.center + SHADOWLESS_OFFSET, half=1.0)
        turn = sapien.math.shortest_rotation([1, 0, 0], self._scene.light.direction.tolist())
        self._sun.pose = sapien.Pose(region.center, turn)
        self._sun.shadow_half_size = region.half
        # points beyond the far end count as shaded: keep all visible points within
        self._sun.shadow_near, self._sun.shadow_far = -region.reach, region.reach + camera.far
        lamp = self._sun.entity  # the size of the shadow map applies when the light enters the scene
        self._world.remove_entity(lamp)
        self._world.add_entity(lamp)
        self._world.update_render()

    def _ids(self, marks: NDArray[np.float32]) -> NDArray[np.int16]:
        """Return the body of every entity id; 0 is background."""
        bodies: NDArray[np.int16] = self._owner[marks.astype(np.intp)]
        return bodies


@lru_cache(maxsize=1)
def _sentinel() -> Any:
    """Return a scene that is never closed, which keeps SAPIEN's compiled shaders alive."""
    # with its own threads, lavapipe's first pictures in a process differ in a few pixels
    os.environ.setdefault("LP_NUM_THREADS", "0")
    try:
        with silence():
            world = _world()
            eyes = _eyes(world, Camera("eye", identity(), 1.0, 0.1, 10.0), 16, 16)
            world.update_render()
            for one in eyes:
                one.take_picture()
    except Exception as error:  # SAPIEN raises RuntimeError for every error
        if is_own_error(error):
            raise
        raise GraphicsError(
            f"SAPIEN cannot draw: no suitable Vulkan device ({error}); without a GPU it needs Mesa 24.3 or newer "
            "(Debian: mesa-vulkan-drivers, from backports on Debian 12), see 'wmspec doctor'"
        ) from error
    return world, eyes


def _world() -> Any:
    return sapien.Scene([sapien.render.RenderSystem()])


def _pose(pose: Pose) -> Any:
    return sapien.Pose(pose.position, pose.orientation)


def merged_geoms(body: Body) -> list[list[Geom]]:
    """Return the visible geoms of a body grouped into as few shapes as possible; each shape has a fixed cost.

    Consecutive geoms without images form one shape, and those with the same image and colour. Their order stays: of
    coplanar faces the first is visible.
    """
    shown = [geom for geom in body.geoms if geom.visible]
    rows = groupby(shown, lambda geom: None if geom.surface.texture is None else geom.surface)
    return [list(row) for _, row in rows]


def _counts(parts: Iterable[list[list[Geom]]]) -> list[list[int]]:
    """Return the number of geoms per shape of each body."""
    return [[len(geoms) for geoms in body] for body in parts]


def place(entities: list[Any], shot: Shot) -> None:
    """Move the entities to the poses of the shot."""
    for entity, pose in zip(entities, shot.poses, strict=True):
        entity.set_pose(_pose(pose))


def _eyes(world: Any, camera: Camera, width: int, height: int) -> tuple[Any, Any]:
    """Return two equal cameras: one for colours, one for ids and depth."""
    sapien.render.set_picture_format("Picture", "r8g8b8a8unorm")
    color = eye(world, camera, (width, height), str(SHADERS / "color"), SAMPLES)
    return color, eye(world, camera, (width, height), str(SHADERS / "ids"), 1)


def eye(world: Any, camera: Camera, size: tuple[int, int], shaders: str, samples: int) -> Any:
    """Return a camera that draws with the shaders of a folder; SAPIEN reads the setting on creation."""
    before = sapien.render.get_camera_shader_dir(), sapien.render.get_msaa()
    sapien.render.set_camera_shader_dir(shaders)
    sapien.render.set_msaa(samples)
    made = world.add_camera(camera.name, *size, camera.fovy, camera.near, camera.far)
    sapien.render.set_camera_shader_dir(before[0])
    sapien.render.set_msaa(before[1])
    place_camera(made, camera)
    return made


def place_camera(eye: Any, camera: Camera) -> None:
    """Set pose and near plane of a camera."""
    if eye.near != np.float32(camera.near):
        eye.set_near(camera.near)
    eye.entity.set_pose(sapien.Pose(camera.pose.position, multiply(camera.pose.orientation, CAMERA_TURN)))


def _lights(world: Any, scene: Scene) -> Any:
    """Add the shadowless part of the sun; return the part with shadows."""
    light = scene.light
    direction = light.direction.tolist()
    world.set_ambient_light([light.ambient] * 3)
    world.add_directional_light(direction, [light.diffuse * (1 - SUN_SHADE)] * 3)
    return world.add_directional_light(
        direction, [light.diffuse * SUN_SHADE] * 3, shadow=True, shadow_map_size=SHADOW_MAP
    )


def add_body(world: Any, parts: list[list[Geom]]) -> Any:
    """Add a body whose visible geoms are grouped in `parts`; return its entity."""
    component = sapien.render.RenderBodyComponent()
    for geoms in parts:
        component.attach(_shape(geoms))
    entity = sapien.Entity()
    entity.add_component(component)
    world.add_entity(entity)
    return entity


def _shape(geoms: list[Geom]) -> Any:
    parts = [_placed(geom) for geom in geoms]
    whole = join(parts)
    if _has_palette(geoms):
        across = (np.arange(len(geoms)) + 0.5) / len(geoms)
        own = np.column_stack([across, np.full(len(geoms), 0.5)])
        st = np.repeat(own, [len(part.points) for part in parts], axis=0)
        material = sapien.render.RenderMaterial()
        material.base_color, material.base_color_texture = [1.0] * 4, _palette(geoms)
    else:
        st = whole.st * [1, -1] + [0, 1]
        material = _material(geoms[0])
    return sapien.render.RenderShapeTriangleMesh(
        whole.points.astype(np.float32),
        whole.faces.astype(np.uint32),
        whole.normals.astype(np.float32),
        st.astype(np.float32),
        material,
    )


def _placed(geom: Geom) -> Facets:
    """Return the triangles of a geom in the body frame."""
    facets, turn = texcoords(geom), rotation(geom.pose.orientation).T
    return replace(facets, points=facets.points @ turn + geom.pose.position, normals=facets.normals @ turn)


def _has_palette(geoms: list[Geom]) -> bool:
    """Whether geoms without images form one shape with palette colours."""
    return len(geoms) > 1 and geoms[0].surface.texture is None


def _palette(geoms: list[Geom]) -> Any:
    """Return an image of the colours of geoms, side by side."""
    colors = np.array([[*geom.surface.color, 1.0] for geom in geoms])
    return sapien.render.RenderTexture2D(to_bytes(colors)[None], "R8G8B8A8Unorm", mipmap_levels=1, srgb=False)


def _material(geom: Geom) -> Any:
    """Return a material. Colours stay in sRGB, in which our shaders add light."""
    look = geom.surface
    material = sapien.render.RenderMaterial()
    material.base_color = [*look.color, 1.0]
    material.roughness, material.metallic, material.specular = max(look.roughness, 0.05), look.metallic, 0.4
    if look.texture is not None:
        image = load_texture(look.texture)
        opaque = np.dstack([image, np.full(image.shape[:2], 255, np.uint8)])
        material.base_color_texture = sapien.render.RenderTexture2D(
            opaque, "R8G8B8A8Unorm", mipmap_levels=max(image.shape[:2]).bit_length(), srgb=False
        )
    return material
