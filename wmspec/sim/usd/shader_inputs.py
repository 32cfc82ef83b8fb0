"""Inputs of shaders."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from pxr import Gf, UsdShade

from wmspec.sim.scene.render.color import to_srgb
from wmspec.sim.usd.prims import static_value


def source(shader: UsdShade.Shader, name: str) -> Any:
    """Return the value of an input (through a material's interface), the shader that computes it, or None."""
    plug = shader.GetInput(name)
    for attribute in plug.GetValueProducingAttributes() if plug else []:
        if UsdShade.Output.IsOutput(attribute):
            return UsdShade.Shader(attribute.GetPrim())
        return static_value(attribute)
    return None


def srgb(linear: Gf.Vec3f) -> tuple[float, float, float]:
    """Return a linear colour as sRGB."""
    return _srgb(linear[0], linear[1], linear[2])


@lru_cache(maxsize=1024)
def _srgb(*linear: float) -> tuple[float, float, float]:
    r, g, b = to_srgb(linear).tolist()
    return r, g, b
