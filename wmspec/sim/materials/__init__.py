"""Visual materials and shades of one colour.

A material is a grey image, tinted by the colour of the object, and its gloss. Images tile seamlessly; `tools/looks.py`
generates them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

Color = tuple[float, float, float]

TEXTURES = Path(__file__).parent / "textures"
TEXTURE_SIZE = 256
"""Side of each image (texels)."""


@dataclass(frozen=True)
class Material:
    """A look: an image (or None) with `texels` per metre, parameters of UsdPreviewSurface, and a default colour.

    `color` (sRGB 0..1) applies to objects without a colour.
    """

    meaning: str
    color: Color
    roughness: float
    metallic: float = 0.0
    image: str | None = None
    texels: float = 0.0

    @property
    def path(self) -> Path | None:
        """Path of the image file."""
        return TEXTURES / self.image if self.image else None

    @property
    def repeats(self) -> float:
        """Repetitions of the image per metre: the scale of the material's UsdTransform2d."""
        return self.texels / TEXTURE_SIZE


MATERIALS: dict[str, Material] = {
    "plastic": Material("smooth, of one colour", (0.50, 0.50, 0.50), 0.45),
    "wood": Material("planed wood with its grain", (0.80, 0.60, 0.40), 0.60, image="wood.png", texels=1280),
    "marble": Material("polished stone with dark veins", (0.95, 0.94, 0.92), 0.20, image="marble.png", texels=1280),
    "stone": Material("speckled granite", (0.66, 0.65, 0.63), 0.80, image="stone.png", texels=1600),
    "metal": Material("brushed steel, finely stroked", (0.86, 0.87, 0.89), 0.35, 1.0, image="metal.png", texels=1600),
    "fabric": Material("a coarse weave", (0.78, 0.70, 0.58), 0.95, image="fabric.png", texels=3200),
    "rubber": Material("matte, with studs", (0.24, 0.24, 0.26), 0.90, image="rubber.png", texels=3200),
    "glass": Material("glossy, with streaks of light", (0.80, 0.90, 0.92), 0.05, image="glass.png", texels=1600),
    "checker": Material("squares, light and dark", (0.95, 0.95, 0.93), 0.60, image="checker.png", texels=4267),
    "stripes": Material("stripes, light and dark", (0.95, 0.95, 0.93), 0.60, image="stripes.png", texels=4267),
    "brick": Material("a brick wall", (0.72, 0.36, 0.26), 0.90, image="brick.png", texels=512),
    "tiles": Material("glazed tiles with joints", (0.93, 0.94, 0.94), 0.15, image="tiles.png", texels=640),
    "planks": Material("boards of a floor", (0.76, 0.55, 0.36), 0.50, image="planks.png", texels=440),
    "carpet": Material("tufts of wool", (0.62, 0.55, 0.50), 0.95, image="carpet.png", texels=900),
    "leather": Material("pebbled leather", (0.42, 0.24, 0.14), 0.50, image="leather.png", texels=1600),
    "paper": Material("card, or edges of stacked pages", (0.93, 0.91, 0.86), 0.90, image="paper.png", texels=3200),
    "weave": Material("wicker", (0.72, 0.54, 0.33), 0.80, image="weave.png", texels=1600),
    "leaf": Material("leaves over leaves", (0.25, 0.48, 0.18), 0.70, image="leaf.png", texels=640),
    "concrete": Material("smooth concrete with pores", (0.66, 0.66, 0.64), 0.85, image="concrete.png", texels=256),
    "asphalt": Material("tar with grit", (0.30, 0.30, 0.32), 0.95, image="asphalt.png", texels=640),
    "grass": Material("a lawn", (0.33, 0.52, 0.20), 0.95, image="grass.png", texels=400),
}  # fmt: skip
"""Materials by name in the language."""

DISTINCT_COLORS = (
    "red",
    "orange",
    "yellow",
    "green",
    "cyan",
    "blue",
    "purple",
    "pink",
    "brown",
    "white",
    "gray",
    "black",
)
"""Colours for questions: any two differ by a CIEDE2000 of at least 16 for normal vision, and 9.5 for every colour
vision deficiency (Machado, Oliveira and Fernandes, IEEE TVCG 15, 2009). As drawn in the lights of the libraries, whose
shade darkens them, any two differ by at least 15.
"""

SHADES: dict[str, Color] = {
    "blue_1": (0.84, 0.90, 0.98),
    "blue_2": (0.63, 0.76, 0.96),
    "blue_3": (0.43, 0.59, 0.93),
    "blue_4": (0.26, 0.44, 0.90),
    "blue_5": (0.16, 0.31, 0.77),
    "blue_6": (0.07, 0.17, 0.58),
    "blue_7": (0.03, 0.07, 0.30),
}
"""Blue (sRGB) from light to dark in equal steps (a CIEDE2000 of 12)."""
