"""Episodes and their pictures in bare engines, as one would write it by hand: nothing is shared, asked or checked.

Physics is each engine's own, stepped at the same rate by the loop that native scripts have. Pictures are drawn by what
the engine draws with if nothing is said, encoded as wmspec does; of the state at the beginning or the end, which costs
what any other does. No contact shadows, no masks; in PyBullet and SAPIEN no images on things.
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
from wmspec.backends.pybullet.lists import lists
from wmspec.backends.pybullet.world import World as PyBullet
from wmspec.backends.sapien import physics as in_sapien
from wmspec.backends.sapien.render import bodies, eye
from wmspec.backends.sapien.world import World as Sapien
from wmspec.dataset.build.rows import encoded
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.model.transform import compose
from wmspec.sim.scene.physics.episode import play, told
from wmspec.sim.scene.render.camera import projection_matrix, view_matrix
from wmspec.sim.scene.render.texcoords import texcoords

#: Executes episodes, and draws as many pictures of each, of this size.
Loop = Callable[[list[tuple[Scene, int]], int], None]


def _mujoco(every: list[tuple[Scene, int]], size: int) -> None:
    """One model an episode, but for nudges, which have that of the truth; one renderer an episode."""
    last: mujoco.MjModel | None = None
    last_kind: object = None  # what moves freely and what will be held is in the model
    for scene, pictures in every:
        whole, timeline = in_mujoco.prepare(scene)
        kind = (len(timeline.grips), [body.motion for body in scene.bodies])
        if pictures or last is None or kind != last_kind:
            last_kind, last = kind, mujoco.MjModel.from_xml_string(mjcf(scene, timeline, whole))
        world = MuJoCo(last, whole)
        if told(timeline) is None:
            play(world, timeline)
        if pictures:
            data = mujoco.MjData(last)
            mujoco.mj_forward(last, data)
            with mujoco.Renderer(last, size, size) as renderer:
                for camera in _cameras(scene, pictures):
                    renderer.update_scene(data, camera=camera.name)
                    encoded(renderer.render())


def _pybullet(every: list[tuple[Scene, int]], size: int) -> None:
    """One world and one client to draw with an episode; TinyRenderer with its own shadows."""
    for scene, pictures in every:
        whole, timeline = in_pybullet.prepare(scene)
        if told(timeline) is None:
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
                encoded(np.asarray(image[2], np.uint8).reshape(size, size, 4)[..., :3])
            pybullet.disconnect(client)


def _shown(scene: Scene) -> int:
    """A client that has everything that is visible, where it begins."""
    client: int = pybullet.connect(pybullet.DIRECT)
    for body in scene.bodies:
        for geom in (geom for geom in body.geoms if geom.visible):
            with lists(texcoords(geom)) as mesh:
                color = [*geom.surface.color, 1.0]
                shape = pybullet.createVisualShape(pybullet.GEOM_MESH, rgbaColor=color, physicsClientId=client, **mesh)
            pose = compose(body.pose, geom.pose)
            w, *turn = pose.orientation.tolist()
            at = pose.position.tolist()
            pybullet.createMultiBody(0, -1, shape, at, [*turn, w], physicsClientId=client)
    return client


def _sapien(every: list[tuple[Scene, int]], size: int) -> None:
    """One world and one scene to draw an episode; SAPIEN's own shaders, compiled before."""
    _compiled()
    for scene, pictures in every:
        whole, timeline = in_sapien.prepare(scene)
        if told(timeline) is None:
            play(Sapien(whole, in_sapien.landing(scene)), timeline)
        if pictures:
            world = sapien.Scene([sapien.render.RenderSystem()])
            for entity, body in zip(bodies(world, scene, linear=True), scene.bodies, strict=True):
                entity.set_pose(sapien.Pose(body.pose.position, body.pose.orientation))
            world.set_ambient_light([scene.light.ambient] * 3)
            world.add_directional_light(scene.light.direction.tolist(), [scene.light.diffuse] * 3, shadow=True)
            eyes = {camera.name: eye(world, camera, (size, size), "default", 1) for camera in scene.cameras}
            for camera in _cameras(scene, pictures):
                world.update_render()
                eyes[camera.name].take_picture()
                seen = eyes[camera.name].get_picture("Color")[..., :3]
                encoded((255 * seen.clip(0, 1)).astype(np.uint8))


@cache
def _compiled() -> Any:
    """A scene that stays: while it does, SAPIEN keeps its compiled shaders."""
    world = sapien.Scene([sapien.render.RenderSystem()])
    world.add_directional_light([0, 0, -1], [1, 1, 1], shadow=True)
    camera = world.add_camera("eye", 16, 16, 1.0, 0.1, 10.0)
    world.update_render()
    camera.take_picture()
    return world, camera


def _cameras(scene: Scene, pictures: int) -> Iterator[Any]:
    """The camera of each picture, in turns."""
    return (scene.cameras[number % len(scene.cameras)] for number in range(pictures))


#: The loop of each engine.
LOOPS: dict[str, Loop] = {"mujoco": _mujoco, "pybullet": _pybullet, "sapien": _sapien}
