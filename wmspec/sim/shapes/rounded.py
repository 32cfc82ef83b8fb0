"""Boxes with rounded edges and corners."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any, ClassVar

from wmspec.core.space import Vector
from wmspec.sim.shapes.shape import Parameter, Shape, Tensor, UnfitError, width_and_height

if TYPE_CHECKING:
    from wmspec.sim.shapes.facets import Facets
    from wmspec.sim.shapes.shape import Array

_BENDS = 4  # edges of a drawn quarter circle


@dataclass(frozen=True)
class RoundedBox(Shape):
    """All points within `round` of an inner box; half edges `half` (3,) m in total."""

    half: Vector
    round: float

    lengths = frozenset({1, 3})
    properties: ClassVar[Mapping[str, Parameter]] = {
        "round": Parameter("length", "of a rounded box: the radius of its edges", above=0)
    }

    @classmethod
    def from_words(cls, words: Mapping[str, Any]) -> Shape:
        """`size` is that of the bounding box."""
        x, y, z = box_edges(words)
        radius = words.get("round", min(x, y, z) / 10)
        if 2 * radius >= min(x, y, z):
            raise UnfitError("is thinner than its round edges", "round")
        return cls((x / 2, y / 2, z / 2), radius)

    @property
    def words(self) -> Mapping[str, Any]:
        """The three edges and the radius."""
        return {"size": tuple(2 * half for half in self.half), "round": self.round}

    @property
    def volume(self) -> float:
        """Steiner's formula: inner box, slabs, quarter cylinders, and a sphere."""
        (a, b, c), r = self._inner, self.round
        slabs, tubes = 8 * r * (a * b + b * c + c * a), 2 * math.pi * r**2 * (a + b + c)
        return 8 * a * b * c + slabs + tubes + 4 / 3 * math.pi * r**3

    @property
    def tensor(self) -> Tensor:
        """From second moments along each axis."""
        x, y, z = (self._moment(*(self._inner[(i + k) % 3] for k in range(3))) / self.volume for i in range(3))
        return ((y + z, 0.0, 0.0), (0.0, x + z, 0.0), (0.0, 0.0, x + y))

    def reach(self, direction: Vector) -> float:
        """Inner box plus sphere."""
        inner = sum(abs(d) * h for d, h in zip(direction, self._inner, strict=True))
        return inner + math.hypot(*direction) * self.round

    def facets(self) -> Facets:
        """Six faces with bent borders; each has the whole image."""
        import numpy as np

        from wmspec.sim.shapes.facets import facets, join, quads

        bend = np.arange(_BENDS // 2 + 1) * (math.pi / 2 / _BENDS)
        tangent = np.concatenate([-np.tan(bend)[::-1], np.tan(bend)])
        core = np.repeat([-1.0, 1.0], len(bend))
        inner, made, n = np.array(self._inner), [], len(tangent)
        cells = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1)
        for axis, sign in product(range(3), (-1.0, 1.0)):
            normal = np.zeros(3)
            normal[axis] = sign
            up = np.array([0.0, 0.0, 1.0]) if axis < 2 else np.array([0.0, 1.0, 0.0])
            right = np.cross(up, normal)
            t, s = (grid.reshape(-1, 1) for grid in np.meshgrid(tangent, tangent, indexing="ij"))
            v, u = (grid.reshape(-1, 1) for grid in np.meshgrid(core, core, indexing="ij"))
            out = normal + s * right + t * up
            out /= np.linalg.norm(out, axis=1, keepdims=True)
            points = (normal + u * right + v * up) * inner + out * self.round
            flat = np.stack([points @ way / (np.array(self.half) @ abs(way)) for way in (right, up)], axis=1)
            made.append(facets(points, out, (flat + 1) / 2, quads(cells, n)))
        return join(made)

    def corners(self) -> Array:
        """For each corner, three points on the flat faces and seven between them."""
        import numpy as np

        ways = [np.array(way, float) for way in product((0, 1, 2), repeat=3) if max(way) == 2 or way == (1, 1, 1)]
        ways = [way / np.linalg.norm(way) for way in ways]
        unique = np.unique(np.round(ways, 12), axis=0)
        signs = [np.array(sign, float) for sign in product((-1, 1), repeat=3)]
        return np.concatenate([sign * (np.array(self._inner) + self.round * unique) for sign in signs])

    def depth_at(self, point: Array) -> tuple[float, Array]:
        """Depth below a flat face, or the sphere around the nearest point of the inner box."""
        import numpy as np

        from wmspec.sim.shapes.sides import plane_depths, round_depth

        inner = np.array(self._inner)
        if (np.abs(point) > inner).sum() > 1:
            return round_depth(self.round, point - np.clip(point, -inner, inner))
        axes = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
        flats = [((s * x, s * y, s * z), h) for (x, y, z), h in zip(axes, self.half, strict=True) for s in (-1.0, 1.0)]
        return min(plane_depths(flats, point), key=lambda side: side[0])

    @property
    def _inner(self) -> Vector:
        x, y, z = self.half
        return (x - self.round, y - self.round, z - self.round)

    def _moment(self, a: float, b: float, c: float) -> float:
        """Return the integral of x², with inner half edges a, b, c. A slice at a + u is a rounded rectangle.

        Its corner radius is s = √(r² - u²), its area 4bc + 4(b + c)s + πs².
        """
        r, pi = self.round, math.pi
        flat, bent = 4 * b * c, 4 * (b + c)
        zeroth = flat * r + bent * pi * r**2 / 4 + pi * 2 * r**3 / 3
        first = flat * r**2 / 2 + bent * r**3 / 3 + pi * r**4 / 4
        second = flat * r**3 / 3 + bent * pi * r**4 / 16 + pi * 2 * r**5 / 15
        middle = (flat + bent * r + pi * r**2) * 2 * a**3 / 3
        return middle + 2 * (a**2 * zeroth + 2 * a * first + second)


def box_edges(words: Mapping[str, Any]) -> Vector:
    """Return the three edges (m) of a `size`."""
    if isinstance(words["size"], tuple):
        x, y, z = words["size"]
        return (x, y, z)
    across, up = width_and_height(words)
    return (across, across, up)
