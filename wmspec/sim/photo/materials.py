"""Surfaces in Mitsuba's words: the principled material of Burley (SIGGRAPH 2012 courses), with relief.

Images of wmspec's own materials are heights too, so that light shows a weave, a joint or a grain.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.materials import TEXTURES
from wmspec.sim.photo.library import mitsuba
from wmspec.sim.scene.model import Surface
from wmspec.sim.scene.render.color import texture, to_linear

SMOOTHEST = 0.05
"""Nothing is smoother: a mirror would show the few samples of the sun as sparks."""

RELIEF = {
    "asphalt": 1e-3, "brick": 2e-3, "carpet": 2e-3, "concrete": 2e-4, "fabric": 8e-4, "grass": 4e-3, "leaf": 2e-3,
    "leather": 4e-4, "metal": 2e-5, "planks": 3e-4, "rubber": 1e-3, "stone": 2e-4, "tiles": 6e-4, "weave": 1.5e-3,
    "wood": 2e-4,
}  # fmt: skip
"""How far the images of materials stand out (m, from black to white); others are flat."""

COATS: dict[str, dict[str, float]] = {
    "fabric": {"sheen": 0.6, "sheen_tint": 0.5},
    "carpet": {"sheen": 0.6, "sheen_tint": 0.5},
    "marble": {"clearcoat": 0.6, "clearcoat_gloss": 0.9},
}


CLEAR = 0.3
"""The share of its colour that each surface of glass gives to what is seen through it: a vessel has four in a row."""


@dataclass(frozen=True)
class Material:
    """What Mitsuba draws of a surface: its colour (a texture), how light leaves it (a BSDF), if it is seen through."""

    color: Any
    scattering: Any
    clear: bool = False


def material(surface: Surface) -> Material:
    """A surface's material."""
    color = mitsuba().load_dict(_color(surface))
    if _stuff(surface) == "glass":
        tint = {"type": "rgb", "value": (1 - CLEAR * (1 - to_linear(surface.color))).tolist()}
        return Material(
            color, mitsuba().load_dict({"type": "thindielectric", "specular_transmittance": tint}), clear=True
        )
    made: dict[str, Any] = {
        "type": "principled",
        "base_color": color,
        "roughness": min(max(surface.roughness, SMOOTHEST), 1.0),
        "metallic": surface.metallic,
        "specular": 0.5,
        **COATS.get(_stuff(surface), {}),
    }
    if height := RELIEF.get(_stuff(surface)):
        assert surface.texture
        image = {
            "type": "bitmap",
            "bitmap": mitsuba().Bitmap(_grey(surface.texture)),
            "raw": True,
            "wrap_mode": "repeat",
        }
        made = {"type": "bumpmap", "arbitrary": image, "scale": height, "bsdf": made}
    return Material(color, mitsuba().load_dict({"type": "twosided", "bsdf": made}))


def _stuff(surface: Surface) -> str:
    """The name of the image, if it is one of wmspec's materials."""
    path = Path(surface.texture or "")
    return path.stem if path.parent == TEXTURES else ""


def _color(surface: Surface) -> dict[str, Any]:
    if surface.texture is None:
        return {"type": "rgb", "value": to_linear(surface.color).tolist()}
    return _image(_tinted(surface.texture, surface.color))


def _image(values: NDArray[np.float32]) -> dict[str, Any]:
    """Values (h, w, 1 or 3) that are taken as they are, repeated without end."""
    return {"type": "bitmap", "bitmap": mitsuba().Bitmap(values), "raw": True, "wrap_mode": "repeat"}


@lru_cache(maxsize=64)
def _tinted(path: str, color: tuple[float, float, float]) -> NDArray[np.float32]:
    """An image in the colour of a surface, as linear light: UsdPreviewSurface multiplies, Mitsuba can't."""
    image: NDArray[np.float32] = (to_linear(texture(path) / 255) * to_linear(color)).astype(np.float32)
    return image


@lru_cache(maxsize=64)
def _grey(path: str) -> NDArray[np.float32]:
    grey: NDArray[np.float32] = (texture(path) / 255).mean(axis=-1, keepdims=True).astype(np.float32)
    return grey
