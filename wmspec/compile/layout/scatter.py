"""Scattered objects: each takes the first of its random positions that is clear of the objects before it.

If an object finds none, all are placed again. A proposal depends on seed, task, block, object name and its number only.
Objects therefore move only if their own space requirements change.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from wmspec.compile.layout import assets
from wmspec.compile.layout.geometry import own_rotation
from wmspec.compile.layout.solids import Face, footprint
from wmspec.compile.layout.surfaces import face_coordinates, support_faces
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.rng import uniforms
from wmspec.core.space import UP, from_ypr

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

#: Centre and radius (m) of the area that a scattered object covers.
Circle = tuple[float, float, float]

#: Number of positions tried per object before all are placed again, and number of such rounds.
MAX_TRIES, MAX_ROUNDS = 1000, 10


def scattered_position(values: Evaluator, owner: str) -> tuple[float, float]:
    """Return the position (x, y) of a scattered object on its support, else on the ground."""
    base = _base(values, owner)
    places = values.memoized((base, "scattered"), lambda: _scattered_positions(values, base))
    return places[owner]


def _base(values: Evaluator, owner: str) -> str:
    return values.reference(owner, "on") if values.has(owner, "on") else ""


def _scattered_positions(values: Evaluator, base: str) -> dict[str, tuple[float, float]]:
    """Return the positions of all objects that scatter on `base`, present or not."""
    names = [t.name for t in values.spec.things if t.kind == "object" and values.has(t.name, "scatter")]
    members = sorted((name for name in names if _base(values, name) == base), key=natural_key)
    face = support_faces(values, base)[0] if base else Face((0.0, 0.0, 0.0), UP)
    for deal in range(MAX_ROUNDS):
        circles: dict[str, Circle] = {}
        for name in members:
            circle = _free_circle(values, name, face, list(circles.values()), deal)
            if circle is None:
                break
            circles[name] = circle
        else:
            return {name: (x, y) for name, (x, y, _) in circles.items()}
    raise ImpossibleValue(
        f"no room for `{name}` between the {len(circles)} scattered before it",
        values.source_location(name, "scatter"),
        "widen `scatter`, or make the objects smaller, fewer or their `gap` smaller",
    )


def _free_circle(values: Evaluator, name: str, face: Face, taken: list[Circle], deal: int) -> Circle | None:
    """Return the first free proposal of this round, or None."""
    _, pitch, roll = own_rotation(values, name)
    radius = footprint(assets.pieces(values, name), from_ypr(0.0, pitch, roll))
    x, y = face_coordinates(face, values.spot(name))
    (width, depth), gap = values.pair(name, "scatter"), values.number(name, "gap")
    across, along = (uniforms(*values.key, name, axis) for axis in "xy")
    others = [(other[:2], radius + other[2] + gap) for other in taken]
    for k in range(deal * MAX_TRIES, (deal + 1) * MAX_TRIES):
        here = (x + width * (across(k) - 0.5), y + depth * (along(k) - 0.5))
        if all(math.dist(here, place) >= apart for place, apart in others):
            return (*here, radius)
    return None


def natural_key(name: str) -> list[tuple[str, int]]:
    """Return a key for natural sorting: blocks_2 before blocks_10."""
    return [(text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d*)", name)]
