"""Warnings about scenes that are valid but probably unintended."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.model import Body, Geom, Scene
from wmspec.sim.scene.model.bounds import bounds
from wmspec.sim.scene.model.transform import compose
from wmspec.sim.scene.physics.contact import colliders, colliding_geoms
from wmspec.sim.scene.physics.overlap import overlap

MAX_INITIAL_OVERLAP = 0.005
"""m: bodies that overlap more at the start are ejected, differently in every engine."""
MAX_CHECKED_PAIRS = 20
"""Number of geom pairs that are checked, by decreasing overlap of their boxes."""


def scene_warnings(scene: Scene) -> tuple[Diagnostic, ...]:
    """Return warnings of initial overlaps and of redundant joints."""
    return (*_initial_overlaps(scene), *_redundant_joints(scene))


def _initial_overlaps(scene: Scene) -> Iterator[Diagnostic]:
    box = {id(g): bounds(g.shape, compose(body.pose, g.pose)) for body in scene.bodies for g in colliders(body)}
    near: list[tuple[float, Body, Geom, Body, Geom]] = []
    for a, g, b, h in colliding_geoms(scene):
        one, other = box[id(g)], box[id(h)]
        shared = float((np.minimum(one[1], other[1]) - np.maximum(one[0], other[0])).min())
        if shared > MAX_INITIAL_OVERLAP:
            near.append((shared, a, g, b, h))
    near.sort(key=lambda pair: -pair[0])
    deepest: dict[str, tuple[float, str]] = {}
    for _, a, g, b, h in near[:MAX_CHECKED_PAIRS]:
        depth = overlap(g.shape, compose(a.pose, g.pose), h.shape, compose(b.pose, h.pose), MAX_INITIAL_OVERLAP)
        inner, outer = (a, b) if a.motion == "dynamic" else (b, a)
        if depth > deepest.get(inner.path, (0.0, ""))[0]:
            deepest[inner.path] = depth, outer.path
    for path, (depth, around) in deepest.items():
        reason = f"it starts {1e3 * depth:.3g} mm inside {around}; engines eject it in different ways"
        yield Diagnostic(reason, PrimPlace(path), "move them apart or filter the pair", severity="warning")


def _redundant_joints(scene: Scene) -> Iterator[Diagnostic]:
    held: dict[frozenset[str | None], list[str]] = defaultdict(list)
    for joint in scene.joints:
        held[frozenset((joint.first, joint.second))].append(joint.path)
    for (_, *others), first in ((dict.fromkeys(paths), paths[0]) for paths in held.values()):
        if others:
            reason = f"it joins the same two bodies as {', '.join(others)}: all of these constrain them together"
            help_ = "use one joint with several free axes"
            yield Diagnostic(reason, PrimPlace(first), help_, severity="warning")
