"""Whether what a hand holds, or what that pushes on, is pressed into something else: not every engine's ties give."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmspec.scene.contact import colliders
from wmspec.scene.model import Contact, Grip, Pose, Scene, Trace
from wmspec.scene.overlap import overlap
from wmspec.scene.transform import compose

DEEP = 0.002  # m: engines let things sink into one another by less
LOOKS = 30  # Hz


def pressed(scene: Scene, trace: Trace) -> tuple[float, str, str, float] | None:
    """When (s) which two bodies are first more than `DEEP` in one another, and how deep (m), while a hand leads one."""
    found = [press for grip in scene.actions if isinstance(grip, Grip) for press in _presses(scene, trace, grip)]
    return min(found, default=None)


def _presses(scene: Scene, trace: Trace, grip: Grip) -> Iterator[tuple[float, str, str, float]]:
    """For each contact that what is held makes, or what touches that in turn, when it is first too deep."""
    bodies = {body.name: body for body in scene.bodies}
    touched = [c for c in trace.contacts if c.start < grip.stop and c.stop > grip.start]
    led, left = {grip.body}, [c for c in touched if grip.hand not in (c.first, c.second)]
    while near := [c for c in left if led & {c.first, c.second}]:
        left = [c for c in left if c not in near]
        led |= {name for c in near for name in (c.first, c.second) if bodies[name].motion == "dynamic"}
        for contact in near:
            start, stop = max(contact.start, grip.start), min(contact.stop, grip.stop)
            if press := _first(scene, trace, contact, start, stop):
                yield press


def _first(
    scene: Scene, trace: Trace, contact: Contact, start: float, stop: float
) -> tuple[float, str, str, float] | None:
    """When two bodies are first too deep in one another between two times (s), and how deep (m)."""
    numbers = [trace.bodies.index(name) for name in (contact.first, contact.second)]
    for time in np.linspace(start, stop, max(2, round((stop - start) * LOOKS))).tolist():
        i = trace.sample(time)
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
