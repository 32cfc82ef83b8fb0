"""Explains divergence: the first body that diverges, its previous contact, and the decisive properties."""

from __future__ import annotations

from collections.abc import Sequence

from wmspec.runtime.compare.allow import impacts
from wmspec.runtime.compare.model import Cause, Event, Gap, Rest
from wmspec.sim.scene.model import Body, Contact, Friction, Scene, Trace
from wmspec.sim.scene.physics.contact import colliders, combine_friction

#: Friction below which ball collisions agree; at 0.5 the final distance is three times larger.
MAX_SMOOTH_FRICTION = 0.1

_ALONE = "it had touched nothing: the engines differ in free motion"


def cause(
    run: str,
    scene: Scene,
    traces: tuple[Trace, Trace],
    differences: tuple[Sequence[Gap], Sequence[Event], Sequence[Rest]],
    apart: float,
) -> Cause | None:
    """Return the first divergence, or None; a pair separate for more than `apart` (s) makes a new contact."""
    parted = _divergences(scene, *differences, float(traces[0].time[-1]))
    if not parted:
        return None
    began, name = min(parted)
    body = _body(scene, name)
    contact = _previous_contact(name, began, traces, apart)
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


def _divergences(
    scene: Scene, gaps: Sequence[Gap], events: Sequence[Event], rests: Sequence[Rest], end: float
) -> list[tuple[float, str]]:
    """Return the times (s) at which bodies diverge, with their names."""
    parted = [(g.began, g.body) for g in gaps if g.began is not None]
    parted += [(min(t for t in e.times if t is not None), _movable(scene, e)) for e in events if not e.within]
    return parted + [(end, r.body) for r in rests]


def _body(scene: Scene, name: str) -> Body:
    return next(b for b in scene.bodies if b.name == name)


def _movable(scene: Scene, event: Event) -> str:
    return event.first if _body(scene, event.first).motion == "dynamic" else event.second


def _previous_contact(name: str, time: float, traces: tuple[Trace, Trace], apart: float) -> Contact | None:
    """Return the latest impact of a body until `time` (s) in either engine, or else its support."""
    met = [c for t in traces for c in impacts(t, apart) if name in (c.first, c.second) and c.start <= time]
    lay = [c for t in traces for c in t.contacts if name in (c.first, c.second) and c.start <= time]
    return max(met or lay, key=lambda c: c.start, default=None)


def _material(a: Body, b: Body) -> Friction:
    """Return the friction of a pair, from the first touchable piece of each."""
    return combine_friction(colliders(a)[0].friction, colliders(b)[0].friction)


def _is_round(body: Body) -> bool:
    return all(g.shape.symmetry == "ball" for g in colliders(body))


def _has_edges(body: Body) -> bool:
    return any(g.shape.rim for g in colliders(body))


def _hint(body: Body, other: Body, material: Friction, impacts: int) -> str:
    """Return a remedy for the most likely cause that no engine setting removes."""
    balls = _is_round(body) and _is_round(other)
    if material.restitution >= 0.3 and not balls:
        return (
            "bounces on edges are chaotic, even within one engine: lower the restitution, or ask about an earlier time"
        )
    if _has_edges(body) or _has_edges(other):
        return "cylinders and cones touch at a rim, which engines resolve differently: use a box, a sphere or a capsule"
    if impacts > 3:
        return "small differences grow with every impact: look earlier, or let fewer bodies meet"
    if not balls:
        return (
            "where a face or an edge is hit decides how a body turns: hit it nearer to its middle, let one be a "
            "ball, or look earlier"
        )
    if material.dynamic > MAX_SMOOTH_FRICTION:
        remedy = f"lower the friction of both to {MAX_SMOOTH_FRICTION:g}, or look earlier"
        return f"balls that rub climb on each other: {remedy}"
    return "the engines differ in how this pair bounces and rubs: look earlier, or ask for less precision"
