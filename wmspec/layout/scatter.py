"""Scattered objects: each takes the first of its random places that keeps away from those that came before it.

A proposal depends on the seed, the task, the block, the object's name and its number alone, so that nothing but what
the objects themselves need moves them.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from wmspec.diagnostics import ImpossibleValue
from wmspec.draws import uniform
from wmspec.layout import assets
from wmspec.layout.geometry import own_turn
from wmspec.layout.solids import Face, footprint
from wmspec.layout.surfaces import seen_from, tops
from wmspec.space import UP, turn

if TYPE_CHECKING:
    from wmspec.layout.values import Values

#: How many places are tried for an object before giving up.
TRIES = 1000


def place(values: Values, owner: str) -> tuple[float, float]:
    """Where a scattered object is: (x, y) on what it rests on, else on the ground."""
    base = _base(values, owner)
    places = values.once((base, "scattered"), lambda: _scattered(values, base))
    return places[owner]


def _base(values: Values, owner: str) -> str:
    base: str = values.property(owner, "on") if values.has(owner, "on") else ""
    return base


def _scattered(values: Values, base: str) -> dict[str, tuple[float, float]]:
    """The places of all that scatter on `base`, there or not."""
    names = [t.name for t in values.spec.things if t.kind == "object" and values.has(t.name, "scatter")]
    members = sorted((name for name in names if _base(values, name) == base), key=natural)
    face = tops(values, base)[0] if base else Face((0.0, 0.0, 0.0), UP)
    circles: dict[str, tuple[float, float, float]] = {}
    for name in members:
        circles[name] = _free(values, name, face, list(circles.values()))
    return {name: (x, y) for name, (x, y, _) in circles.items()}


def _free(values: Values, name: str, face: Face, taken: list[tuple[float, float, float]]) -> tuple[float, float, float]:
    """The first proposal that is free: the middle and radius of its circle."""
    _, pitch, roll = own_turn(values, name)
    radius = footprint(assets.pieces(values, name), turn(0.0, pitch, roll))
    x, y = seen_from(face, values.property(name, "at"))
    (width, depth), gap = values.property(name, "scatter"), values.property(name, "gap")
    for k in range(TRIES):
        u, v = (uniform(*values.key, name, axis, k) - 0.5 for axis in "xy")
        here = (x + width * u, y + depth * v)
        if all(math.dist(here, other[:2]) >= radius + other[2] + gap for other in taken):
            return (*here, radius)
    raise ImpossibleValue(
        f"no room for `{name}` between the {len(taken)} scattered before it",
        values.place(name, "scatter"),
        "widen `scatter`, or make the objects smaller, fewer or their `gap` smaller",
    )


def natural(name: str) -> list[tuple[str, int]]:
    """A key that sorts names as people do: blocks_2 before blocks_10."""
    return [(text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d*)", name)]
