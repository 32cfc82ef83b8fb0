"""Whether one object fits into the cavity of another, both approximated by axis-aligned boxes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.solids import Box, bounds
from wmspec.core.space import IDENTITY, Pose, Vector, inverse, multiply

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

#: Overlap (m) that still counts as contact.
_TOUCH = 1e-9
#: m: resolution of a clearance.
_RESOLUTION = 1e-5


def fits(values: Evaluator, owner: str, container: str) -> bool:
    """Whether the object's axis-aligned box fits into the container's box without overlapping its parts' boxes.

    Axes are those of the container's frame.
    """
    return has_room(*_boxes(values, owner, container))


def clearance(values: Evaluator, owner: str, container: str) -> float:
    """Return by how much (m) all edges of the object could grow and still fit; negative if they must shrink."""
    edges, whole, parts = _boxes(values, owner, container)
    shortest = min(edges)
    low, high = -shortest, max(h - b for b, h in zip(*whole, strict=True))
    while high - low > _RESOLUTION:
        middle = (low + high) / 2
        grown = (edges[0] + middle, edges[1] + middle, edges[2] + middle)
        low, high = (middle, high) if has_room(grown, whole, parts) else (low, middle)
    return low


def _boxes(values: Evaluator, owner: str, container: str) -> tuple[Vector, Box, list[Box]]:
    """Return the edges of the object's box, the container's box, and those of its parts, in the container's frame."""
    inside = pieces(values, container)
    seen = multiply(inverse(values.pose(container).orientation), values.pose(owner).orientation)
    low, high = bounds(pieces(values, owner), Pose(orientation=seen))
    edges = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
    return edges, bounds(inside, IDENTITY), [bounds((piece,), IDENTITY) for piece in inside]


def has_room(edges: Vector, whole: Box, parts: Sequence[Box]) -> bool:
    """Whether a box with these edges has a position within `whole` that overlaps none of `parts`.

    Any such position can be lowered along each axis until the box meets `whole` or a part. So only positions in contact
    are tried.
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
    """Whether a box overlaps a part by more than _TOUCH."""
    return all(low[i] < part[1][i] - _TOUCH and part[0][i] < high[i] - _TOUCH for i in range(3))
