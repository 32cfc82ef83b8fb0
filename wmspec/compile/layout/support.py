"""Checks that an object touches what it rests on."""

from __future__ import annotations

from wmspec.compile.layout import assets
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.placement import frame
from wmspec.compile.layout.solids import bounds
from wmspec.compile.layout.surfaces import support_faces
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import UP
from wmspec.lang.check.types import units


def require_support(name: str, values: Evaluator) -> None:
    """Raise WmsError with its location if an object that rests on another is beside it, in the air.

    Both count as their axis-aligned boxes; a ball on a level top counts as its contact point.
    """
    if not values.has(name, "on"):
        return
    base = values.reference(name, "on")
    made, pose = assets.pieces(values, name), frame(values, name) if name in values.assets else values.pose(name)
    low, high = bounds(made, pose)
    if len(made) == 1 and made[0].solid.symmetry == "ball" and support_faces(values, base)[0].normal == UP:
        low = high = pose.compose(made[0].pose).position
    least, most = values.memoized((base, "upright box"), lambda: bounds(pieces(values, base), values.pose(base)))
    if any(low[i] > most[i] + 1e-9 or high[i] < least[i] - 1e-9 for i in range(2)):
        word = "scatter" if values.has(name, "scatter") else "at"
        size = " by ".join(units.format_quantity(most[i] - least[i], units.LENGTH) for i in range(2))
        raise ImpossibleValue(
            f"`{name}` is in the air beside `{base}`, on which it should rest and which is {size} large",
            values.source_location(name, word),
            "move it there, or leave `on:` out and say `at: (x, y, z)`",
        )
