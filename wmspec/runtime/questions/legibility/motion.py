"""Measures of motion in the shown pictures: steps, path, how far two movers get apart, and where one aims."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wmspec.runtime.questions.legibility.bounds import entry
from wmspec.runtime.questions.legibility.picture_places import center, width_along
from wmspec.runtime.questions.model import Legibility
from wmspec.runtime.questions.observed import MIN_MOTION, Observed
from wmspec.sim.scene.model import Array, Frame
from wmspec.sim.scene.render.appearance import vanish_times

#: s: closer times are the same.
_MOMENT = 1e-9


@dataclass(frozen=True)
class DrawnPath:
    """The path of a body in the pictures of one camera: the longest step (px) between two pictures that show it, the
    same in widths of the body, and the distance (px) travelled up to each of the camera's times (n,).
    """

    step: float
    step_in_widths: float
    travelled: Array

    @property
    def length(self) -> float:
        """The whole path (px)."""
        return float(self.travelled[-1])


def camera_times(observed: Observed) -> dict[str, tuple[float, ...]]:
    """Return the cameras with at least two shown pictures, and their times (s) in order."""
    times: dict[str, set[float]] = {}
    for camera, time in observed.views:
        times.setdefault(camera, set()).add(time)
    return {camera: tuple(sorted(own)) for camera, own in times.items() if len(own) > 1}


def drawn_path(observed: Observed, name: str, camera: str, times: tuple[float, ...]) -> DrawnPath:
    """Return the path of a body in the pictures of a camera. Pictures that do not show it are skipped."""
    index = observed.index(name)
    step, in_widths, travelled = 0.0, 0.0, list[float]()
    last: tuple[Frame, Array] | None = None
    for frame in (observed.picture(camera, time) for time in times):
        length, here = 0.0, center(frame, index)
        if last is not None and here is not None:
            way = here - last[1]
            length = float(np.linalg.norm(way))
            if length > 0:
                step = max(step, length)
                in_widths = max(in_widths, length / width_along(last[0], index, way))
        if here is not None:
            last = frame, here
        travelled.append(length + (travelled[-1] if travelled else 0.0))
    return DrawnPath(step, in_widths, np.array(travelled))


def moves(observed: Observed, name: str) -> bool:
    """Whether a body moves by more than 2 mm between the first and the last shown picture. To vanish is no motion."""
    path = observed.path(name)
    gone = vanish_times(observed.scene).get(name, np.inf)
    path = path[observed.times < gone - _MOMENT]
    if not len(path):
        return False
    return bool((np.linalg.norm(path - path[0], axis=1) > MIN_MOTION).any())


def is_drawn_moving(observed: Observed, name: str) -> bool:
    """Whether two successive pictures of one camera show a body."""
    index = observed.index(name)
    return any(
        all(center(observed.picture(camera, time), index) is not None for time in each)
        for camera, times in camera_times(observed).items()
        for each in pairwise(times)
    )


def motion_measures(observed: Observed, movers: Iterable[str]) -> Iterator[Legibility]:
    """Yield step and path of the least legible of these bodies, each in the camera that shows it best."""
    times = camera_times(observed)
    paths = {name: [drawn_path(observed, name, *each) for each in times.items()] for name in movers}
    if not times or not paths:
        return
    yield entry("step", *min((max(path.step for path in own), name) for name, own in paths.items()))
    yield entry("step_in_widths", *min((max(path.step_in_widths for path in own), name) for name, own in paths.items()))
    yield entry("path", *min((max(path.length for path in own), name) for name, own in paths.items()))


def lead(observed: Observed, one: str, other: str) -> float:
    """Return how far (px) one body gets ahead of another, each from where it started, in the best picture."""
    gaps = [0.0]
    for camera, times in camera_times(observed).items():
        ours, theirs = (drawn_path(observed, name, camera, times).travelled for name in (one, other))
        gaps.append(float(np.abs(ours - theirs).max()))
    return max(gaps)


def aim_gap(observed: Observed, name: str, targets: Sequence[str]) -> float:
    """Return how much nearer (px) the drawn course of a body passes to one target than to the next, in the best camera.

    The course is the straight line through its first and last drawn place. Angles are compared, at the distance of the
    target.
    """
    gaps = [0.0]
    for camera, times in camera_times(observed).items():
        frames = [observed.picture(camera, time) for time in times]
        course = [at for frame in frames if (at := center(frame, observed.index(name))) is not None]
        aims = [at for target in targets if (at := center(frames[0], observed.index(target))) is not None]
        if len(course) > 1 and len(aims) > 1 and (course[-1] != course[0]).any():
            gaps.append(_gap(course[0], course[-1], aims))
    return max(gaps)


def _gap(start: Array, stop: Array, aims: Sequence[Array]) -> float:
    way = stop - start
    misses = sorted((_angle(way, aim - start), float(np.linalg.norm(aim - start))) for aim in aims)
    (best, far), (second, _) = misses[:2]
    return 2 * far * float(np.sin(min(second - best, np.pi) / 2))


def _angle(a: Array, b: Array) -> float:
    return abs(float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b)))
