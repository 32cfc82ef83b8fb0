"""Detects failed grasps, and bodies that an arm squeezes into other bodies.

Arms are kinematic and do not yield, and neither do the ties of some engines.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from wmspec.sim.scene.model import Contact, Follow, Grip, Pose, Scene, Trace
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.scene.model.transform import compose, rotate
from wmspec.sim.scene.physics.contact import colliders
from wmspec.sim.scene.physics.overlap import overlap

MAX_PENETRATION = 0.002  # m: engines allow less in normal contacts
MAX_GRASP_OFFSET = 0.01  # m: largest distance of the fingertips from the box of a grasped body
CHECK_RATE = 30  # Hz
MIN_ARM_LINKS = 3  # an action that moves at least this number of bodies belongs to an arm

#: The numbers of a sample and of two bodies.
_Place = tuple[int, int, int]


def penetration(scene: Scene, trace: Trace) -> tuple[float, str, str, float] | None:
    """Return time (s), two bodies and depth (m) of the first penetration above `MAX_PENETRATION` caused by an arm."""
    ways = [action for action in scene.actions if isinstance(action, Follow)]
    links = Counter(way.name for way in ways)
    arms = {way.body for way in ways if links[way.name] >= MIN_ARM_LINKS}
    led = [(grip.body, grip.start, grip.stop) for grip in scene.actions if isinstance(grip, Grip)]
    for contact in trace.contacts:
        for one, other in ((contact.first, contact.second), (contact.second, contact.first)):
            if one in arms:
                led.append((other, contact.start, contact.stop))
    known: dict[_Place, float] = {}
    found = [press for one in led for press in _presses(scene, trace, known, *one)]
    return min(found, default=None)


def missed_grasp(scene: Scene, trace: Trace) -> tuple[float, str, str] | None:
    """Return time (s), hand and body of the first grip that begins with the body outside the fingers."""
    bodies = {body.name: (i, body) for i, body in enumerate(scene.bodies)}
    grips = (a for a in scene.actions if isinstance(a, Grip) and a.start <= trace.time[-1])
    for grip in sorted(grips, key=lambda grip: grip.start):
        i = trace.sample(grip.start)
        (hand, _), (held, body) = bodies[grip.hand], bodies[grip.body]
        tool = trace.position[i, hand] + rotate(trace.orientation[i, hand], grip.points.mean(axis=0))
        low, high = world_box(body.geoms, Pose(trace.position[i, held], trace.orientation[i, held]))
        if ((tool < low - MAX_GRASP_OFFSET) | (high + MAX_GRASP_OFFSET < tool)).any():
            return float(trace.time[i]), grip.hand, grip.body
    return None


def _presses(
    scene: Scene, trace: Trace, known: dict[_Place, float], body: str, since: float, until: float
) -> Iterator[tuple[float, str, str, float]]:
    """Yield the first penetration of each contact of a guided body, and of bodies that it pushes in turn."""
    free = {b.name for b in scene.bodies if b.motion == "dynamic"}
    led, left = {body}, [c for c in trace.contacts if c.start < until and c.stop > since]
    while near := [c for c in left if led & {c.first, c.second}]:
        left = [c for c in left if c not in near]
        led |= {name for c in near for name in (c.first, c.second) if name in free}
        for contact in near:
            if press := _first(scene, trace, known, contact, max(contact.start, since), min(contact.stop, until)):
                yield press


def _first(
    scene: Scene, trace: Trace, known: dict[_Place, float], contact: Contact, start: float, stop: float
) -> tuple[float, str, str, float] | None:
    """Return time (s), bodies and depth (m) of the first penetration between two times (s).

    `known` holds the depths that were computed for other guided bodies.
    """
    numbers, before = [trace.bodies.index(name) for name in (contact.first, contact.second)], b""
    for time in np.linspace(start, stop, max(2, round((stop - start) * CHECK_RATE))).tolist():
        i = trace.sample(time)
        here = trace.position[i, numbers].tobytes() + trace.orientation[i, numbers].tobytes()
        if here == before:  # unchanged poses have unchanged depth
            continue
        before = here
        place = (i, numbers[0], numbers[1])
        if place not in known:
            known[place] = _depth(scene, trace, *place)
        if known[place] > 0:
            return float(trace.time[i]), contact.first, contact.second, known[place]
    return None


def _depth(scene: Scene, trace: Trace, i: int, first: int, second: int) -> float:
    """Return the depth (m) of the penetration of two bodies at sample `i`."""
    one, other = (
        [
            (g.shape, compose(Pose(trace.position[i, n], trace.orientation[i, n]), g.pose))
            for g in colliders(scene.bodies[n])
        ]
        for n in (first, second)
    )
    return max((overlap(*a, *b, MAX_PENETRATION) for a in one for b in other), default=0.0)
