"""Scenes as MJCF, executed here and opened by MuJoCo's viewer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import degrees
from xml.etree import ElementTree as ET

import numpy as np

from wmspec.sim.scene.joints.articulations import WORLD, Tree
from wmspec.sim.scene.joints.com_frame import body_frame_in_com, com_frame, transform_points
from wmspec.sim.scene.model import Array, Body, Camera, Friction, Geom, Light, Pose, Scene
from wmspec.sim.scene.model.transform import compose, conjugate, inverse, rotate
from wmspec.sim.scene.physics.contact import colliding_geoms, combine_friction
from wmspec.sim.scene.physics.episode import TOUCH_END, Episode, Kick, Vector
from wmspec.sim.scene.physics.rigid import Assembly
from wmspec.sim.scene.physics.speed import has_gyroscopic_spin

from .impact import ROLLING_FRICTION, SOLIMP, TORSIONAL_FRICTION, constraint_solref, solref, solreffriction
from .joints import add_actuator, add_joint, initial_control
from .text import text
from .world import HEAVY, rates

SLEEP_SPEED = 1e-6  # m/s
_HIDDEN = "3"  # geom group that viewers hide by default


def mjcf(scene: Scene, episode: Episode, whole: Assembly, *, seen: bool = True) -> str:
    """Return a model with one `pair` per pair of geoms that can collide.

    Bodies are in scene order, those of trees below their parents, with frames at their centres of mass. Without `seen`,
    visual-only shapes are omitted; kinematic bodies that cannot collide then rest, and are omitted unless tied to
    something.
    """
    root, trees = ET.Element("mujoco", model=scene.name), whole.trees
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    driven = any(limb.drive for tree in trees for limb in tree)
    integrator = "implicitfast" if driven else "RK4" if _is_free_tumbling(scene) else "Euler"
    # jointed and held bodies may start to move slower than the sleep threshold; a passage opens below sleeping ones
    wakeful = bool(scene.joints or episode.holds or episode.passages)
    _options(root, episode, integrator, sleep=integrator == "Euler" and not wakeful)
    asset, world, contact = (ET.SubElement(root, tag) for tag in ("asset", "worldbody", "contact"))
    _light(world, scene.light)
    bodies = tuple(com_frame(body if seen else _collision_body(body)) for body in scene.bodies)
    elements = _bodies(world, asset, bodies, trees)
    limbs = {limb.body: limb for tree in trees for limb in tree}
    for i, body in enumerate(bodies):
        if i in limbs:
            add_joint(elements[i], limbs[i], scene, episode.step)
        elif body.motion != "static":
            elements[i].insert(0, ET.Element("freejoint", name=body.name))
    for camera in scene.cameras:
        rides = next((i for i, body in enumerate(scene.bodies) if body.name == camera.body), WORLD)
        pose = camera.pose if rides == WORLD else compose(body_frame_in_com(scene.bodies[rides]), camera.pose)
        _camera(elements[rides], camera, pose)
    for a, g, b, h in colliding_geoms(scene):
        led = "kinematic" in (a.motion, b.motion)
        _pair(
            contact, f"{a.name}/{g.name}", f"{b.name}/{h.name}", combine_friction(g.friction, h.friction), episode, led
        )
    _equality(root, scene, episode, whole)
    drives = [limb for tree in trees for limb in tree if limb.drive]
    actuators = ET.SubElement(root, "actuator") if drives else root
    for limb in drives:
        add_actuator(actuators, limb, scene)
    _keyframe(root, bodies, episode, whole, [initial_control(limb) for limb in drives])
    if not seen:
        _remove_inert_bodies(root, world)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _remove_inert_bodies(root: ET.Element, world: ET.Element) -> None:
    """Remove bodies without shapes that rest, carry nothing, and are not tied."""
    tied = {tie.get(end) for tie in root.iterfind("equality/connect") for end in ("body1", "body2")}
    for body in world.findall("body"):
        if not len(body) and body.get("name") not in tied:
            world.remove(body)


def _collision_body(body: Body) -> Body:
    """Return a body without visual-only shapes; a kinematic one without collisions becomes static."""
    geoms = tuple(replace(geom, visible=False) for geom in body.geoms if geom.collides)
    still = body.motion == "kinematic" and body.inertia is None and not geoms
    return replace(body, geoms=geoms, motion="static" if still else body.motion)


def _bodies(
    world: ET.Element, asset: ET.Element, bodies: Sequence[Body], trees: Sequence[Tree]
) -> dict[int, ET.Element]:
    """Return the elements of bodies by number, with the world at `WORLD`."""
    parents = {limb.body: limb.parent for tree in trees for limb in tree}
    elements = {WORLD: world}
    for i in _order(bodies, trees):
        parent = parents.get(i, WORLD)
        place = bodies[i].pose if parent == WORLD else compose(inverse(bodies[parent].pose), bodies[i].pose)
        elements[i] = _body(elements[parent], asset, bodies[i], place)
    return elements


def _is_free_tumbling(scene: Scene) -> bool:
    """Whether something spins fast and nothing can collide."""
    return has_gyroscopic_spin(scene) and not any(colliding_geoms(scene))


def _options(root: ET.Element, episode: Episode, integrator: str, sleep: bool) -> None:
    """Set MuJoCo's options.

    Bodies slower than `SLEEP_SPEED` for ten steps sleep together with their contacts: MuJoCo skips them until a force,
    a velocity or an awake body wakes them. A body that would start to slide at less than 0.4 mm/s² stays.

    Only one integrator damps stiff drives at any step size. Another, of fourth order, conserves the energy of fast
    spins: with the default a gyroscope at 50 rad/s gained 42 % in a second.
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
        sleep_tolerance=text([SLEEP_SPEED]),
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
    """Yield bodies in order, those of a tree directly after its root."""
    limbs = {tree[0].body: tree for tree in trees}
    below = {limb.body for tree in trees for limb in tree[1:]}
    for i in range(len(bodies)):
        if i not in below:
            yield from (limb.body for limb in limbs[i]) if i in limbs else (i,)


def _body(around: ET.Element, asset: ET.Element, body: Body, pose: Pose) -> ET.Element:
    """Add a body at its pose in its parent; a kinematic one is a heavy body whose state is set before every step."""
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
    """Add collision and visual geom: one geom, except that a non-convex shape collides as its hidden hull."""
    look = {"rgba": text([*geom.surface.color, 1.0])}
    hidden = {} if geom.visible else {"group": _HIDDEN}
    if geom.shape.primitive is not None:
        _add(element, name, {**_primitive(*geom.shape.primitive), **_pose(geom.pose), **look, **hidden})
        return
    if geom.shape.convex or geom.collides:
        apart = {} if geom.shape.convex else {"group": _HIDDEN}
        _hull(asset, name, transform_points(geom.pose, geom.shape.corners()))
        _add(element, name, {"type": "mesh", "mesh": name, **apart, **look, **hidden})
    if geom.visible and not geom.shape.convex:
        points, faces = geom.shape.triangles()
        points = np.concatenate(
            [points, points[:1].repeat(max(0, 4 - len(points)), axis=0)]
        )  # MuJoCo needs four points
        mesh = {"name": f"{name}/seen", "vertex": text(points), "face": text(faces), "inertia": "shell"}
        ET.SubElement(asset, "mesh", mesh)
        _add(element, f"{name}/seen", {"type": "mesh", "mesh": f"{name}/seen", **_pose(geom.pose), **look})


def _hull(asset: ET.Element, name: str, points: Array) -> None:
    ET.SubElement(asset, "mesh", name=name, vertex=text(points), inertia="convex")


def _add(element: ET.Element, name: str, attributes: dict[str, str]) -> None:
    """Add a geom that collides only through listed pairs."""
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
        friction=text([pair.dynamic, pair.dynamic, TORSIONAL_FRICTION, ROLLING_FRICTION, ROLLING_FRICTION]),
        solref=text(solref(pair, episode.step)),
        solreffriction=text(solreffriction(pair, episode.step, led)),
        solimp=text(SOLIMP),
        gap=text([TOUCH_END]),  # detected from the margin on, force from 0 on
    )


def _equality(root: ET.Element, scene: Scene, episode: Episode, whole: Assembly) -> None:
    """Add constraints that are as stiff as the step allows.

    These are grip points (inactive at first), loop closures, and mimic joints.
    """
    if not (episode.grips or whole.loop_closures or whole.mimic_constraints):
        return
    equality = ET.SubElement(root, "equality")
    stiff = {"solref": text(constraint_solref(episode.step)), "solimp": text(SOLIMP)}
    for tie in whole.loop_closures:
        names = {"body1": scene.bodies[tie.second].name, "body2": scene.bodies[tie.first].name}
        points = tie.below
        if tie.first == WORLD:
            del names["body2"]
        elif tie.second == WORLD:
            names, points = {"body1": names["body2"]}, tie.above
        for i, point in enumerate(points):
            name = f"{scene.joints[tie.joint].name} {i}"
            ET.SubElement(equality, "connect", {"name": name, **names, "anchor": text(point), **stiff})
    leads = {link.body: scene.joints[link.joint].name for tree in whole.trees for link in tree if link.joint >= 0}
    for gear in whole.mimic_constraints:  # coordinates are relative to the start, where the constraint holds
        both = {"joint1": scene.joints[gear.joint].name, "joint2": leads[gear.leader]}
        ET.SubElement(equality, "joint", {**both, "polycoef": text([0.0, gear.ratio, 0.0, 0.0, 0.0]), **stiff})
    for number, grip in enumerate(episode.grips):
        names = {"body1": scene.bodies[grip.hand].name, "body2": scene.bodies[grip.body].name}
        for i in range(len(grip.points)):
            at = {"name": f"grip {number} {i}", **names, "anchor": "0 0 0", "active": "false"}
            ET.SubElement(equality, "connect", {**at, **stiff})


def _keyframe(
    root: ET.Element, bodies: Sequence[Body], episode: Episode, whole: Assembly, controls: Sequence[float]
) -> None:
    """Add the initial state in order of nesting; MuJoCo expects angular velocities in body axes."""
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
