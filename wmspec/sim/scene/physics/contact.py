"""What touching means, once for all engines: which pairs may touch, with which material, and for how long they did."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from math import sqrt

from wmspec.sim.scene.model import Body, Contact, Friction, Geom, Scene

Pair = tuple[int, int]


def mix(a: Friction, b: Friction) -> Friction:
    """The material of a touching pair: the geometric mean of both sides, the one rule that every engine can realise."""
    return Friction(sqrt(a.static * b.static), sqrt(a.dynamic * b.dynamic), sqrt(a.restitution * b.restitution))


def may_touch(a: Body, b: Body) -> bool:
    """Bodies whose motion is given beforehand never push each other."""
    return a is not b and "dynamic" in (a.motion, b.motion)


def colliders(body: Body) -> tuple[Geom, ...]:
    """The body's pieces that can be touched."""
    return tuple(geom for geom in body.geoms if geom.collides)


def touchable(scene: Scene) -> Iterator[tuple[Body, Geom, Body, Geom]]:
    """Every pair of pieces that may touch, in scene order."""
    never = apart(scene)
    for (i, a), (j, b) in combinations(enumerate(scene.bodies), 2):
        if may_touch(a, b) and (i, j) not in never:
            yield from ((a, g, b, h) for g in colliders(a) for h in colliders(b))


def apart(scene: Scene) -> frozenset[Pair]:
    """The pairs of bodies, lower number first, that pass through each other: filtered, or jointed and not colliding."""
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    joined = [(j.first, j.second) for j in scene.joints if j.first is not None and not j.collides]
    pairs = [(index[a], index[b]) for a, b in (*scene.filtered, *joined) if a is not None]
    return frozenset((min(pair), max(pair)) for pair in pairs)


def intervals(touching: Sequence[Iterable[Pair]], names: Sequence[str], step: float, gap: float) -> tuple[Contact, ...]:
    """Contacts in order of their start, from the pairs that touched during each step of `step` seconds.

    A pair that parts for no longer than `gap` (s) has not parted: a resting contact flickers in every engine.
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
    """The stretches of steps, as first and end, that have the very same pairs: engines say the same for long."""
    start = 0
    for i, pairs in enumerate(touching):
        if pairs is not touching[start]:
            yield start, i
            start = i
    if touching:
        yield start, len(touching)
