"""Where a mover aims, as drawn: how clearly its course points at one of several targets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wmspec.runtime.questions.legibility.motion import camera_times
from wmspec.runtime.questions.legibility.picture_places import center
from wmspec.runtime.questions.observed import Observed
from wmspec.sim.scene.model import Array


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
