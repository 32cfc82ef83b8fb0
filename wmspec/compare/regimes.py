"""Motion that engines get wrong, found on what they executed: their agreement proves nothing there.

`wmspec conform` measures how wrong; `wmspec check` warns of it beforehand, as WMS608.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from wmspec.compare.allow import closing, impacts, sample
from wmspec.compare.model import Regime
from wmspec.execute.backends import info, names
from wmspec.scene.capability import ROLLING_CYLINDERS, SLIDING_MESHES, Capability, approximated
from wmspec.scene.contact import colliders, mix
from wmspec.scene.hard import BOUNCY, STEEP, disc
from wmspec.scene.model import Body, Contact, Scene, Trace
from wmspec.scene.transform import rotate
from wmspec.shapes.cylinder import Cylinder

ROW = "what strikes bodies that touch each other is answered by all of them at once"
#: m/s: slower is at rest.
SLOW = 0.05
#: m and rad/s: what slides less far, or turns over faster, is not braked by much.
FAR, UPRIGHT = 0.05, 1.0


def regimes(scene: Scene, traces: tuple[Trace, Trace], apart: float) -> tuple[Regime, ...]:
    """What a scene and two traces of it enter, each kind once; a pair `apart` (s) for longer touches anew."""
    known = [(trace, info(trace.engine)) for trace in traces if trace.engine in names()]
    found = [Regime(d.message, str(d.place)) for _, engine in known for d in approximated(engine.lacks, scene)]
    found += [Regime(ROW, where) for trace in traces for where in _rows(scene, trace, apart)]
    for trace, engine in known:
        lacking = {lack.capability for lack in engine.lacks}
        for capability, (kind, entered) in SEEN.items():
            if capability in lacking:
                found += [Regime(f"{engine.title} {kind}", where) for where in entered(scene, trace)]
    return tuple({regime.kind: regime for regime in reversed(found)}.values())[::-1]


def _rows(scene: Scene, trace: Trace, apart: float) -> Iterator[str]:
    """Impacts on a body that touches a third one, all of them free and bouncy, and beside each other."""
    bodies = {body.name: body for body in scene.bodies if body.motion == "dynamic" and colliders(body)}
    free = [c for c in trace.contacts if c.first in bodies and c.second in bodies]
    index = {name: i for i, name in enumerate(trace.bodies)}
    struck = {id(c) for c in impacts(trace, apart)}
    for hit in (c for c in free if id(c) in struck):
        if closing(trace, index[hit.first], index[hit.second], hit.start) < SLOW:
            continue
        for other in free:
            shared = {hit.first, hit.second} & {other.first, other.second}
            meets = len(shared) == 1 and other.start <= hit.start <= other.stop and _beside(scene, trace, hit, other)
            if meets and min(_bounce(bodies, hit), _bounce(bodies, other)) >= BOUNCY:
                (middle,) = shared
                first, third = (c.first if c.second == middle else c.second for c in (hit, other))
                yield f"`{first}` and `{middle}` meet at {hit.start:.3g} s, when `{middle}` touches `{third}`"


def _bounce(bodies: dict[str, Body], contact: Contact) -> float:
    pair = [colliders(bodies[name])[0].friction for name in (contact.first, contact.second)]
    return mix(*pair).restitution


def _beside(scene: Scene, trace: Trace, *contacts: Contact) -> bool:
    """Whether bodies that touch are beside each other, not on top."""
    size = np.linalg.norm(scene.gravity)
    up = scene.gravity / size if size else np.zeros(3)
    index = {name: i for i, name in enumerate(trace.bodies)}
    for contact in contacts:
        places = trace.position[sample(trace, contact.start)]
        way = places[index[contact.second]] - places[index[contact.first]]
        if abs(way @ up) > STEEP * np.linalg.norm(way):
            return False
    return True


def _rolls(scene: Scene, trace: Trace) -> Iterator[str]:
    """Cylinders shorter than thick that roll on their sides."""
    size = np.linalg.norm(scene.gravity)
    for i, body in enumerate(scene.bodies):
        for geom in colliders(body) if body.motion == "dynamic" and size else ():
            if not (isinstance(geom.shape, Cylinder) and disc(geom.shape.radius, geom.shape.height)):
                continue
            axis = rotate(trace.orientation[:, i], rotate(geom.pose.orientation, np.array([0.0, 0.0, 1.0])))
            rolls = np.abs((axis * trace.angular_velocity[:, i]).sum(axis=1)) * geom.shape.radius > SLOW
            lying = np.abs(axis @ scene.gravity) / size < STEEP
            if (rolls & lying & _touching(trace, body)).any():
                yield f"`{body.name}` rolls from {trace.time[rolls & lying][0]:.3g} s on"
                break


def _slides(scene: Scene, trace: Trace) -> Iterator[str]:
    """Convex meshes that slide, as far as matters."""
    for i, body in enumerate(scene.bodies):
        if body.motion != "dynamic" or all(geom.shape.primitive for geom in colliders(body)):
            continue
        speed = np.linalg.norm(trace.linear_velocity[:, i], axis=1)
        flat = (speed > SLOW) & (np.linalg.norm(trace.angular_velocity[:, i], axis=1) < UPRIGHT)
        slides = flat & _touching(trace, body)
        if (speed[slides] / scene.rate).sum() > FAR:
            yield f"`{body.name}` slides from {trace.time[slides][0]:.3g} s on"


def _touching(trace: Trace, body: Body) -> NDArray[np.bool_]:
    """When (T,) a body touches anything."""
    touches = np.zeros(len(trace.time), np.bool_)
    for contact in trace.contacts:
        if body.name in (contact.first, contact.second):
            touches |= (contact.start <= trace.time) & (trace.time <= contact.stop)
    return touches


#: What some engines lack and traces show: what to call it, and where a body enters it.
SEEN: Mapping[Capability, tuple[str, Callable[[Scene, Trace], Iterator[str]]]] = {
    ROLLING_CYLINDERS: ("rolls discs as polygons, which brake", _rolls),
    SLIDING_MESHES: ("brakes convex meshes that slide", _slides),
}
