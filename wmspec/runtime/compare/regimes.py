"""Detects motion that engines get wrong in executed traces: agreement is no evidence there.

`wmspec conformance` measures the errors; `wmspec check` warns beforehand, as WMS608.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from wmspec.runtime.compare.allow import closing_speed, impacts, sample_index
from wmspec.runtime.compare.model import Regime
from wmspec.runtime.engines.registry import info, names
from wmspec.sim.scene.capability import (
    DOUBLE_PENDULUMS,
    FAST_SPINS,
    HEAVY_LANDINGS,
    LEANING_CYLINDERS,
    ROLLING_CYLINDERS,
    SLIDING_MESHES,
    Capability,
    approximation_warnings,
)
from wmspec.sim.scene.joints.articulations import trees
from wmspec.sim.scene.model import (
    Body,
    Contact,
    Force,
    Impulse,
    Joint,
    JointKind,
    Launch,
    PassThrough,
    Pose,
    Release,
    Scene,
    Teleport,
    Trace,
    Vanish,
)
from wmspec.sim.scene.model.transform import conjugate, rotate
from wmspec.sim.scene.physics.contact import colliders, combine_friction
from wmspec.sim.scene.physics.initial_drops import initial_drops, is_inelastic
from wmspec.sim.scene.regime_thresholds import (
    ELASTIC_RESTITUTION,
    FAST_DOUBLE_PENDULUM,
    FAST_SPIN,
    HEAVY_LANDING_RATIO,
    HEAVY_LANDING_SPEED,
    MAX_ENERGY_CHANGE,
    STEEP_COSINE,
    WHEEL_OFFSET,
    is_disc,
    is_leaning,
)
from wmspec.sim.shapes.cylinder import Cylinder

ROW = "bodies that touch each other all move at once when something strikes them"
#: Maximum speed (m/s) of a body at rest.
MAX_REST_SPEED = 0.05
#: Slides shorter than MIN_SLIDE (m), or with a rotation faster than MAX_SLIDE_SPIN (rad/s), are little affected.
MIN_SLIDE, MAX_SLIDE_SPIN = 0.05, 1.0


def regimes(scene: Scene, traces: tuple[Trace, ...], apart: float) -> tuple[Regime, ...]:
    """Return the regimes of a scene and its traces, each kind once; contacts are new after `apart` (s)."""
    engines = [info(trace.engine) for trace in traces if trace.engine in names()]
    found = [Regime(d.message, str(d.place)) for engine in engines for d in approximation_warnings(engine.lacks, scene)]
    found += [regime for trace in traces for regime in trace_regimes(scene, trace, apart)]
    return tuple({regime.kind: regime for regime in reversed(found)}.values())[::-1]


def trace_regimes(scene: Scene, trace: Trace, apart: float) -> tuple[Regime, ...]:
    """Return the regimes in one trace, each kind once."""
    found = [Regime(ROW, where) for where in _rows(scene, trace, apart)]
    engine = info(trace.engine) if trace.engine in names() else None
    lacking = {lack.capability for lack in engine.lacks} if engine else set()
    for capability, (kind, where_entered) in TRACE_REGIMES.items():
        if engine and capability in lacking:
            found += [Regime(f"{engine.title} {kind}", where) for where in where_entered(scene, trace, apart)]
    return tuple({regime.kind: regime for regime in reversed(found)}.values())[::-1]


def _rows(scene: Scene, trace: Trace, apart: float) -> Iterator[str]:
    """Yield impacts on a body in contact with a third one, all free, elastic and side by side."""
    bodies = {body.name: body for body in scene.bodies if body.motion == "dynamic" and colliders(body)}
    free = [c for c in trace.contacts if c.first in bodies and c.second in bodies]
    index = {name: i for i, name in enumerate(trace.bodies)}
    struck = {id(c) for c in impacts(trace, apart)}
    for hit in (c for c in free if id(c) in struck):
        if closing_speed(trace, index[hit.first], index[hit.second], hit.start) < MAX_REST_SPEED:
            continue
        for other in free:
            shared = {hit.first, hit.second} & {other.first, other.second}
            meets = (
                len(shared) == 1
                and other.start <= hit.start <= other.stop
                and _are_side_by_side(scene, trace, hit, other)
            )
            if meets and min(_bounce(bodies, hit), _bounce(bodies, other)) >= ELASTIC_RESTITUTION:
                (middle,) = shared
                first, third = (c.first if c.second == middle else c.second for c in (hit, other))
                yield f"`{first}` and `{middle}` meet at {hit.start:.3g} s, while `{middle}` already touches `{third}`"


def _bounce(bodies: dict[str, Body], contact: Contact) -> float:
    pair = [colliders(bodies[name])[0].friction for name in (contact.first, contact.second)]
    return combine_friction(*pair).restitution


def _are_side_by_side(scene: Scene, trace: Trace, *contacts: Contact) -> bool:
    """Whether touching bodies are side by side, not on top of each other."""
    size = np.linalg.norm(scene.gravity)
    up = scene.gravity / size if size else np.zeros(3)
    index = {name: i for i, name in enumerate(trace.bodies)}
    for contact in contacts:
        places = trace.position[sample_index(trace, contact.start)]
        way = places[index[contact.second]] - places[index[contact.first]]
        if abs(way @ up) > STEEP_COSINE * np.linalg.norm(way):
            return False
    return True


def _lands(scene: Scene, trace: Trace, apart: float) -> Iterator[str]:
    """Yield inelastic impacts of a heavy body on a supported lighter one."""
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    jointed = {name for joint in scene.joints for name in (joint.first, joint.second)}
    free = {b.name: b for b in scene.bodies if b.motion == "dynamic" and colliders(b) and b.name not in jointed}
    above = initial_drops(scene)
    for hit in impacts(trace, apart):
        if not {hit.first, hit.second} <= free.keys() or not is_inelastic(free[hit.first], free[hit.second]):
            continue
        light, heavy = sorted((hit.first, hit.second), key=lambda name: free[name].mass)
        least = HEAVY_LANDING_RATIO if (index[heavy], index[light]) in above else 1.0
        caught = any(
            light in (c.first, c.second) and heavy not in (c.first, c.second) and c.start < hit.start <= c.stop
            for c in trace.contacts
        )
        fast = closing_speed(trace, index[heavy], index[light], hit.start) > HEAVY_LANDING_SPEED
        if caught and fast and free[heavy].mass >= least * free[light].mass * (1 - 1e-6):
            yield f"`{heavy}` lands on `{light}` at {hit.start:.3g} s"


def _leans(scene: Scene, trace: Trace, _apart: float) -> Iterator[str]:
    """Yield cylinders at rest on slopes close to their tipping angle."""
    size = np.linalg.norm(scene.gravity)
    for i, body in enumerate(scene.bodies):
        for geom in colliders(body) if body.motion == "dynamic" and size and len(colliders(body)) == 1 else ():
            if not isinstance(shape := geom.shape, Cylinder):
                continue
            axis = rotate(trace.orientation[:, i], rotate(geom.pose.orientation, np.array([0.0, 0.0, 1.0])))
            angle = np.arccos(np.clip(np.abs(axis @ scene.gravity) / size, 0.0, 1.0))
            still = np.linalg.norm(trace.angular_velocity[:, i], axis=1) < MAX_REST_SPEED
            just = np.array([is_leaning(shape.radius, shape.height, float(a)) for a in angle])
            if (still & just & _touching(trace, body)).any():
                yield f"`{body.name}` stands {np.degrees(angle[still & just][0]):.3g} degrees from upright"


def _whips(scene: Scene, trace: Trace, _apart: float) -> Iterator[str]:
    """Yield bodies that swing fast from other swinging bodies; those rotating about their centre, like wheels, are
    excluded.
    """
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    swings = [j for j in scene.joints if j.kind in ("hinge", "ball") and j.drive is None]
    for joint in swings:
        ends = {joint.first, joint.second}
        if joint.first is None or not any(ends & {j.first, j.second} for j in swings if j is not joint):
            continue
        if _is_balanced(scene.bodies[index[joint.first]], joint.first_frame, joint.kind) or _is_balanced(
            scene.bodies[index[joint.second]], joint.second_frame, joint.kind
        ):
            continue
        first, second = (trace.angular_velocity[:, index[name]] for name in (joint.first, joint.second))
        fast = np.linalg.norm(second - first, axis=1) > FAST_DOUBLE_PENDULUM
        if fast.any():
            yield f"`{joint.second}` swings from `{joint.first}`, fast from {trace.time[fast][0]:.3g} s on"


def _spins(scene: Scene, trace: Trace, _apart: float) -> Iterator[str]:
    """Yield isolated fast spinning bodies that do not conserve energy."""
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    acted = {action.body for action in scene.actions if isinstance(action, _PUSHES)}
    moved = acted | {name for contact in trace.contacts for name in (contact.first, contact.second)}
    held = {link.body for tree in trees(scene) for link in tree}
    alone = [[i] for i, body in enumerate(scene.bodies) if body.motion == "dynamic" and i not in held]
    for group in [[link.body for link in tree] for tree in trees(scene)] + alone:
        bodies = [scene.bodies[i] for i in group]
        joints = [j for j in scene.joints if {j.first, j.second} & {body.name for body in bodies}]
        if moved & {body.name for body in bodies} or any(j.drive or j.limits or j.mimic for j in joints):
            continue
        if any(body.linear_damping or body.angular_damping for body in bodies):
            continue
        speeds = np.linalg.norm(trace.angular_velocity[:, group], axis=2)
        moving, falling = (
            sum(part) for part in zip(*(_energy(scene, trace, index[b.name]) for b in bodies), strict=True)
        )
        moving = moving + sum(_rotor_energy(scene, trace, joint) for joint in joints if joint.armature)
        off = np.abs(moving + falling - moving[0] - falling[0]) > MAX_ENERGY_CHANGE * np.abs(moving).max()
        if speeds.max() > FAST_SPIN and off.any():
            name = bodies[int(speeds.max(axis=0).argmax())].name
            yield f"`{name}` spins, its energy wrong from {trace.time[off][0]:.3g} s on"


_PUSHES = (Launch, Impulse, Force, Release, Vanish, PassThrough, Teleport)


def _energy(scene: Scene, trace: Trace, i: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return kinetic and potential energy (T,) of a body, J."""
    inertia = scene.bodies[i].inertia
    assert inertia is not None
    turn = trace.orientation[:, i]
    spin = rotate(conjugate(inertia.axes), rotate(conjugate(turn), trace.angular_velocity[:, i]))
    speed = trace.linear_velocity[:, i]
    motion = (inertia.mass * (speed**2).sum(axis=1) + (inertia.moments * spin**2).sum(axis=1)) / 2
    return motion, -inertia.mass * (trace.position[:, i] + rotate(turn, inertia.center)) @ scene.gravity


def _rotor_energy(scene: Scene, trace: Trace, joint: Joint) -> NDArray[np.float64]:
    """Return the kinetic energy (T,) of the armature of a hinge or slider, J."""
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    second, first = index[joint.second], None if joint.first is None else index[joint.first]
    axis = rotate(trace.orientation[:, second], rotate(joint.second_frame.orientation, np.array([1.0, 0.0, 0.0])))
    speeds = trace.angular_velocity if joint.kind == "hinge" else trace.linear_velocity
    rate = speeds[:, second].copy()
    if first is not None:
        rate -= speeds[:, first]
    if first is not None and joint.kind == "slider":  # both turn alike about their own centres
        apart = _centers(scene, trace, second) - _centers(scene, trace, first)
        rate -= np.cross(trace.angular_velocity[:, first], apart)
    return np.asarray(joint.armature / 2 * (rate * axis).sum(axis=1) ** 2)


def _centers(scene: Scene, trace: Trace, i: int) -> NDArray[np.float64]:
    """Return the centre of mass (T, 3) of a body, m."""
    inertia = scene.bodies[i].inertia
    center = np.zeros(3) if inertia is None else inertia.center
    return trace.position[:, i] + rotate(trace.orientation[:, i], center)


def _is_balanced(body: Body, frame: Pose, kind: JointKind) -> bool:
    """Whether a body's centre of mass is on the axis of its hinge, or at its ball joint."""
    if body.inertia is None:
        return False
    away = body.inertia.center - frame.position
    if kind == "hinge":
        axis = rotate(frame.orientation, np.array([1.0, 0.0, 0.0]))
        away = away - axis * (away @ axis)
    return bool(np.linalg.norm(away) < WHEEL_OFFSET * np.sqrt(body.inertia.moments.max() / body.inertia.mass))


def _rolls(scene: Scene, trace: Trace, _apart: float) -> Iterator[str]:
    """Yield short cylinders, or equally long ones that stood, that roll on their side."""
    size = np.linalg.norm(scene.gravity)
    for i, body in enumerate(scene.bodies):
        for geom in colliders(body) if body.motion == "dynamic" and size else ():
            if not isinstance(geom.shape, Cylinder):
                continue
            axis = rotate(trace.orientation[:, i], rotate(geom.pose.orientation, np.array([0.0, 0.0, 1.0])))
            stood = bool(abs(axis[0] @ scene.gravity) / size >= STEEP_COSINE)
            if not is_disc(geom.shape.radius, geom.shape.height, stands=stood):
                continue
            rolls = np.abs((axis * trace.angular_velocity[:, i]).sum(axis=1)) * geom.shape.radius > MAX_REST_SPEED
            lying = np.abs(axis @ scene.gravity) / size < STEEP_COSINE
            if (rolls & lying & _touching(trace, body)).any():
                yield f"`{body.name}` rolls from {trace.time[rolls & lying][0]:.3g} s on"
                break


def _slides(scene: Scene, trace: Trace, _apart: float) -> Iterator[str]:
    """Yield convex meshes that slide far enough to matter."""
    for i, body in enumerate(scene.bodies):
        if body.motion != "dynamic" or all(geom.shape.primitive for geom in colliders(body)):
            continue
        speed = np.linalg.norm(trace.linear_velocity[:, i], axis=1)
        flat = (speed > MAX_REST_SPEED) & (np.linalg.norm(trace.angular_velocity[:, i], axis=1) < MAX_SLIDE_SPIN)
        slides = flat & _touching(trace, body)
        if (speed[slides] / scene.rate).sum() > MIN_SLIDE:
            yield f"`{body.name}` slides from {trace.time[slides][0]:.3g} s on"


def _touching(trace: Trace, body: Body) -> NDArray[np.bool_]:
    """Return when (T,) a body touches anything."""
    touches = np.zeros(len(trace.time), np.bool_)
    for contact in trace.contacts:
        if body.name in (contact.first, contact.second):
            touches |= (contact.start <= trace.time) & (trace.time <= contact.stop)
    return touches


#: For each capability that some engines lack: its description, and the detector of its use in a trace.
TRACE_REGIMES: Mapping[Capability, tuple[str, Callable[[Scene, Trace, float], Iterator[str]]]] = {
    ROLLING_CYLINDERS: ("rolls discs as polygons, which brake", _rolls),
    LEANING_CYLINDERS: ("tips cylinders too early", _leans),
    HEAVY_LANDINGS: ("lets what lands on something lighter rise again", _lands),
    DOUBLE_PENDULUMS: ("loses or gains some of the energy of double pendulums", _whips),
    FAST_SPINS: ("loses or gains some of the energy of what spins fast", _spins),
    SLIDING_MESHES: ("brakes convex meshes that slide", _slides),
}
