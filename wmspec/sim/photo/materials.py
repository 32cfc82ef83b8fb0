"""Mitsuba materials: Burley's principled BSDF (SIGGRAPH 2012 courses) with relief.

The images of wmspec's materials double as height maps.
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
from wmspec.sim.scene.render.color import load_texture, to_linear

MIN_ROUGHNESS = 0.05
"""Smoother surfaces would show single samples of the sun as sparks."""

RELIEF = {
    "asphalt": 1e-3, "brick": 2e-3, "carpet": 2e-3, "concrete": 2e-4, "fabric": 8e-4, "grass": 4e-3, "leaf": 2e-3,
    "leather": 4e-4, "metal": 2e-5, "planks": 3e-4, "rubber": 1e-3, "stone": 2e-4, "tiles": 6e-4, "weave": 1.5e-3,
    "wood": 2e-4,
}  # fmt: skip
"""Relief of material images (m, from black to white); others are flat."""

COATS: dict[str, dict[str, float]] = {
    "fabric": {"sheen": 0.6, "sheen_tint": 0.5},
    "carpet": {"sheen": 0.6, "sheen_tint": 0.5},
    "marble": {"clearcoat": 0.6, "clearcoat_gloss": 0.9},
}


GLASS_TINT = 0.3
"""Tint per glass surface; a line of sight through a vessel crosses four."""


@dataclass(frozen=True)
class Material:
    """A Mitsuba material: colour (a texture), scattering (a BSDF), and transparency."""

    color: Any
    scattering: Any
    clear: bool = False


def material(surface: Surface) -> Material:
    """Return the material of a surface."""
    color = mitsuba().load_dict(_color(surface))
    if _stuff(surface) == "glass":
        tint = {"type": "rgb", "value": (1 - GLASS_TINT * (1 - to_linear(surface.color))).tolist()}
        return Material(
            color, mitsuba().load_dict({"type": "thindielectric", "specular_transmittance": tint}), clear=True
        )
    made: dict[str, Any] = {
        "type": "principled",
        "base_color": color,
        "roughness": min(max(surface.roughness, MIN_ROUGHNESS), 1.0),
        "metallic": surface.metallic,
        "specular": 0.5,
        **COATS.get(_stuff(surface), {}),
    }
    if height := RELIEF.get(_stuff(surface)):
        assert surface.texture
        made = {"type": "bumpmap", "arbitrary": _image(_grey(surface.texture)), "scale": height, "bsdf": made}
    return Material(color, mitsuba().load_dict({"type": "twosided", "bsdf": made}))


def _stuff(surface: Surface) -> str:
    """Return the material name of the image if it is one of wmspec's."""
    path = Path(surface.texture or "")
    return path.stem if path.parent == TEXTURES else ""


def _color(surface: Surface) -> dict[str, Any]:
    if surface.texture is None:
        return {"type": "rgb", "value": to_linear(surface.color).tolist()}
    return _image(_tinted(surface.texture, surface.color))


def _image(values: NDArray[np.float32]) -> dict[str, Any]:
    """Return a raw repeating bitmap of values (h, w, 1 or 3)."""
    return {"type": "bitmap", "bitmap": mitsuba().Bitmap(values), "raw": True, "wrap_mode": "repeat"}


@lru_cache(maxsize=64)
def _tinted(path: str, color: tuple[float, float, float]) -> NDArray[np.float32]:
    """Return an image multiplied by the surface colour, as linear light; Mitsuba cannot multiply textures."""
    image: NDArray[np.float32] = (to_linear(load_texture(path) / 255) * to_linear(color)).astype(np.float32)
    return image


@lru_cache(maxsize=64)
def _grey(path: str) -> NDArray[np.float32]:
    grey: NDArray[np.float32] = (load_texture(path) / 255).mean(axis=-1, keepdims=True).astype(np.float32)
    return grey
