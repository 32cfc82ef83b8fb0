"""What things can be made of, as far as the eye can tell: a table of materials, and shades of one colour.

A material is an image in shades of grey, which the colour of the object tints, and how it shines. The images repeat
without seams; `tools/looks.py` makes them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

Color = tuple[float, float, float]

TEXTURES = Path(__file__).parent / "textures"
SIZE = 256
"""The side of every image (texels)."""


@dataclass(frozen=True)
class Material:
    """A look: an image (or None) with `texels` of it on a metre, the numbers of UsdPreviewSurface, and its own colour.

    `color` (sRGB 0..1) is that of an object that says only what it is made of.
    """

    meaning: str
    color: Color
    roughness: float
    metallic: float = 0.0
    image: str | None = None
    texels: float = 0.0

    @property
    def path(self) -> Path | None:
        """The image's file."""
        return TEXTURES / self.image if self.image else None

    @property
    def repeats(self) -> float:
        """How often the image is repeated on a metre: the scale of the material's UsdTransform2d."""
        return self.texels / SIZE


MATERIALS: dict[str, Material] = {
    "plastic": Material("smooth, of one colour", (0.50, 0.50, 0.50), 0.45),
    "wood": Material("planed wood with its grain", (0.80, 0.60, 0.40), 0.60, image="wood.png", texels=1280),
    "marble": Material("polished stone with dark veins", (0.95, 0.94, 0.92), 0.20, image="marble.png", texels=1280),
    "stone": Material("speckled granite", (0.66, 0.65, 0.63), 0.80, image="stone.png", texels=1600),
    "brushed": Material("metal with fine strokes", (0.86, 0.87, 0.89), 0.35, 1.0, image="brushed.png", texels=1600),
    "fabric": Material("a coarse weave", (0.78, 0.70, 0.58), 0.95, image="fabric.png", texels=3200),
    "rubber": Material("matte, with studs", (0.24, 0.24, 0.26), 0.90, image="rubber.png", texels=3200),
    "glass": Material("glossy, with streaks of light", (0.80, 0.90, 0.92), 0.05, image="glass.png", texels=1600),
    "checker": Material("squares, light and dark", (0.95, 0.95, 0.93), 0.60, image="checker.png", texels=4267),
    "stripes": Material("stripes, light and dark", (0.95, 0.95, 0.93), 0.60, image="stripes.png", texels=4267),
}  # fmt: skip
"""Material by its name in the language."""
