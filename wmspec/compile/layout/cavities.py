"""Whether one object fits into the hollow of another, as boxes that are not turned."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import Box, bounds
from wmspec.core.space import HERE, Pose, Vector, inverse, multiply

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

#: What touches does not overlap, m.
_TOUCH = 1e-9


def fits(values: Values, owner: str, container: str) -> bool:
    """Whether the object's upright box has a place within the container's upright box that meets none of its parts'.

    Upright is meant in the container's frame.
    """
    inside = pieces(values, container)
    seen = multiply(inverse(values.pose(container).orientation), values.pose(owner).orientation)
    low, high = bounds(pieces(values, owner), Pose(orientation=seen))
    edges = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
    return room(edges, bounds(inside, HERE), [bounds((piece,), HERE) for piece in inside])


def room(edges: Vector, whole: Box, parts: Sequence[Box]) -> bool:
    """Whether a box of these edges has a place within `whole` that overlaps none of `parts`.

    If it has one, it can be pushed from there to lower coordinates until, along each axis, it meets `whole` or a part.
    So only such places need to be looked at.
    """
    low, high = whole
    corners = [sorted({low[i], *(part[1][i] for part in parts)}) for i in range(3)]
    for corner in product(*corners):
        far = tuple(c + e for c, e in zip(corner, edges, strict=True))
        within = all(f <= h + _TOUCH for f, h in zip(far, high, strict=True))
        if within and not any(_overlap(corner, far, part) for part in parts):
            return True
    return False


def _overlap(low: Sequence[float], high: Sequence[float], part: Box) -> bool:
    return all(low[i] < part[1][i] - _TOUCH and part[0][i] < high[i] - _TOUCH for i in range(3))
