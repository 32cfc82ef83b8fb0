"""The scene as MJCF: what MuJoCo executes here, and what its own viewer opens."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import degrees
from xml.etree import ElementTree as ET

import numpy as np

from wmspec.sim.scene.joints.articulations import WORLD, Tree
from wmspec.sim.scene.joints.com_frame import com_frame, mount, placed
from wmspec.sim.scene.model import Array, Body, Camera, Friction, Geom, Light, Pose, Scene
from wmspec.sim.scene.model.transform import compose, conjugate, inverse, rotate
from wmspec.sim.scene.physics.contact import mix, touchable
from wmspec.sim.scene.physics.episode import TOUCH, Episode, Kick, Vector
from wmspec.sim.scene.physics.rigid import Assembly
from wmspec.sim.scene.physics.speed import gyroscopic

from .impact import IMPEDANCE, solref, solreffriction
from .joints import actuator, control, hang
from .text import text
from .world import HEAVY, rates

SPIN, ROLL = 0.005, 0.0001  # required by the format, without effect at condim 3
RESTING = 1e-6  # m/s
_HIDDEN = "3"  # the group of geoms that viewers don't show at first


def mjcf(scene: Scene, episode: Episode, whole: Assembly, *, seen: bool = True) -> str:
    """A model, with one `pair` per pair that may touch.

    Bodies are in the scene's order, those in trees below their parents, frames at their centres of mass. What is
    not to be `seen` is without the shapes that only show. What has no others does not move as it is told then, and is
    left out unless something is tied to it.
    """
    root, trees = ET.Element("mujoco", model=scene.name), whole.trees
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    driven = any(limb.drive for tree in trees for limb in tree)
    integrator = "implicitfast" if driven else "RK4" if _tumbles(scene) else "Euler"
    # what joints hold, or what is held, may begin to move more slowly than what rests
    _options(root, episode, integrator, sleep=integrator == "Euler" and not (scene.joints or episode.holds))
    asset, world, contact = (ET.SubElement(root, tag) for tag in ("asset", "worldbody", "contact"))
    _light(world, scene.light)
    bodies = tuple(com_frame(body if seen else _felt(body)) for body in scene.bodies)
    elements = _bodies(world, asset, bodies, trees)
    limbs = {limb.body: limb for tree in trees for limb in tree}
    for i, body in enumerate(bodies):
        if i in limbs:
            hang(elements[i], limbs[i], scene, episode.step)
        elif body.motion != "static":
            elements[i].insert(0, ET.Element("freejoint", name=body.name))
    for camera in scene.cameras:
        rides = next((i for i, body in enumerate(scene.bodies) if body.name == camera.body), WORLD)
        pose = camera.pose if rides == WORLD else compose(mount(scene.bodies[rides]), camera.pose)
        _camera(elements[rides], camera, pose)
    for a, g, b, h in touchable(scene):
        led = "kinematic" in (a.motion, b.motion)
        _pair(contact, f"{a.name}/{g.name}", f"{b.name}/{h.name}", mix(g.friction, h.friction), episode, led)
    _equality(root, scene, episode, whole)
    drives = [limb for tree in trees for limb in tree if limb.drive]
    actuators = ET.SubElement(root, "actuator") if drives else root
    for limb in drives:
        actuator(actuators, limb, scene)
    _keyframe(root, bodies, episode, whole, [control(limb) for limb in drives])
    if not seen:
        _leave_out(root, world)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _leave_out(root: ET.Element, world: ET.Element) -> None:
    """Take out what has no shape, stands still, carries nothing, and is tied to nothing."""
    tied = {tie.get(end) for tie in root.iterfind("equality/connect") for end in ("body1", "body2")}
    for body in world.findall("body"):
        if not len(body) and body.get("name") not in tied:
            world.remove(body)


def _felt(body: Body) -> Body:
    """The body without what is only seen of it; what moves as it is told and can't be touched stands still."""
    geoms = tuple(replace(geom, visible=False) for geom in body.geoms if geom.collides)
    still = body.motion == "kinematic" and body.inertia is None and not geoms
    return replace(body, geoms=geoms, motion="static" if still else body.motion)


def _bodies(
    world: ET.Element, asset: ET.Element, bodies: Sequence[Body], trees: Sequence[Tree]
) -> dict[int, ET.Element]:
    """The elements of the bodies by their numbers, and the world's by `WORLD`."""
    parents = {limb.body: limb.parent for tree in trees for limb in tree}
    elements = {WORLD: world}
    for i in _order(bodies, trees):
        parent = parents.get(i, WORLD)
        place = bodies[i].pose if parent == WORLD else compose(inverse(bodies[parent].pose), bodies[i].pose)
        elements[i] = _body(elements[parent], asset, bodies[i], place)
    return elements


def _tumbles(scene: Scene) -> bool:
    """Whether something spins fast, and nothing can be touched."""
    return gyroscopic(scene) and not any(touchable(scene))


def _options(root: ET.Element, episode: Episode, integrator: str, sleep: bool) -> None:
    """MuJoCo's settings.

    What is slower than `RESTING` for ten steps sleeps, with all that it touches: MuJoCo leaves it out until a force, a
    velocity or something awake wakes it. What would begin to slide that slowly, at less than 0.4 mm/s², stays.

    Stiff drives are damped without bounds on the step by one of its integrators only. What spins fast keeps its energy
    in another, of fourth order: a gyroscope at 50 rad/s gained 42 % in a second.
    """
    option = ET.SubElement(
        root,
        "option",
        timestep=text([episode.step]),
        gravity=text(episode.gravity),
        cone="elliptic",
        integrator=integrator,
        solver="Newton",
        iterations="100",
        tolerance="1e-10",
        jacobian="dense",
        sleep_tolerance=text([RESTING]),
    )
    ET.SubElement(option, "flag", multiccd="enable", sleep="enable" if sleep else "disable")


def _light(world: ET.Element, light: Light) -> None:
    ET.SubElement(
        world,
        "light",
        directional="true",
        pos="0 0 3",
        dir=text(light.direction),
        diffuse=text([light.diffuse] * 3),
        ambient=text([light.ambient] * 3),
        specular="0 0 0",
    )


def _camera(around: ET.Element, camera: Camera, pose: Pose) -> None:
    ET.SubElement(around, "camera", {"name": camera.name, "fovy": text([degrees(camera.fovy)]), **_pose(pose)})


def _order(bodies: Sequence[Body], trees: Sequence[Tree]) -> Iterator[int]:
    """The bodies in order, those of a tree right after its root."""
    limbs = {tree[0].body: tree for tree in trees}
    below = {limb.body for tree in trees for limb in tree[1:]}
    for i in range(len(bodies)):
        if i not in below:
            yield from (limb.body for limb in limbs[i]) if i in limbs else (i,)


def _body(around: ET.Element, asset: ET.Element, body: Body, pose: Pose) -> ET.Element:
    """A body at its pose in the one around it; a kinematic one is a heavy body whose state is set before every step."""
    element = ET.SubElement(around, "body", {"name": body.name, **_pose(pose)})
    if body.motion != "static":
        mass, moments = (HEAVY, [HEAVY] * 3) if body.inertia is None else (body.inertia.mass, body.inertia.moments)
        ET.SubElement(element, "inertial", pos="0 0 0", mass=text([mass]), diaginertia=text(moments))
    if body.motion == "kinematic":
        element.set("gravcomp", "1")
        element.set("sleep", "never")
    for geom in body.geoms:
        _geom(element, asset, f"{body.name}/{geom.name}", geom)
    return element


def _geom(element: ET.Element, asset: ET.Element, name: str, geom: Geom) -> None:
    """What collides and what is drawn: one geom, but for what is not convex, whose hull collides out of sight."""
    look = {"rgba": text([*geom.surface.color, 1.0])}
    hidden = {} if geom.visible else {"group": _HIDDEN}
    if geom.shape.primitive is not None:
        _add(element, name, {**_primitive(*geom.shape.primitive), **_pose(geom.pose), **look, **hidden})
        return
    if geom.shape.convex or geom.collides:
        apart = {} if geom.shape.convex else {"group": _HIDDEN}
        _hull(asset, name, placed(geom.pose, geom.shape.corners()))
        _add(element, name, {"type": "mesh", "mesh": name, **apart, **look, **hidden})
    if geom.visible and not geom.shape.convex:
        points, faces = geom.shape.triangles()
        points = np.concatenate([points, points[:1].repeat(max(0, 4 - len(points)), axis=0)])  # MuJoCo wants four
        mesh = {"name": f"{name}/seen", "vertex": text(points), "face": text(faces), "inertia": "shell"}
        ET.SubElement(asset, "mesh", mesh)
        _add(element, f"{name}/seen", {"type": "mesh", "mesh": f"{name}/seen", **_pose(geom.pose), **look})


def _hull(asset: ET.Element, name: str, points: Array) -> None:
    ET.SubElement(asset, "mesh", name=name, vertex=text(points), inertia="convex")


def _add(element: ET.Element, name: str, attributes: dict[str, str]) -> None:
    """Nothing touches by itself: what touches is listed, as pairs."""
    ET.SubElement(element, "geom", {"name": name, "contype": "0", "conaffinity": "0", **attributes})


def _primitive(kind: str, size: tuple[float, ...]) -> dict[str, str]:
    return {"type": kind, "size": text(size if kind == "box" else [size[0], *(height / 2 for height in size[1:])])}


def _pair(contact: ET.Element, first: str, second: str, pair: Friction, episode: Episode, led: bool) -> None:
    ET.SubElement(
        contact,
        "pair",
        geom1=first,
        geom2=second,
        condim="3" if pair.dynamic > 0 else "1",
        friction=text([pair.dynamic, pair.dynamic, SPIN, ROLL, ROLL]),
        solref=text(solref(pair, episode.step)),
        solreffriction=text(solreffriction(pair, episode.step, led)),
        solimp=text([IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0]),
        gap=text([TOUCH]),  # seen from there on, pushed from 0 on
    )


def _equality(root: ET.Element, scene: Scene, episode: Episode, whole: Assembly) -> None:
    """What holds as stiffly as steps let.

    The points by which bodies will be held, not yet active, those that close loops, and joints that mimic others.
    """
    if not (episode.grips or whole.ties or whole.gears):
        return
    equality = ET.SubElement(root, "equality")
    solref = text([-((0.1 / episode.step) ** 2), -0.5 / episode.step])
    for tie in whole.ties:
        names = {"body1": scene.bodies[tie.second].name, "body2": scene.bodies[tie.first].name}
        points = tie.below
        if tie.first == WORLD:
            del names["body2"]
        elif tie.second == WORLD:
            names, points = {"body1": names["body2"]}, tie.above
        for i, point in enumerate(points):
            name = f"{scene.joints[tie.joint].name} {i}"
            made = ET.SubElement(equality, "connect", {"name": name, **names, "anchor": text(point), "solref": solref})
            made.set("solimp", text([IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0]))
    leads = {link.body: scene.joints[link.joint].name for tree in whole.trees for link in tree if link.joint >= 0}
    for gear in whole.gears:  # as coordinates are since the start, at which it fits
        both = {"joint1": scene.joints[gear.joint].name, "joint2": leads[gear.leader], "solref": solref}
        made = ET.SubElement(equality, "joint", both, polycoef=text([0.0, gear.ratio, 0.0, 0.0, 0.0]))
        made.set("solimp", text([IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0]))
    for number, grip in enumerate(episode.grips):
        for i in range(len(grip.points)):
            ET.SubElement(
                equality,
                "connect",
                name=f"grip {number} {i}",
                body1=scene.bodies[grip.hand].name,
                body2=scene.bodies[grip.body].name,
                anchor="0 0 0",
                active="false",
                solref=solref,
                solimp=text([IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0]),
            )


def _keyframe(
    root: ET.Element, bodies: Sequence[Body], episode: Episode, whole: Assembly, controls: Sequence[float]
) -> None:
    """The start, with initial velocities, bodies as they are nested; MuJoCo wants angular ones in the body's axes."""
    index = {body.name: i for i, body in enumerate(bodies)}
    limbs = {limb.body: limb for tree in whole.trees for limb in tree}
    kicks = {kick.body: kick for kick in episode.kicks if kick.step == 0}
    places: list[float] = []
    speeds: list[float] = []
    for i in (index[element.attrib["name"]] for element in root.iter("body")):
        kind = limbs[i].kind if i in limbs else "static" if bodies[i].motion == "static" else "free"
        match kind:
            case "free":
                places += episode.start[i]
                if i not in limbs:
                    speeds += _speeds(kicks[i], episode.start[i]) if i in kicks else [0.0] * 6
            case "ball":
                places += [1.0, 0.0, 0.0, 0.0]
            case "hinge" | "slider":
                places.append(limbs[i].start)
        if i in limbs:
            speeds += rates(limbs[i], whole.bodies[i])
    if places:
        key = ET.SubElement(ET.SubElement(root, "keyframe"), "key", name="start", qpos=text(places), qvel=text(speeds))
        if controls:
            key.set("ctrl", text(controls))


def _speeds(kick: Kick, start: Vector) -> list[float]:
    return [*kick.linear, *rotate(conjugate(np.array(start[3:])), np.array(kick.angular)).tolist()]


def _pose(pose: Pose) -> dict[str, str]:
    return {"pos": text(pose.position), "quat": text(pose.orientation)}
