"""Conservative clearance between kinematic and sleeping bodies; while clear, stepping is skipped.

Native scripts contain a copy of these definitions.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wmspec.sim.scene.model.transform import multiply, rotate

CLEARANCE = 0.001  # m: margin beyond the distance at which MuJoCo detects contacts


def is_clear(model: Any, data: Any, paths: Mapping[int, Any], first: int) -> Any:
    """Return whether kinematic bodies, by MuJoCo's body ids with poses (T, 7), are clear of all others in each step
    (T,).

    For each pair that can collide, the bounding sphere of the kinematic geom is compared with the box of the other; if
    that is too close, both boxes are compared. Steps before `first` are skipped.
    """
    clear = np.ones(len(next(iter(paths.values()))), bool)
    for pair, both in enumerate(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)):
        reach = model.pair_margin[pair] + model.pair_gap[pair] + CLEARANCE
        for led, other in (both, both[::-1]):
            path = paths.get(int(model.geom_bodyid[led]))
            if path is not None:
                off = np.abs((path[first:, :3] - data.geom_xpos[other]) @ data.geom_xmat[other].reshape(3, 3))
                beyond = np.maximum(off - np.abs(model.geom_aabb[other]).reshape(2, 3).sum(axis=0), 0)
                ball = np.linalg.norm(model.geom_pos[led]) + model.geom_rbound[led] + reach
                near = first + np.flatnonzero((beyond**2).sum(axis=1) <= ball**2)
                clear[near] &= box_distance(model, data, led, other, path[near]) > reach
    return clear


def box_distance(model: Any, data: Any, led: int, other: int, path: Any) -> Any:
    """Return a lower bound (T,), m, of the distance of two boxes along the axes of both; negative if none separates
    them.

    `path` (T, 7) holds the poses of the body of geom `led`.
    """
    (middle, half), (there, around) = model.geom_aabb[[led, other]].reshape(2, 2, 3)
    axes, turn = data.geom_xmat[other].reshape(3, 3), multiply(path[:, 3:], model.geom_quat[led])
    here = path[:, :3] + rotate(path[:, 3:], model.geom_pos[led]) + rotate(turn, middle)
    off = (here - data.geom_xpos[other]) @ axes - there
    tilt = rotate(turn[:, None], np.eye(3)) @ axes  # components of each axis of one box along those of the other
    along = np.abs(off) - around - half @ np.abs(tilt)
    across = np.abs(tilt @ off[:, :, None])[:, :, 0] - half - np.abs(tilt) @ around
    return np.maximum(along, across).max(axis=1)
