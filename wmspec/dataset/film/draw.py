"""Draws the film of one execution, and locates its objects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wmspec.dataset.film import codec
from wmspec.dataset.film.distances import Array, nearest_pixels, object_points, working_size
from wmspec.dataset.film.timing import FilmTimes
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.questions.runs import EnginePair, Run


@dataclass(frozen=True)
class DrawnFilm:
    """A film: encoded frames and ids, and what its objects do.

    `objects` are the spec's objects that can move. `points` (n, T, 3, 2) px and `areas` (n, T) px locate them in the
    working size, `centers` (n, A, 3) m in the world, up to the frame of the answer; NaN while absent. `bodies` are the
    names of all bodies.
    """

    content: bytes
    ids: bytes
    times: FilmTimes
    objects: tuple[str, ...]
    points: Array
    areas: Array
    centers: Array
    bodies: tuple[str, ...]


def draw_film(run: Run, camera: str, times: FilmTimes, rate: int, pair: EnginePair, renders: RenderCache) -> DrawnFilm:
    """Draw every frame of an execution. Raises GraphicsError if the engine cannot draw."""
    pair = replace(pair, renders=renders)
    frames = [run.draw(camera, time, pair) for time in times.times]
    rgb, ids = np.stack([frame.rgb for frame in frames]), np.stack([frame.ids for frame in frames])
    bodies = tuple(body.name for body in run.scene.bodies)
    things = {thing.name for thing in run.values.spec.things if thing.kind == "object"}
    objects = tuple(name for name in run.movable() if name in things)
    small = nearest_pixels(ids, working_size(*renders.size))
    points, areas = object_points(small, [bodies.index(name) for name in objects])
    shown = times.times[: times.answer_frame + 1]
    centers = np.stack([run.poses(objects, time)[:, :3] for time in shown], axis=1)
    return DrawnFilm(
        codec.encode(rgb, rate), codec.encode_ids(ids, rate), times, objects, points, areas, centers, bodies
    )
