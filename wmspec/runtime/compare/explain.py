"""Why two engines part: the body that parts first, what it touched before that, and what decides such a touch."""

from __future__ import annotations

from collections.abc import Sequence

from wmspec.runtime.compare.allow import impacts
from wmspec.runtime.compare.model import Cause, Event, Gap, Rest
from wmspec.sim.scene.model import Body, Contact, Friction, Scene, Trace
from wmspec.sim.scene.physics.contact import colliders, mix

#: With a friction of 0.5 two rolling balls that meet end three times as far apart as with this.
SMOOTH = 0.1

_ALONE = "it had touched nothing: the engines differ in free motion"


def cause(
    run: str,
    scene: Scene,
    traces: tuple[Trace, Trace],
    differences: tuple[Sequence[Gap], Sequence[Event], Sequence[Rest]],
    apart: float,
) -> Cause | None:
    """Where the engines part first, or None if they do not; a pair `apart` (s) for longer touches anew."""
    parted = _parted(scene, *differences, float(traces[0].time[-1]))
    if not parted:
        return None
    began, name = min(parted)
    body = _body(scene, name)
    contact = _before(name, began, traces, apart)
    if contact is None:
        return Cause(run, name, began, None, None, None, None, None, _ALONE)
    other = _body(scene, contact.second if contact.first == name else contact.first)
    material = _material(body, other)
    count = max(sum(c.start <= began for c in impacts(t, apart)) for t in traces)
    return Cause(
        run=run,
        body=name,
        began=began,
        other=other.name,
        touched=contact.start,
        mass=(body.mass, other.mass),
        friction=material.dynamic,
        restitution=material.restitution,
        hint=_hint(body, other, material, count),
    )


def _parted(
    scene: Scene, gaps: Sequence[Gap], events: Sequence[Event], rests: Sequence[Rest], end: float
) -> list[tuple[float, str]]:
    """When (s) and which bodies part."""
    parted = [(g.began, g.body) for g in gaps if g.began is not None]
    parted += [(min(t for t in e.times if t is not None), _movable(scene, e)) for e in events if not e.within]
    return parted + [(end, r.body) for r in rests]


def _body(scene: Scene, name: str) -> Body:
    return next(b for b in scene.bodies if b.name == name)


def _movable(scene: Scene, event: Event) -> str:
    return event.first if _body(scene, event.first).motion == "dynamic" else event.second


def _before(name: str, time: float, traces: tuple[Trace, Trace], apart: float) -> Contact | None:
    """The latest impact of a body until `time` (s) in either engine, or else what it lay on."""
    met = [c for t in traces for c in impacts(t, apart) if name in (c.first, c.second) and c.start <= time]
    lay = [c for t in traces for c in t.contacts if name in (c.first, c.second) and c.start <= time]
    return max(met or lay, key=lambda c: c.start, default=None)


def _material(a: Body, b: Body) -> Friction:
    """The material of the pair, of the first piece of each that can be touched."""
    return mix(colliders(a)[0].friction, colliders(b)[0].friction)


def _round(body: Body) -> bool:
    return all(g.shape.symmetry == "ball" for g in colliders(body))


def _edged(body: Body) -> bool:
    return any(g.shape.rim for g in colliders(body))


def _hint(body: Body, other: Body, material: Friction, impacts: int) -> str:
    """What to do about it: the likeliest first of what no setting of the engines removes."""
    balls = _round(body) and _round(other)
    if material.restitution >= 0.3 and not balls:
        return (
            "what bounces on an edge is chaotic, in any one engine too: lower the restitution, or look before it lands"
        )
    if _edged(body) or _edged(other):
        return "cylinders and cones touch at a rim, which engines resolve differently: use a box, a sphere or a capsule"
    if impacts > 3:
        return "small differences grow with every impact: look earlier, or let fewer bodies meet"
    if not balls:
        return (
            "where a face or an edge is hit decides how a body turns: hit it nearer to its middle, let one be a "
            "ball, or look earlier"
        )
    if material.dynamic > SMOOTH:
        return f"balls that rub climb on each other: lower the friction of both to {SMOOTH:g}, or look earlier"
    return "the engines differ in how this pair bounces and rubs: look earlier, or ask for less precision"
