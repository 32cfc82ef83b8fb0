"""Visual geometry of a car: shapes, each with a colour. It has no collision geometry."""

from __future__ import annotations

import math
from functools import cache

from wmspec.compile.layout.solids import PlacedShape
from wmspec.core.space import Pose, Vector, from_ypr
from wmspec.sim.shapes import SHAPES

BODY_COLOR = ""
"""Marks parts that have the colour of the car."""

_OUTLINES = (
    ((-2.1, 0.28), (2.08, 0.28), (2.1, 0.55), (1.95, 0.72), (0.95, 0.84), (-1.6, 0.9), (-2.08, 0.86)),
    ((0.9, 0.84), (0.28, 1.36), (0.1, 1.4), (-1.0, 1.4), (-1.2, 1.36), (-1.7, 0.88)),
)
"""Outlines of the hull and of the windows (m), seen from the right, anticlockwise."""


@cache
def parts() -> tuple[tuple[str, PlacedShape, str], ...]:
    """Return name, shape and colour of each part; x is ahead, the origin below the centre on the ground."""
    hull = _piece("extrude", (0.0, 0.0, 0.0), outline=_OUTLINES[0], depth=1.76)
    glass = _piece("extrude", (0.0, 0.0, 0.0), outline=_OUTLINES[1], depth=1.5)
    roof = _piece("box", (-0.5, 0.0, 1.41), size=(1.3, 1.44, 0.04))
    posts = (
        (f"post_{i}", _piece("box", (-0.52, y, 1.12), size=(0.09, 0.03, 0.56)), BODY_COLOR) for i, y in enumerate(_BOTH)
    )
    wheels = ((f"wheel_{i}", _wheel(x, y), "black") for i, (x, y) in enumerate(_WHEELS))
    hubs = ((f"hub_{i}", _wheel(x, y * 1.04, 0.17), "gray") for i, (x, y) in enumerate(_WHEELS))
    lamps = (
        (f"lamp_{i}", _piece("box", (2.08, y, 0.53), size=(0.06, 0.3, 0.12)), "chalk") for i, y in enumerate(_LAMPS)
    )
    lights = (
        (f"light_{i}", _piece("box", (-2.08, y, 0.72), size=(0.04, 0.3, 0.14)), "red") for i, y in enumerate(_LAMPS)
    )
    every = (("hull", hull, BODY_COLOR), ("glass", glass, "black"), ("roof", roof, BODY_COLOR))
    return (*every, *posts, *wheels, *hubs, *lamps, *lights)


_BOTH = (-0.75, 0.75)
_LAMPS = (-0.65, 0.65)
_WHEELS = ((1.32, -0.8), (1.32, 0.8), (-1.3, -0.8), (-1.3, 0.8))


def _piece(shape: str, at: Vector, **words: object) -> PlacedShape:
    return PlacedShape(SHAPES[shape].from_words({"size": 0.1, **words}), Pose(at))


def _wheel(x: float, y: float, radius: float = 0.32) -> PlacedShape:
    solid = SHAPES["cylinder"].from_words({"size": 0.1, "radius": radius, "height": 0.2})
    return PlacedShape(solid, Pose((x, y, 0.32), from_ypr(0.0, 0.0, math.pi / 2)))
