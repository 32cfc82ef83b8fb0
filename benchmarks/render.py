"""Speed of the renderers, compared with a plain loop in the bare engine.

    python benchmarks/render.py [--size 256] [--frames 24] [--engines mujoco,pybullet,sapien]

"bare" draws the engine's own boxes, balls and cylinders with its own shadows and settings: RGB, body ids and depth.
"wmspec" draws the same view in the look `parity`: the same triangles in every engine, with shadows and anti-aliasing.
Both alternate in one process and so share other load; the median is reported.
"""

from __future__ import annotations

import argparse
import importlib
import math
import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from wmspec.core.native_output import silence
from wmspec.sim.scene.model import Body, Camera, Geom, Light, Motion, Pose, Scene, Shot, Surface
from wmspec.sim.scene.model.transform import identity, multiply, quaternion
from wmspec.sim.scene.render.camera import look_at, projection_matrix, view_matrix
from wmspec.sim.shapes import Box, Cylinder, Shape, Sphere

SUN = np.array([0.35, 0.45, -1.0]) / np.linalg.norm([0.35, 0.45, -1.0])
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
SHAPES: tuple[Shape, ...] = (Sphere(0.05), Box((0.05,) * 3), Cylinder(0.04, 0.1))
COLORS = ((0.8, 0.1, 0.1), (0.1, 0.2, 0.8), (0.1, 0.6, 0.2), (0.9, 0.8, 0.1), (0.5, 0.1, 0.6))

Draw = Callable[[list[Pose]], object]


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=256, help="pixels on a side")
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--engines", default="mujoco,pybullet,sapien")
    chosen = parser.parse_args()
    if not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")
    scene = five()
    print(f"{'engine':<10}{'start':>9}{'bare':>10}{'wmspec':>10}{'+ depth':>10}{'frames/s':>10}{'ratio':>8}")
    for engine in chosen.engines.split(","):
        print(row(engine, scene, chosen.size, chosen.frames))


def row(engine: str, scene: Scene, size: int, frames: int) -> str:
    """Return a row of the table: milliseconds per frame, and the ratio of wmspec to the bare engine."""
    backend = importlib.import_module(f"wmspec.backends.{engine}")
    begin = time.perf_counter()
    renderer = backend.renderer(scene, size, size)
    renderer.draw(Shot("eye", poses(scene, 0)))
    start = time.perf_counter() - begin
    bare, ours, deep = median(
        [
            BARE[engine](scene, size),
            lambda places: renderer.draw(Shot("eye", places)),
            lambda places: renderer.draw(Shot("eye", places), depth=True),
        ],
        scene,
        frames,
    )
    renderer.close()
    times = f"{bare:7.1f} ms{ours:7.1f} ms{deep:7.1f} ms"
    return f"{engine:<10}{start:7.2f} s{times}{1000 / ours:10.0f}{ours / bare:7.2f}x"


def median(draws: list[Draw], scene: Scene, frames: int) -> list[float]:
    """Return the milliseconds per frame of each renderer, measured alternately."""
    spent: list[list[float]] = [[] for _ in draws]
    for i in range(frames + 2):
        for draw, times in zip(draws, spent, strict=True):
            begin = time.perf_counter()
            draw(poses(scene, i))
            times.append(1000 * (time.perf_counter() - begin))
    return [float(np.median(times[2:])) for times in spent]


def five() -> Scene:
    """Return a scene of five objects on a floor."""
    things = [
        body(f"thing{i}", "dynamic", (0.2 * i - 0.4, 0.1 * (i % 2), 0.05), SHAPES[i % 3], color)
        for i, color in enumerate(COLORS)
    ]
    floor = body("floor", "static", (0, 0, -0.05), Box((3.0, 3.0, 0.05)), (0.7, 0.7, 0.7))
    eye = Camera("eye", look_at((0, -1.5, 0.8), (0, 0, 0)), math.radians(40), 0.05, 20.0)
    return Scene("five", np.array([0, 0, -9.81]), (floor, *things), (), (eye,), Light(SUN), (0.82, 0.87, 0.93), (), 1.0)


def body(name: str, motion: Motion, at: Any, shape: Shape, color: tuple[float, float, float]) -> Body:
    """A body of one geometry."""
    geom = Geom(name, shape, identity(), Surface(color))
    return Body(name, f"/{name}", motion, Pose(np.array(at, float), UPRIGHT), (geom,), None, np.zeros(3), np.zeros(3))


def poses(scene: Scene, i: int) -> list[Pose]:
    """Return all poses in frame `i`; movable bodies move."""
    step = np.array([0.0, 0.002 * i, 0.0])
    return [Pose(b.pose.position + step * (b.motion != "static"), b.pose.orientation) for b in scene.bodies]


# ---------------------------------------------------------------- the bare engines


def mujoco(scene: Scene, size: int) -> Draw:
    """MuJoCo's own `Renderer`, with its default quality."""
    with silence():
        import mujoco as mj
    words = {
        Box: lambda s: f'type="box" size="{s.half[0]} {s.half[1]} {s.half[2]}"',
        Sphere: lambda s: f'type="sphere" size="{s.radius}"',
        Cylinder: lambda s: f'type="cylinder" size="{s.radius} {s.height / 2}"',
    }
    geoms = [b.geoms[0] for b in scene.bodies]
    looks = [f'{words[type(g.shape)](g.shape)} rgba="{row_of(g.surface.color)} 1"' for g in geoms]
    bodies = "".join(f'<body mocap="true"><geom {look}/></body>' for look in looks)
    eye = scene.cameras[0]
    camera = f'<camera pos="{row_of(eye.pose.position)}" quat="{row_of(eye.pose.orientation)}" fovy="40"/>'
    sun = f'<light directional="true" dir="{row_of(SUN)}" pos="0 0 3"/>'
    model = mj.MjModel.from_xml_string(f"<mujoco><worldbody>{sun}{camera}{bodies}</worldbody></mujoco>")
    data, renderer = mj.MjData(model), mj.Renderer(model, size, size)

    def draw(places: list[Pose]) -> object:
        for i, pose in enumerate(places):
            data.mocap_pos[i], data.mocap_quat[i] = pose.position, pose.orientation
        mj.mj_forward(model, data)
        renderer.update_scene(data, 0)
        rgb = renderer.render()
        renderer.enable_segmentation_rendering()
        ids = renderer.render()
        renderer.disable_segmentation_rendering()
        renderer.enable_depth_rendering()
        depth = renderer.render()
        renderer.disable_depth_rendering()
        return rgb, ids, depth

    return draw


def pybullet(scene: Scene, size: int) -> Draw:
    """PyBullet's TinyRenderer, with its own shadows."""
    with silence():
        import pybullet as pb
    client = pb.connect(pb.DIRECT)
    words = {
        Box: lambda s: {"shapeType": pb.GEOM_BOX, "halfExtents": s.half.tolist()},
        Sphere: lambda s: {"shapeType": pb.GEOM_SPHERE, "radius": s.radius},
        Cylinder: lambda s: {"shapeType": pb.GEOM_CYLINDER, "radius": s.radius, "length": s.height},
    }
    bodies = []
    for b in scene.bodies:
        geom = b.geoms[0]
        look = words[type(geom.shape)](geom.shape)
        shape = pb.createVisualShape(rgbaColor=[*geom.surface.color, 1], physicsClientId=client, **look)
        bodies.append(pb.createMultiBody(baseVisualShapeIndex=shape, physicsClientId=client))
    view = view_matrix(scene.cameras[0].pose).T.ravel().tolist()
    projection = projection_matrix(scene.cameras[0], 1.0).T.ravel().tolist()

    def draw(places: list[Pose]) -> object:
        for number, pose in zip(bodies, places, strict=True):
            pb.resetBasePositionAndOrientation(number, pose.position.tolist(), [0, 0, 0, 1], physicsClientId=client)
        return pb.getCameraImage(
            size,
            size,
            view,
            projection,
            (-SUN).tolist(),
            shadow=1,
            renderer=pb.ER_TINY_RENDERER,
            physicsClientId=client,
        )

    return draw


def sapien(scene: Scene, size: int) -> Draw:
    """SAPIEN's rasteriser with its default shaders."""
    with silence():
        import sapien as sp
    words = {
        Box: lambda s, m: sp.render.RenderShapeBox(s.half, m),
        Sphere: lambda s, m: sp.render.RenderShapeSphere(s.radius, m),
        Cylinder: lambda s, m: sp.render.RenderShapeCylinder(s.radius, s.height / 2, m),
    }
    world = sp.Scene([sp.render.RenderSystem()])
    world.set_ambient_light([0.35] * 3)
    world.add_directional_light(SUN.tolist(), [2.0] * 3, shadow=True, shadow_scale=2)
    entities = []
    for b in scene.bodies:
        material = sp.render.RenderMaterial(base_color=[*b.geoms[0].surface.color, 1])
        component, entity = sp.render.RenderBodyComponent(), sp.Entity()
        component.attach(words[type(b.geoms[0].shape)](b.geoms[0].shape, material))
        entity.add_component(component)
        world.add_entity(entity)
        entities.append(entity)
    sp.render.set_camera_shader_dir("default")
    pose = scene.cameras[0].pose
    eye = world.add_camera("eye", size, size, scene.cameras[0].fovy, 0.05, 20.0)
    turn = quaternion(np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]))
    eye.entity.set_pose(sp.Pose(pose.position, multiply(pose.orientation, turn)))

    def draw(places: list[Pose]) -> object:
        for entity, place in zip(entities, places, strict=True):
            entity.set_pose(sp.Pose(place.position, place.orientation))
        world.update_render()
        eye.take_picture()
        return [eye.get_picture(name) for name in ("Color", "Segmentation", "Position")]

    return draw


def row_of(numbers: Any) -> str:
    """Return numbers separated by spaces, for XML."""
    return " ".join(map(str, np.asarray(numbers).tolist()))


BARE: dict[str, Callable[[Scene, int], Draw]] = {"mujoco": mujoco, "pybullet": pybullet, "sapien": sapien}

if __name__ == "__main__":
    main()
