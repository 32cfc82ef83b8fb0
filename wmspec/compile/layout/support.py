"""Whether what is put on something touches it anywhere."""

from __future__ import annotations

from wmspec.compile.layout import assets
from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.placement import frame
from wmspec.compile.layout.solids import bounds
from wmspec.compile.layout.surfaces import tops
from wmspec.compile.layout.values import Values
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import UP
from wmspec.lang.check.types import units


def supported(name: str, values: Values) -> None:
    """Raise WmsError with its place if an object that rests on another is beside it, in the air.

    Both count as the upright boxes around them, a ball on a level top as the point on which it rests.
    """
    if not values.has(name, "on"):
        return
    base = values.reference(name, "on")
    made, pose = assets.pieces(values, name), frame(values, name) if name in values.assets else values.pose(name)
    low, high = bounds(made, pose)
    if len(made) == 1 and made[0].solid.symmetry == "ball" and tops(values, base)[0].normal == UP:
        low = high = pose.then(made[0].pose).position
    least, most = values.once((base, "upright box"), lambda: bounds(pieces(values, base), values.pose(base)))
    if any(low[i] > most[i] + 1e-9 or high[i] < least[i] - 1e-9 for i in range(2)):
        word = "scatter" if values.has(name, "scatter") else "at"
        size = " by ".join(units.told(most[i] - least[i], units.LENGTH) for i in range(2))
        raise ImpossibleValue(
            f"`{name}` is in the air beside `{base}`, on which it should rest and which is {size} large",
            values.place(name, word),
            "move it there, or leave `on:` out and say `at: (x, y, z)`",
        )
