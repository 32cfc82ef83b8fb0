"""Whether what moves as it is told comes near what sleeps: until then MuJoCo need not be asked.

The native scripts contain these definitions as they stand here.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wmspec.sim.scene.model.transform import multiply, rotate

CLEAR = 0.001  # m: what is so far beyond where MuJoCo looks for contacts has none


def beside(model: Any, data: Any, paths: Mapping[int, Any], first: int) -> Any:
    """Whether in each step (T,) what is told, by MuJoCo's numbers of bodies (T, 7), is clear of all others as they are.

    Of each pair of pieces that may touch, a ball around the one that is told is held against the box around the other;
    where that is too near, the box around it. Steps before the `first` are not looked at.
    """
    clear = np.ones(len(next(iter(paths.values()))), bool)
    for pair, both in enumerate(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)):
        reach = model.pair_margin[pair] + model.pair_gap[pair] + CLEAR
        for told, other in (both, both[::-1]):
            path = paths.get(int(model.geom_bodyid[told]))
            if path is not None:
                off = np.abs((path[first:, :3] - data.geom_xpos[other]) @ data.geom_xmat[other].reshape(3, 3))
                beyond = np.maximum(off - np.abs(model.geom_aabb[other]).reshape(2, 3).sum(axis=0), 0)
                ball = np.linalg.norm(model.geom_pos[told]) + model.geom_rbound[told] + reach
                near = first + np.flatnonzero((beyond**2).sum(axis=1) <= ball**2)
                clear[near] &= between(model, data, told, other, path[near]) > reach
    return clear


def between(model: Any, data: Any, told: int, other: int, path: Any) -> Any:
    """How far (T,) two pieces' boxes are apart at least, m: along the best of the axes of both; below 0 if not at all.

    `path` (T, 7) is that of the body of what is told.
    """
    (middle, half), (there, around) = model.geom_aabb[[told, other]].reshape(2, 2, 3)
    axes, turn = data.geom_xmat[other].reshape(3, 3), multiply(path[:, 3:], model.geom_quat[told])
    here = path[:, :3] + rotate(path[:, 3:], model.geom_pos[told]) + rotate(turn, middle)
    off = (here - data.geom_xpos[other]) @ axes - there
    tilt = rotate(turn[:, None], np.eye(3)) @ axes  # of each axis of what is told, along each of the other's
    along = np.abs(off) - around - half @ np.abs(tilt)
    across = np.abs(tilt @ off[:, :, None])[:, :, 0] - half - np.abs(tilt) @ around
    return np.maximum(along, across).max(axis=1)
