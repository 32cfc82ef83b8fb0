"""The inputs of shaders: their values, or the shaders that make them."""

from __future__ import annotations

from typing import Any

from pxr import UsdShade


def source(shader: UsdShade.Shader, name: str) -> tuple[UsdShade.Shader | None, str]:
    """The shader that makes an input and by which of its outputs; None if none does."""
    for attribute in _producers(shader, name):
        if UsdShade.Output.IsOutput(attribute):
            return UsdShade.Shader(attribute.GetPrim()), UsdShade.Output(attribute).GetBaseName()
    return None, ""


def value(shader: UsdShade.Shader, name: str, default: Any = None) -> Any:
    """The value of an input, through the interface of its material; the default if it has none."""
    found = [a.Get() for a in _producers(shader, name) if not UsdShade.Output.IsOutput(a)]
    return default if not found or found[0] is None else found[0]


def _producers(shader: UsdShade.Shader, name: str) -> Any:
    plug = shader.GetInput(name)
    return plug.GetValueProducingAttributes() if plug else ()
