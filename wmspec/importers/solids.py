"""The shapes of assets as those of the language."""

from __future__ import annotations

from wmspec.importers.model import Shape
from wmspec.shapes import SHAPES
from wmspec.shapes import Shape as Solid


def solid(shape: Shape) -> Solid:
    """The box, sphere, cylinder or capsule."""
    if shape.kind == "box":
        return SHAPES["box"].said({"size": shape.size})
    return SHAPES[shape.kind].said({"size": 0.0, **dict(zip(("radius", "height"), shape.size, strict=False))})
