"""Whether what an arm holds or pushes, or what that pushes on, is pressed into something else.

Arms go where they are told whatever is in the way, and not every engine's ties give.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from wmspec.sim.scene.model import Contact, Follow, Grip, Pose, Scene, Trace
from wmspec.sim.scene.model.bounds import upright
from wmspec.sim.scene.model.transform import compose, rotate
from wmspec.sim.scene.physics.contact import colliders
from wmspec.sim.scene.physics.overlap import overlap

DEEP = 0.002  # m: engines let things sink into one another by less
AWAY = 0.01  # m: so far beside the box around a thing fingers do not have it
LOOKS = 30  # Hz
LINKS = 3  # so many bodies are led by one action where that is an arm's


def pressed(scene: Scene, trace: Trace) -> tuple[float, str, str, float] | None:
    """When (s) which two bodies are first more than `DEEP` in one another, and how deep (m), while an arm leads one."""
    ways = [action for action in scene.actions if isinstance(action, Follow)]
    links = Counter(way.name for way in ways)
    arms = {way.body for way in ways if links[way.name] >= LINKS}
    led = [(grip.body, grip.start, grip.stop) for grip in scene.actions if isinstance(grip, Grip)]
    for contact in trace.contacts:
        for one, other in ((contact.first, contact.second), (contact.second, contact.first)):
            if one in arms:
                led.append((other, contact.start, contact.stop))
    found = [press for one in led for press in _presses(scene, trace, *one)]
    return min(found, default=None)


def missed(scene: Scene, trace: Trace) -> tuple[float, str, str] | None:
    """When (s) which hand closes on nothing of which thing that it is to hold, since something has moved that."""
    bodies = {body.name: (i, body) for i, body in enumerate(scene.bodies)}
    grips = (a for a in scene.actions if isinstance(a, Grip) and a.start <= trace.time[-1])
    for grip in sorted(grips, key=lambda grip: grip.start):
        i = trace.sample(grip.start)
        (hand, _), (held, body) = bodies[grip.hand], bodies[grip.body]
        tool = trace.position[i, hand] + rotate(trace.orientation[i, hand], grip.points.mean(axis=0))
        low, high = upright(body.geoms, Pose(trace.position[i, held], trace.orientation[i, held]))
        if ((tool < low - AWAY) | (high + AWAY < tool)).any():
            return float(trace.time[i]), grip.hand, grip.body
    return None


def _presses(
    scene: Scene, trace: Trace, body: str, since: float, until: float
) -> Iterator[tuple[float, str, str, float]]:
    """For each contact that a led body makes meanwhile, or what touches that in turn, when it is first too deep."""
    free = {b.name for b in scene.bodies if b.motion == "dynamic"}
    led, left = {body}, [c for c in trace.contacts if c.start < until and c.stop > since]
    while near := [c for c in left if led & {c.first, c.second}]:
        left = [c for c in left if c not in near]
        led |= {name for c in near for name in (c.first, c.second) if name in free}
        for contact in near:
            if press := _first(scene, trace, contact, max(contact.start, since), min(contact.stop, until)):
                yield press


def _first(
    scene: Scene, trace: Trace, contact: Contact, start: float, stop: float
) -> tuple[float, str, str, float] | None:
    """When two bodies are first too deep in one another between two times (s), and how deep (m)."""
    numbers, before = [trace.bodies.index(name) for name in (contact.first, contact.second)], b""
    for time in np.linspace(start, stop, max(2, round((stop - start) * LOOKS))).tolist():
        i = trace.sample(time)
        here = trace.position[i, numbers].tobytes() + trace.orientation[i, numbers].tobytes()
        if here == before:  # what has not moved is as deep as it was
            continue
        before = here
        one, other = (
            [
                (g.shape, compose(Pose(trace.position[i, n], trace.orientation[i, n]), g.pose))
                for g in colliders(scene.bodies[n])
            ]
            for n in numbers
        )
        depth = max((overlap(*a, *b, DEEP) for a in one for b in other), default=0.0)
        if depth > 0:
            return float(trace.time[i]), contact.first, contact.second, depth
    return None
