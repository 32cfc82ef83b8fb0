"""Image colours: UsdUVTexture with tint, and the UsdTransform2d that repeats it."""

from __future__ import annotations

from typing import Any

from pxr import Gf, Sdf, UsdShade

from wmspec.sim.scene.model import Surface
from wmspec.sim.usd.prims import refuse
from wmspec.sim.usd.shader_inputs import source, srgb

_NO_TINT, _NO_BIAS = Gf.Vec4f(1, 1, 1, 1), Gf.Vec4f(0, 0, 0, 0)
_PLAIN = {"rotation": 0.0, "translation": Gf.Vec2f(0, 0)}
"""Inputs of a UsdTransform2d that must keep their default."""


def image(shader: UsdShade.Shader, roughness: float, metallic: float, st: str) -> Surface:
    """Return the surface whose colour is the image that `shader` reads with texture coordinates `st`.

    Raises: StageError: if the shader is not a UsdUVTexture, or uses unsupported inputs.
    """
    prim = shader.GetPrim()
    if shader.GetIdAttr().Get() != "UsdUVTexture":
        refuse(prim, "its colour comes from a shader other than UsdUVTexture", "use a UsdUVTexture or a value")
    if source(shader, "sourceColorSpace") == "raw":
        refuse(prim, "its image is not in sRGB", "set inputs:sourceColorSpace to sRGB")
    repeats = _repeats(shader, st)
    if repeats is not None and not {source(shader, "wrapS"), source(shader, "wrapT")} <= {
        "repeat",
        "useMetadata",
        None,
    }:
        refuse(
            prim,
            "its image has a repeating transform but no repeating wrap mode",
            "set inputs:wrapS and wrapT to repeat",
        )
    return Surface(_tint(shader), roughness, metallic, _file(shader), repeats)


def _tint(shader: UsdShade.Shader) -> tuple[float, float, float]:
    scale, bias = source(shader, "scale"), source(shader, "bias")
    red, green, blue, _ = _NO_TINT if scale is None else Gf.Vec4f(scale)
    if bias not in (None, _NO_BIAS) or not all(0 <= part <= 1 for part in (red, green, blue)):
        refuse(shader.GetPrim(), "its image has a bias or a scale outside 0..1", "use a scale of 0 to 1 and no bias")
    return srgb(Gf.Vec3f(red, green, blue))


def _repeats(shader: UsdShade.Shader, st: str) -> tuple[float, float] | None:
    """Return the repetition of the image: the scale of a UsdTransform2d before the texture coordinates."""
    reader = source(shader, "st")
    if isinstance(reader, UsdShade.Shader) and reader.GetIdAttr().Get() == "UsdTransform2d":
        scale, reader = _scale(reader), source(reader, "in")
    else:
        scale = None
    _check_reader(reader, st)
    return scale


def _scale(transform: UsdShade.Shader) -> tuple[float, float]:
    scale: Any = source(transform, "scale")
    s, t = (1.0, 1.0) if scale is None else Gf.Vec2f(scale)
    moved = any(source(transform, name) not in (None, plain) for name, plain in _PLAIN.items())
    if moved or not (0 < s < float("inf") and 0 < t < float("inf")):
        refuse(
            transform.GetPrim(),
            "its UsdTransform2d does more than scale",
            "use a scale above 0 and no rotation or translation, or bake the transform into primvars:st",
        )
    return float(s), float(t)


def _check_reader(reader: Any, st: str) -> None:
    """Refuse texture coordinates other than `st`, the default of a texture without a reader."""
    if not isinstance(reader, UsdShade.Shader):
        return
    if reader.GetIdAttr().Get() != "UsdPrimvarReader_float2":
        refuse(reader.GetPrim(), "it computes texture coordinates", f"use a UsdPrimvarReader_float2 for `{st}`")
    if (name := source(reader, "varname")) not in (None, "", st):
        reason = f"its image uses the texture coordinates '{name}', but the mesh has '{st}'"
        refuse(reader.GetPrim(), reason, "read these with a UsdPrimvarReader_float2, or rename the primvar to st")


def _file(shader: UsdShade.Shader) -> str:
    path: Sdf.AssetPath | None = source(shader, "file")
    if not path or not path.resolvedPath:
        name = path.path if path else ""
        refuse(shader.GetPrim(), f"its image {name!r} is not found", "author a path relative to its layer's file")
    return str(path.resolvedPath)
