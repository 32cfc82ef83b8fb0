"""Executed episodes: of an instance, of what it would be if one thing were different, of the same with a nudge."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from wmspec.compile.design.design import Design, Instance
from wmspec.compile.layout.values import Values
from wmspec.core.diagnostics import EngineError, WmsError
from wmspec.core.memoize import cached_on
from wmspec.core.rng import uniform
from wmspec.lang.check.ir.ir import Counterfactual
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.scene_cache import SceneCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.questions.model import Reject
from wmspec.runtime.questions.observed import MOVED, Observed
from wmspec.runtime.questions.views import View
from wmspec.sim.scene.model import Array, Body, Frame, Geom, Pose, Scene, Shot, Trace
from wmspec.sim.scene.model.bounds import bounds, middle, own_middle
from wmspec.sim.scene.model.transform import compose as placed
from wmspec.sim.scene.model.transform import rotate
from wmspec.sim.scene.physics.overlap import overlap
from wmspec.sim.scene.render.appearance import shown_at, vanished

#: Bodies that lie deeper (m) in one another at the start would be thrown apart, by each engine in its own way.
DEEP = 0.001

_Touched = tuple[Body, Geom, Pose, Array]


@dataclass(frozen=True)
class EnginePair:
    """Who executes, who draws, and who reads the scenes, which may be the same for all engines."""

    traces: TraceCache
    renders: RenderCache
    scenes: SceneCache = field(default_factory=SceneCache)


@dataclass(frozen=True)
class Run:
    """An executed episode."""

    values: Values
    scene: Scene
    trace: Trace

    def movable(self) -> list[str]:
        """The names of the bodies that can move."""
        return [b.name for b in self.scene.bodies if b.motion != "static"]

    def movers(self) -> set[str]:
        """The names of the bodies that do move, at any time."""
        can = [i for i, body in enumerate(self.scene.bodies) if body.motion != "static"]
        own = np.array([own_middle(self.scene.bodies[i]) for i in can]).reshape(-1, 3)
        middles = self.trace.position[:, can] + rotate(self.trace.orientation[:, can], own)
        away = np.linalg.norm(middles - middles[0], axis=2).max(axis=0)
        return {self.scene.bodies[i].name for i, way in zip(can, away.tolist(), strict=True) if way > MOVED}

    def poses(self, names: Sequence[str], time: float) -> NDArray[np.float64]:
        """Where the middles of bodies are, and how they are turned (n, 7) at a time (s), NaN for one that is not there.

        A door that turns about the origin of its frame is elsewhere, though its frame is not. Raises WmsError if the
        time is outside the episode.
        """
        if not self.values.during(time):
            label = f"{self.values.change.name}: " if self.values.change else ""
            raise WmsError(f"{label}{time:g} s is outside the episode, which lasts {self.scene.duration:g} s")
        here, index = self.trace.poses(time), {name: k for k, name in enumerate(self.trace.bodies)}
        rows, gone = np.full((len(names), 7), np.nan), vanished(self.scene, time)
        for row, name in zip(rows, names, strict=True):
            if name in index and name not in gone:
                k = index[name]
                row[:3], row[3:] = middle(self.scene.bodies[k], here[k]), here[k].orientation
        return rows

    def observed(self, views: Sequence[View], pair: EnginePair) -> Observed:
        """What there is to measure, with views of it."""
        return Observed(self.scene, self.trace, views, lambda camera, time: self.draw(camera, time, pair))

    def draw(self, camera: str, time: float, pair: EnginePair, *, depth: bool = False) -> Frame:
        """What a camera sees at a time (s)."""
        return pair.renders.draw(shown_at(self.scene, time), Shot(camera, self.trace.poses(time)), depth=depth)


def values_of(design: Design, instance: Instance, change: Counterfactual | None = None) -> Values:
    """The values of an instance, or of what it would be under a counterfactual."""
    return Values(design.spec, instance.values, change, instance.key)


def execute(design: Design, instance: Instance, change: Counterfactual | None, pair: EnginePair) -> Run:
    """An instance, or what it would be under a counterfactual.

    Raises Reject if there is no such scene, if bodies overlap in it, or if the engine gives up on it.
    """
    label = f"{change.name}: " if change else ""
    try:
        values = values_of(design, instance, change)
        scene = pair.scenes.of(values)
        for a, b, depth in overlaps(scene):
            raise Reject("overlap", f"{label}{a} and {b} are {depth * 1000:.1f} mm deep in one another at the start")
        return Run(values, scene, pair.traces.trace(scene))
    except EngineError as error:
        raise Reject("unstable", f"{label}{error}") from None
    except WmsError as error:
        raise Reject("invalid", f"{label}{error}") from None


# ---------------------------------------------------------------- overlaps


def overlaps(scene: Scene) -> Iterator[tuple[str, str, float]]:
    """The bodies, one of them able to move, that lie more than 1 mm (m) deep in one another at the start."""
    apart = {frozenset(pair) for pair in scene.filtered}
    apart |= {frozenset((j.first, j.second)) for j in scene.joints if j.first is not None and not j.collides}
    pieces = [(body, *piece) for body in scene.bodies for piece in cached_on(body, _touched)]
    for (a, one, at, _), (b, other, there, _) in _near(pieces):
        if frozenset((a.name, b.name)) not in apart:
            depth = overlap(one.shape, at, other.shape, there, DEEP)
            if depth > 0:
                yield a.name, b.name, depth


def _touched(body: Body) -> tuple[tuple[Geom, Pose, Array], ...]:
    """What of a body can be touched: where that is, and the upright box around it (2, 3)."""
    touched = [(geom, placed(body.pose, geom.pose)) for geom in body.geoms if geom.collides]
    return tuple((geom, pose, bounds(geom.shape, pose)) for geom, pose in touched)


def _near(pieces: Sequence[_Touched]) -> Iterator[tuple[_Touched, _Touched]]:
    """Pairs of pieces of different bodies, one of which can move, whose upright boxes overlap."""
    boxes = np.array([box for *_, box in pieces]).reshape(-1, 2, 3)
    every, free = np.arange(len(pieces)), np.array([body.motion != "static" for body, *_ in pieces], bool)
    moving = np.flatnonzero(free)
    for i, piece in enumerate(pieces):
        others = every if free[i] else moving
        others = others[others > i]
        shared = np.minimum(boxes[i, 1], boxes[others, 1]) - np.maximum(boxes[i, 0], boxes[others, 0])
        yield from ((piece, pieces[j]) for j in others[(shared > DEEP).all(axis=1)] if pieces[j][0] is not piece[0])


# ---------------------------------------------------------------- nudges


def free(scene: Scene) -> list[str]:
    """The names of the bodies that nothing carries and no joint holds."""
    held = {name for joint in scene.joints for name in (joint.first, joint.second)}
    return [b.name for b in scene.bodies if b.motion == "dynamic" and b.name not in held]


def nudged(run: Run, by: float, key: Iterable[object], pair: EnginePair) -> Run:
    """The same episode with every free body set aside by so much (m), in a direction that depends on `key`.

    Raises Reject if the engine gives up on it.
    """
    names, bodies = free(run.scene), []
    for body in run.scene.bodies:
        turn = 2 * math.pi * uniform(*key, body.name, "nudge")
        aside = by * np.array([math.cos(turn), math.sin(turn), 0.0])
        pose = replace(body.pose, position=body.pose.position + aside)
        bodies.append(replace(body, pose=pose) if body.name in names else body)
    scene = replace(run.scene, bodies=tuple(bodies))
    try:
        return Run(run.values, scene, pair.traces.trace(scene))
    except WmsError as error:
        raise Reject("unstable", f"set aside by {by * 1000:g} mm: {error}") from None
