"""Scattered objects: each takes the first of its random places that keeps away from those that came before it.

Where one of them finds none, all of them are laid anew. A proposal depends on the seed, the task, the block, the
object's name and its number alone, so that nothing but what the objects themselves need moves them.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from wmspec.compile.layout import assets
from wmspec.compile.layout.geometry import own_turn
from wmspec.compile.layout.solids import Face, footprint
from wmspec.compile.layout.surfaces import seen_from, tops
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.rng import uniform
from wmspec.core.space import UP, turn

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

#: The middle of what a scattered object covers, and its radius, in m.
Circle = tuple[float, float, float]

#: How many places are tried for an object before all are laid anew, and how often that is done before giving up.
TRIES, DEALS = 1000, 10


def place(values: Values, owner: str) -> tuple[float, float]:
    """Where a scattered object is: (x, y) on what it rests on, else on the ground."""
    base = _base(values, owner)
    places = values.once((base, "scattered"), lambda: _scattered(values, base))
    return places[owner]


def _base(values: Values, owner: str) -> str:
    base = values.reference(owner, "on") if values.has(owner, "on") else ""
    return base


def _scattered(values: Values, base: str) -> dict[str, tuple[float, float]]:
    """The places of all that scatter on `base`, there or not."""
    names = [t.name for t in values.spec.things if t.kind == "object" and values.has(t.name, "scatter")]
    members = sorted((name for name in names if _base(values, name) == base), key=natural)
    face = tops(values, base)[0] if base else Face((0.0, 0.0, 0.0), UP)
    for deal in range(DEALS):
        circles: dict[str, Circle] = {}
        for name in members:
            circle = _free(values, name, face, list(circles.values()), deal)
            if circle is None:
                break
            circles[name] = circle
        else:
            return {name: (x, y) for name, (x, y, _) in circles.items()}
    raise ImpossibleValue(
        f"no room for `{name}` between the {len(circles)} scattered before it",
        values.place(name, "scatter"),
        "widen `scatter`, or make the objects smaller, fewer or their `gap` smaller",
    )


def _free(values: Values, name: str, face: Face, taken: list[Circle], deal: int) -> Circle | None:
    """The first of this deal's proposals that is free, if one is."""
    _, pitch, roll = own_turn(values, name)
    radius = footprint(assets.pieces(values, name), turn(0.0, pitch, roll))
    x, y = seen_from(face, values.spot(name))
    (width, depth), gap = values.pair(name, "scatter"), values.number(name, "gap")
    for k in range(deal * TRIES, (deal + 1) * TRIES):
        u, v = (uniform(*values.key, name, axis, k) - 0.5 for axis in "xy")
        here = (x + width * u, y + depth * v)
        if all(math.dist(here, other[:2]) >= radius + other[2] + gap for other in taken):
            return (*here, radius)
    return None


def natural(name: str) -> list[tuple[str, int]]:
    """A key that sorts names as people do: blocks_2 before blocks_10."""
    return [(text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d*)", name)]
