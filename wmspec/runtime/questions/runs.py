"""Executed episodes of instances, counterfactuals and nudges."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from wmspec.compile.design.design import Design, Instance
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.lint.overlap import MAX_OVERLAP
from wmspec.core.diagnostics import EngineError, WmsError
from wmspec.core.memoize import cached_on
from wmspec.core.rng import uniform
from wmspec.lang.check.ir.ir import Counterfactual
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.scene_cache import SceneCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.questions.model import Reject
from wmspec.runtime.questions.observed import MIN_MOTION, Observed
from wmspec.runtime.questions.views import View
from wmspec.sim.scene.model import Array, Body, Frame, Geom, Pose, Scene, Shot, Trace
from wmspec.sim.scene.model.bounds import bounds, box_center, own_box_center
from wmspec.sim.scene.model.transform import compose as placed
from wmspec.sim.scene.model.transform import rotate
from wmspec.sim.scene.physics.overlap import overlap
from wmspec.sim.scene.render.appearance import appearance_at, vanish_times, vanished_bodies

#: s: closer times are the same.
_MOMENT = 1e-9

_PlacedGeom = tuple[Body, Geom, Pose, Array]


@dataclass(frozen=True)
class EnginePair:
    """The executing engine, the drawing engine, and the scene cache, which engines may share."""

    traces: TraceCache
    renders: RenderCache
    scenes: SceneCache = field(default_factory=SceneCache)


@dataclass(frozen=True)
class Run:
    """An executed episode; `under` executes it with a change."""

    values: Evaluator
    scene: Scene
    trace: Trace
    under: Callable[[Counterfactual], Run]

    def movable(self) -> list[str]:
        """Return the names of movable bodies."""
        return [b.name for b in self.scene.bodies if b.motion != "static"]

    def movers(self) -> set[str]:
        """Return the names of bodies that move at any time. To vanish is no motion."""
        middles, names = self.centres(), self.movable()
        away = np.linalg.norm(middles - middles[0], axis=2)
        for name, start in vanish_times(self.scene).items():
            away[self.trace.time >= start - _MOMENT, names.index(name)] = 0.0
        return {name for name, way in zip(names, away.max(axis=0).tolist(), strict=True) if way > MIN_MOTION}

    def centres(self) -> Array:
        """Return the centres (T, n, 3) of the boxes of movable bodies (m)."""
        can = [i for i, body in enumerate(self.scene.bodies) if body.motion != "static"]
        own = np.array([own_box_center(self.scene.bodies[i]) for i in can]).reshape(-1, 3)
        return np.asarray(self.trace.position[:, can] + rotate(self.trace.orientation[:, can], own))

    def distance(self, other: Run, until: float = math.inf) -> float:
        """Return the largest distance (m) of a movable body between two executions of a scene, up to a time (s)."""
        shown = self.trace.time <= until + 0.5 / self.scene.rate
        return float(np.linalg.norm(self.centres() - other.centres(), axis=2)[shown].max(initial=0.0))

    def poses(self, names: Sequence[str], time: float) -> NDArray[np.float64]:
        """Return box centres and orientations (n, 7) of bodies at a time (s), NaN for absent ones.

        A door that rotates about its frame origin changes its centre, not its frame. Raises WmsError outside the
        episode.
        """
        if not self.values.during(time):
            label = f"{self.values.change.name}: " if self.values.change else ""
            raise WmsError(f"{label}{time:g} s is outside the episode, which lasts {self.scene.duration:g} s")
        here, index = self.trace.poses(time), {name: k for k, name in enumerate(self.trace.bodies)}
        rows, gone = np.full((len(names), 7), np.nan), vanished_bodies(self.scene, time)
        for row, name in zip(rows, names, strict=True):
            if name in index and name not in gone:
                k = index[name]
                row[:3], row[3:] = box_center(self.scene.bodies[k], here[k]), here[k].orientation
        return rows

    def observed(self, views: Sequence[View], pair: EnginePair) -> Observed:
        """Return the observations with these views."""
        return Observed(self.scene, self.trace, views, lambda camera, time: self.draw(camera, time, pair))

    def draw(self, camera: str, time: float, pair: EnginePair, *, depth: bool = False) -> Frame:
        """Return the picture of a camera at a time (s)."""
        return pair.renders.draw(appearance_at(self.scene, time), Shot(camera, self.trace.poses(time)), depth=depth)


def values_of(design: Design, instance: Instance, change: Counterfactual | None = None) -> Evaluator:
    """Return the values of an instance or of its counterfactual."""
    return Evaluator(design.spec, instance.values, change, instance.key)


def execute(design: Design, instance: Instance, change: Counterfactual | None, pair: EnginePair) -> Run:
    """Execute an instance or its counterfactual.

    Raises Reject if the scene is invalid, bodies overlap, or the engine fails.
    """
    label = f"{change.name}: " if change else ""
    try:
        values = values_of(design, instance, change)
        scene = pair.scenes.of(values)
        for a, b, depth in overlaps(scene):
            raise Reject("overlap", f"{label}{a} and {b} are {depth * 1000:.1f} mm deep in each other at the start")
        return Run(values, scene, pair.traces.trace(scene), partial(execute, design, instance, pair=pair))
    except EngineError as error:
        raise Reject("unstable", f"{label}{error.portable}") from None
    except WmsError as error:
        raise Reject("invalid", f"{label}{error.portable}") from None


# ---------------------------------------------------------------- overlaps


def overlaps(scene: Scene) -> Iterator[tuple[str, str, float]]:
    """Yield pairs of bodies, one of them movable, that overlap by more than 1 mm at the start, with the depth (m)."""
    apart = {frozenset(pair) for pair in scene.filtered}
    apart |= {frozenset((j.first, j.second)) for j in scene.joints if j.first is not None and not j.collides}
    pieces = [(body, *piece) for body in scene.bodies for piece in cached_on(body, _touched)]
    for (a, one, at, _), (b, other, there, _) in _near(pieces):
        if frozenset((a.name, b.name)) not in apart:
            depth = overlap(one.shape, at, other.shape, there, MAX_OVERLAP)
            if depth > 0:
                yield a.name, b.name, depth


def _touched(body: Body) -> tuple[tuple[Geom, Pose, Array], ...]:
    """Return the colliding geoms of a body with poses and axis-aligned boxes (2, 3)."""
    touched = [(geom, placed(body.pose, geom.pose)) for geom in body.geoms if geom.collides]
    return tuple((geom, pose, bounds(geom.shape, pose)) for geom, pose in touched)


def _near(pieces: Sequence[_PlacedGeom]) -> Iterator[tuple[_PlacedGeom, _PlacedGeom]]:
    """Yield pairs of geoms of different bodies, one movable, whose axis-aligned boxes overlap."""
    boxes = np.array([box for *_, box in pieces]).reshape(-1, 2, 3)
    every, free = np.arange(len(pieces)), np.array([body.motion != "static" for body, *_ in pieces], bool)
    moving = np.flatnonzero(free)
    for i, piece in enumerate(pieces):
        others = every if free[i] else moving
        others = others[others > i]
        shared = np.minimum(boxes[i, 1], boxes[others, 1]) - np.maximum(boxes[i, 0], boxes[others, 0])
        yield from (
            (piece, pieces[j]) for j in others[(shared > MAX_OVERLAP).all(axis=1)] if pieces[j][0] is not piece[0]
        )


# ---------------------------------------------------------------- nudges


def free_bodies(scene: Scene) -> list[str]:
    """Return the names of dynamic bodies without grip and joints."""
    held = {name for joint in scene.joints for name in (joint.first, joint.second)}
    return [b.name for b in scene.bodies if b.motion == "dynamic" and b.name not in held]


def nudged(run: Run, by: float, key: Iterable[object], pair: EnginePair) -> Run:
    """Return the episode with every free body displaced by `by` metres in a direction drawn from `key`.

    Its changed episodes begin with the same displacements.

    Raises Reject if the engine fails.
    """
    names, bodies, drawn = free_bodies(run.scene), [], tuple(key)
    for body in run.scene.bodies:
        turn = 2 * math.pi * uniform(*drawn, body.name, "nudge")
        aside = by * np.array([math.cos(turn), math.sin(turn), 0.0])
        pose = replace(body.pose, position=body.pose.position + aside)
        bodies.append(replace(body, pose=pose) if body.name in names else body)
    scene = replace(run.scene, bodies=tuple(bodies))
    try:
        trace = pair.traces.trace(scene)
    except WmsError as error:
        raise Reject("unstable", f"displaced by {by * 1000:g} mm: {error.portable}") from None
    return Run(run.values, scene, trace, lambda change: nudged(run.under(change), by, drawn, pair))
