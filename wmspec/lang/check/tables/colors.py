"""Colours as values: words and `rgb:r,g,b`, their sRGB parts, and how light they are."""

from __future__ import annotations

from functools import lru_cache

from wmspec.lang.check.tables.vocabulary import COLORS
from wmspec.sim.materials import SHADES

Color = tuple[float, float, float]


def rgb(color: str) -> Color:
    """The sRGB parts (0..1) of a colour word or of `rgb:r,g,b`."""
    if color.startswith("rgb:"):
        r, g, b = (float(part) for part in color[4:].split(","))
        return (r, g, b)
    return SHADES[color] if color in SHADES else COLORS[color]


def word(parts: Color) -> str:
    """The word for a colour by its sRGB parts, or else `rgb:r,g,b`."""
    clipped = tuple(min(max(part, 0.0), 1.0) for part in parts)
    known_name = next((name for name, known in COLORS.items() if known == clipped), None)
    return known_name or "rgb:" + ",".join(f"{part:.6g}" for part in clipped)


@lru_cache(maxsize=4096)
def linear(part: float) -> float:
    """An sRGB part in linear light (IEC 61966-2-1)."""
    return part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4


def luminance(color: str) -> float:
    """How light a colour is: its relative luminance, 0 to 1 (Rec. 709)."""
    red, green, blue = (linear(part) for part in rgb(color))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


#: How much of a colour is left in its darkest shade, and how far from white its lightest one keeps.
_DARKEST, _LIGHTEST = 0.35, 0.35


def shade(color: str, share: float) -> str:
    """A shade of a colour, from the darkest (0) to the lightest (1) that is still that colour: even steps in sRGB."""
    share = min(max(share, 0.0), 1.0)
    r, g, b = ((1 - share) * _DARKEST * part + share * (1 - _LIGHTEST * (1 - part)) for part in rgb(color))
    return word((r, g, b))
