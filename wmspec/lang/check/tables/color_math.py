"""Colours: words and `rgb:r,g,b`, their sRGB components and luminance."""

from __future__ import annotations

from functools import lru_cache

from wmspec.lang.check.tables.vocabulary import COLORS
from wmspec.sim.materials import SHADES

Color = tuple[float, float, float]


def rgb(color: str) -> Color:
    """Return the sRGB components (0..1) of a colour word or `rgb:r,g,b`."""
    if color.startswith("rgb:"):
        r, g, b = (float(part) for part in color[4:].split(","))
        return (r, g, b)
    return SHADES[color] if color in SHADES else COLORS[color]


def color_word(parts: Color) -> str:
    """Return the colour word of sRGB components, or `rgb:r,g,b`."""
    clipped = tuple(min(max(part, 0.0), 1.0) for part in parts)
    known_name = next((name for name, known in COLORS.items() if known == clipped), None)
    return known_name or "rgb:" + ",".join(f"{part:.6g}" for part in clipped)


@lru_cache(maxsize=4096)
def linear(part: float) -> float:
    """Return an sRGB component in linear light (IEC 61966-2-1)."""
    return part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4


def luminance(color: str) -> float:
    """Return the relative luminance of a colour, 0 to 1 (Rec. 709)."""
    red, green, blue = (linear(part) for part in rgb(color))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


#: Share of the colour in its darkest shade, and share of the distance to white that its lightest shade keeps.
_DARKEST, _LIGHTEST = 0.35, 0.35


def shade(color: str, share: float) -> str:
    """Return a shade of a colour, from darkest (0) to lightest (1), in equal sRGB steps."""
    share = min(max(share, 0.0), 1.0)
    r, g, b = ((1 - share) * _DARKEST * part + share * (1 - _LIGHTEST * (1 - part)) for part in rgb(color))
    return color_word((r, g, b))
