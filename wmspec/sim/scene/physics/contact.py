"""Contacts, equal for all engines: which pairs collide, their combined friction, and intervals of contact."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterable, Iterator, Sequence
from math import sqrt
from operator import itemgetter

from wmspec.sim.scene.model import Body, Contact, Friction, Geom, Scene

Pair = tuple[int, int]


def combine_friction(a: Friction, b: Friction) -> Friction:
    """Return the friction of a pair: the geometric mean, the only rule that every engine supports."""
    return Friction(sqrt(a.static * b.static), sqrt(a.dynamic * b.dynamic), sqrt(a.restitution * b.restitution))


def can_collide(a: Body, b: Body) -> bool:
    """Whether two bodies can push each other: at least one is dynamic."""
    return a is not b and "dynamic" in (a.motion, b.motion)


def colliders(body: Body) -> tuple[Geom, ...]:
    """Return the colliding geoms of a body."""
    return tuple(geom for geom in body.geoms if geom.collides)


def colliding_geoms(scene: Scene) -> Iterator[tuple[Body, Geom, Body, Geom]]:
    """Yield every pair of geoms that can collide, in scene order, without trying those of two static bodies."""
    never = non_colliding_pairs(scene)
    solid = [(i, body) for i, body in enumerate(scene.bodies) if colliders(body)]
    dynamic = [(i, body) for i, body in solid if body.motion == "dynamic"]
    for place, (i, a) in enumerate(solid):
        others = solid[place + 1 :] if a.motion == "dynamic" else dynamic[bisect(dynamic, i, key=itemgetter(0)) :]
        for j, b in others:
            if (i, j) not in never:
                yield from ((a, g, b, h) for g in colliders(a) for h in colliders(b))


def non_colliding_pairs(scene: Scene) -> frozenset[Pair]:
    """Return the pairs of bodies, lower number first, that do not collide: filtered, or jointed without collision."""
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    joined = [(j.first, j.second) for j in scene.joints if j.first is not None and not j.collides]
    pairs = [(index[a], index[b]) for a, b in (*scene.filtered, *joined) if a is not None]
    return frozenset((min(pair), max(pair)) for pair in pairs)


def intervals(touching: Sequence[Iterable[Pair]], names: Sequence[str], step: float, gap: float) -> tuple[Contact, ...]:
    """Return contacts by start time, from the pairs that touched during each step of `step` seconds.

    Gaps up to `gap` (s) are closed, because resting contacts flicker in every engine.
    """
    first: dict[Pair, int] = {}
    last: dict[Pair, int] = {}
    ended: list[tuple[int, Pair, int]] = []
    for start, stop in _same(touching):
        for pair in touching[start]:
            if pair in last and (start - last[pair] - 1) * step > gap:
                ended.append((first.pop(pair), pair, last[pair]))
            first.setdefault(pair, start)
            last[pair] = stop - 1
    ended += [(start, pair, last[pair]) for pair, start in first.items()]
    return tuple(Contact(names[a], names[b], start * step, (stop + 1) * step) for start, (a, b), stop in sorted(ended))


def _same(touching: Sequence[Iterable[Pair]]) -> Iterator[tuple[int, int]]:
    """Yield first and end of runs of steps with identical pairs."""
    start = 0
    for i, pairs in enumerate(touching):
        if pairs is not touching[start]:
            yield start, i
            start = i
    if touching:
        yield start, len(touching)
