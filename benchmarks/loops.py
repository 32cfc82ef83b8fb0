"""Hand-written loops in bare engines: episodes and pictures without sharing, questions or checks.

Each engine steps at the same rate, as in native scripts. The engine's default renderer draws the initial or final
state, encoded as in wmspec. No contact shadows, no masks; in PyBullet and SAPIEN no textures.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import mujoco
import numpy as np
import pybullet
import sapien

from wmspec.backends.mujoco import physics as in_mujoco
from wmspec.backends.mujoco.mjcf import mjcf
from wmspec.backends.mujoco.world import World as MuJoCo
from wmspec.backends.pybullet import physics as in_pybullet
from wmspec.backends.pybullet.triangles import shared_lists
from wmspec.backends.pybullet.world import World as PyBullet
from wmspec.backends.sapien import physics as in_sapien
from wmspec.backends.sapien.render import add_body, eye, merged_geoms
from wmspec.backends.sapien.world import World as Sapien
from wmspec.dataset.build.rows import encode_picture
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.model.transform import compose
from wmspec.sim.scene.physics.episode import kinematic_recording, play
from wmspec.sim.scene.render.camera import projection_matrix, view_matrix
from wmspec.sim.scene.render.texcoords import texcoords

#: Executes episodes, and draws this many pictures of each, with this size.
Loop = Callable[[list[tuple[Scene, int]], int], None]


def _mujoco(every: list[tuple[Scene, int]], size: int) -> None:
    """One model and one renderer per episode; perturbed episodes reuse the model."""
    last: mujoco.MjModel | None = None
    last_kind: object = None  # what moves freely and what will be held is in the model
    for scene, pictures in every:
        whole, timeline = in_mujoco.prepare(scene)
        kind = (len(timeline.grips), [body.motion for body in scene.bodies])
        if pictures or last is None or kind != last_kind:
            last_kind, last = kind, mujoco.MjModel.from_xml_string(mjcf(scene, timeline, whole))
        world = MuJoCo(last, whole)
        if kinematic_recording(timeline) is None:
            play(world, timeline)
        if pictures:
            data = mujoco.MjData(last)
            mujoco.mj_forward(last, data)
            with mujoco.Renderer(last, size, size) as renderer:
                for camera in _cameras(scene, pictures):
                    renderer.update_scene(data, camera=camera.name)
                    encode_picture(renderer.render())


def _pybullet(every: list[tuple[Scene, int]], size: int) -> None:
    """One world and one rendering client per episode; TinyRenderer with its own shadows."""
    for scene, pictures in every:
        whole, timeline = in_pybullet.prepare(scene)
        if kinematic_recording(timeline) is None:
            world = PyBullet(whole)
            play(world, timeline)
            world.close()
        if pictures:
            client = _shown(scene)
            for camera in _cameras(scene, pictures):
                image = pybullet.getCameraImage(
                    size,
                    size,
                    view_matrix(camera.pose).T.ravel().tolist(),
                    projection_matrix(camera, 1.0).T.ravel().tolist(),
                    lightDirection=(-scene.light.direction).tolist(),
                    shadow=1,
                    renderer=pybullet.ER_TINY_RENDERER,
                    physicsClientId=client,
                )
                encode_picture(np.asarray(image[2], np.uint8).reshape(size, size, 4)[..., :3])
            pybullet.disconnect(client)


def _shown(scene: Scene) -> int:
    """Return a client with all visible objects in their initial poses."""
    client: int = pybullet.connect(pybullet.DIRECT)
    for body in scene.bodies:
        for geom in (geom for geom in body.geoms if geom.visible):
            with shared_lists(texcoords(geom)) as mesh:
                color = [*geom.surface.color, 1.0]
                shape = pybullet.createVisualShape(pybullet.GEOM_MESH, rgbaColor=color, physicsClientId=client, **mesh)
            pose = compose(body.pose, geom.pose)
            w, *turn = pose.orientation.tolist()
            at = pose.position.tolist()
            pybullet.createMultiBody(0, -1, shape, at, [*turn, w], physicsClientId=client)
    return client


def _sapien(every: list[tuple[Scene, int]], size: int) -> None:
    """One world and one rendering scene per episode; SAPIEN's own shaders, compiled in advance."""
    _compiled()
    for scene, pictures in every:
        whole, timeline = in_sapien.prepare(scene)
        if kinematic_recording(timeline) is None:
            play(Sapien(whole, in_sapien.landing_bodies(scene)), timeline)
        if pictures:
            world = sapien.Scene([sapien.render.RenderSystem()])
            for body in scene.bodies:
                entity = add_body(world, merged_geoms(body))
                entity.set_pose(sapien.Pose(body.pose.position, body.pose.orientation))
            world.set_ambient_light([scene.light.ambient] * 3)
            world.add_directional_light(scene.light.direction.tolist(), [scene.light.diffuse] * 3, shadow=True)
            eyes = {camera.name: eye(world, camera, (size, size), "default", 1) for camera in scene.cameras}
            for camera in _cameras(scene, pictures):
                world.update_render()
                eyes[camera.name].take_picture()
                seen = eyes[camera.name].get_picture("Color")[..., :3]
                encode_picture((255 * seen.clip(0, 1)).astype(np.uint8))


@cache
def _compiled() -> Any:
    """Return a scene that keeps SAPIEN's compiled shaders alive."""
    world = sapien.Scene([sapien.render.RenderSystem()])
    world.add_directional_light([0, 0, -1], [1, 1, 1], shadow=True)
    camera = world.add_camera("eye", 16, 16, 1.0, 0.1, 10.0)
    world.update_render()
    camera.take_picture()
    return world, camera


def _cameras(scene: Scene, pictures: int) -> Iterator[Any]:
    """Yield the camera of each picture, in turn."""
    return (scene.cameras[number % len(scene.cameras)] for number in range(pictures))


#: The loop of each engine.
LOOPS: dict[str, Loop] = {"mujoco": _mujoco, "pybullet": _pybullet, "sapien": _sapien}
