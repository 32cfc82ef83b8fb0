"""The scene as MJCF: what MuJoCo executes here, and what its own viewer opens."""

from __future__ import annotations

from math import degrees
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import ArrayLike

from wmspec.backends.mujoco.impact import IMPEDANCE, solref, solreffriction
from wmspec.backends.mujoco.world import HEAVY
from wmspec.scene.centred import centred, placed
from wmspec.scene.contact import mix, touchable
from wmspec.scene.episode import TOUCH, Episode
from wmspec.scene.hull import corners
from wmspec.scene.model import (
    Array,
    Body,
    Box,
    Camera,
    Capsule,
    Cone,
    Cylinder,
    Friction,
    Geom,
    Light,
    Mesh,
    Pose,
    Scene,
    Sphere,
)
from wmspec.scene.transform import conjugate, rotate

SPIN, ROLL = 0.005, 0.0001  # required by the format, without effect at condim 3
_HIDDEN = "3"  # the group of geoms that viewers don't show at first


def mjcf(scene: Scene, episode: Episode) -> str:
    """A model: bodies in the scene's order, frames at their centres of mass, one `pair` per pair that may touch."""
    root = ET.Element("mujoco", model=scene.name)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    _options(root, episode)
    asset, world, contact = (ET.SubElement(root, tag) for tag in ("asset", "worldbody", "contact"))
    _light(world, scene.light)
    for camera in scene.cameras:
        _camera(world, camera)
    for body in map(centred, scene.bodies):
        _body(world, asset, body)
    for a, g, b, h in touchable(scene.bodies):
        _pair(contact, f"{a.name}/{g.name}", f"{b.name}/{h.name}", mix(g.friction, h.friction), episode)
    _keyframe(root, scene, episode)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _options(root: ET.Element, episode: Episode) -> None:
    option = ET.SubElement(
        root,
        "option",
        timestep=_text([episode.step]),
        gravity=_text(episode.gravity),
        cone="elliptic",
        integrator="Euler",
        solver="Newton",
        iterations="100",
        tolerance="1e-10",
        jacobian="dense",
    )
    ET.SubElement(option, "flag", multiccd="enable")


def _light(world: ET.Element, light: Light) -> None:
    ET.SubElement(
        world,
        "light",
        directional="true",
        pos="0 0 3",
        dir=_text(light.direction),
        diffuse=_text([light.diffuse] * 3),
        ambient=_text([light.ambient] * 3),
        specular="0 0 0",
    )


def _camera(world: ET.Element, camera: Camera) -> None:
    ET.SubElement(world, "camera", {"name": camera.name, "fovy": _text([degrees(camera.fovy)]), **_pose(camera.pose)})


def _body(world: ET.Element, asset: ET.Element, body: Body) -> None:
    """A body at its pose; a kinematic one is a heavy free body whose state is set before every step."""
    element = ET.SubElement(world, "body", {"name": body.name, **_pose(body.pose)})
    if body.motion != "static":
        ET.SubElement(element, "freejoint", name=body.name)
        mass, moments = (HEAVY, [HEAVY] * 3) if body.inertia is None else (body.inertia.mass, body.inertia.moments)
        ET.SubElement(element, "inertial", pos="0 0 0", mass=_text([mass]), diaginertia=_text(moments))
    if body.motion == "kinematic":
        element.set("gravcomp", "1")
    for geom in body.geoms:
        _geom(element, asset, f"{body.name}/{geom.name}", geom)


def _geom(element: ET.Element, asset: ET.Element, name: str, geom: Geom) -> None:
    """What collides and what is drawn: one geom, but for meshes, whose hull collides out of sight."""
    look = {"rgba": _text([*geom.surface.color, 1.0])}
    hidden = {} if geom.visible else {"group": _HIDDEN}
    match geom.shape:
        case Box() | Sphere() | Cylinder() | Capsule():
            _add(element, name, {**_primitive(geom.shape), **_pose(geom.pose), **look, **hidden})
        case Cone():
            _hull(asset, name, placed(geom.pose, corners(geom.shape)))
            _add(element, name, {"type": "mesh", "mesh": name, **look, **hidden})
        case Mesh(points, faces):
            if geom.collides:
                _hull(asset, name, placed(geom.pose, corners(geom.shape)))
                _add(element, name, {"type": "mesh", "mesh": name, "group": _HIDDEN, **look})
            if geom.visible:
                seen = {"name": f"{name}/seen", "vertex": _text(points), "face": _text(faces), "inertia": "shell"}
                ET.SubElement(asset, "mesh", seen)
                _add(element, f"{name}/seen", {"type": "mesh", "mesh": f"{name}/seen", **_pose(geom.pose), **look})


def _hull(asset: ET.Element, name: str, points: Array) -> None:
    ET.SubElement(asset, "mesh", name=name, vertex=_text(points), inertia="convex")


def _add(element: ET.Element, name: str, attributes: dict[str, str]) -> None:
    """Nothing touches by itself: what touches is listed, as pairs."""
    ET.SubElement(element, "geom", {"name": name, "contype": "0", "conaffinity": "0", **attributes})


def _primitive(shape: Box | Sphere | Cylinder | Capsule) -> dict[str, str]:
    match shape:
        case Box(half):
            return {"type": "box", "size": _text(half)}
        case Sphere(r):
            return {"type": "sphere", "size": _text([r])}
        case Cylinder(r, h):
            return {"type": "cylinder", "size": _text([r, h / 2])}
        case Capsule(r, h):
            return {"type": "capsule", "size": _text([r, h / 2])}


def _pair(contact: ET.Element, first: str, second: str, pair: Friction, episode: Episode) -> None:
    ET.SubElement(
        contact,
        "pair",
        geom1=first,
        geom2=second,
        condim="3" if pair.dynamic > 0 else "1",
        friction=_text([pair.dynamic, pair.dynamic, SPIN, ROLL, ROLL]),
        solref=_text(solref(pair, episode.step)),
        solreffriction=_text(solreffriction(episode.step)),
        solimp=_text([IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0]),
        gap=_text([TOUCH]),  # seen from there on, pushed from 0 on
    )


def _keyframe(root: ET.Element, scene: Scene, episode: Episode) -> None:
    """The start, with initial velocities; MuJoCo wants angular ones in the body's axes."""
    free = [i for i, body in enumerate(scene.bodies) if body.motion != "static"]
    if not free:
        return
    speed = np.zeros((len(scene.bodies), 6))
    for kick in episode.kicks:
        if kick.step == 0:
            turn = np.array(episode.start[kick.body][3:])
            speed[kick.body] = [*kick.linear, *rotate(conjugate(turn), np.array(kick.angular))]
    qpos = [number for i in free for number in episode.start[i]]
    ET.SubElement(
        ET.SubElement(root, "keyframe"), "key", name="start", qpos=_text(qpos), qvel=_text(speed[free].ravel())
    )


def _pose(pose: Pose) -> dict[str, str]:
    return {"pos": _text(pose.position), "quat": _text(pose.orientation)}


def _text(numbers: ArrayLike) -> str:
    return " ".join(repr(n) for n in np.ravel(np.asarray(numbers)).tolist())
