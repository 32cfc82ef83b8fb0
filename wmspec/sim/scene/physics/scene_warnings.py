"""What a stage says and hardly means: it is executed as it says, and told."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.model import Body, Geom, Scene
from wmspec.sim.scene.model.bounds import bounds
from wmspec.sim.scene.model.transform import compose
from wmspec.sim.scene.physics.contact import colliders, touchable
from wmspec.sim.scene.physics.overlap import overlap

DEEP = 0.005
"""m: what begins further inside something else is thrown out of it, in every engine another way."""
MOST = 20
"""Pairs of pieces that are looked at, those whose boxes overlap most."""


def doubts(scene: Scene) -> tuple[Diagnostic, ...]:
    """Warnings of what begins inside other things, and of bodies that several joints hold to one another."""
    return (*_buried(scene), *_held_twice(scene))


def _buried(scene: Scene) -> Iterator[Diagnostic]:
    box = {id(g): bounds(g.shape, compose(body.pose, g.pose)) for body in scene.bodies for g in colliders(body)}
    near: list[tuple[float, Body, Geom, Body, Geom]] = []
    for a, g, b, h in touchable(scene):
        one, other = box[id(g)], box[id(h)]
        shared = float((np.minimum(one[1], other[1]) - np.maximum(one[0], other[0])).min())
        if shared > DEEP:
            near.append((shared, a, g, b, h))
    near.sort(key=lambda pair: -pair[0])
    deepest: dict[str, tuple[float, str]] = {}
    for _, a, g, b, h in near[:MOST]:
        depth = overlap(g.shape, compose(a.pose, g.pose), h.shape, compose(b.pose, h.pose), DEEP)
        inner, outer = (a, b) if a.motion == "dynamic" else (b, a)
        if depth > deepest.get(inner.path, (0.0, ""))[0]:
            deepest[inner.path] = depth, outer.path
    for path, (depth, around) in deepest.items():
        reason = f"it begins {1e3 * depth:.3g} mm inside {around}, and is thrown out of it, in every engine another way"
        yield Diagnostic(reason, PrimPlace(path), "put them apart, or filter the pair", severity="warning")


def _held_twice(scene: Scene) -> Iterator[Diagnostic]:
    held: dict[frozenset[str | None], list[str]] = defaultdict(list)
    for joint in scene.joints:
        held[frozenset((joint.first, joint.second))].append(joint.path)
    for (_, *others), first in ((dict.fromkeys(paths), paths[0]) for paths in held.values()):
        if others:
            reason = f"it holds the same two bodies as {', '.join(others)}: they can move only as all of these let them"
            help_ = "make it one joint that leaves several axes free"
            yield Diagnostic(reason, PrimPlace(first), help_, severity="warning")
