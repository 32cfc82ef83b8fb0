"""Materials: appearance (UsdPreviewSurface) and friction (PhysicsMaterialAPI)."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Gf, Usd, UsdGeom, UsdShade

from wmspec.sim.scene.model import Friction, Surface
from wmspec.sim.usd.images import image
from wmspec.sim.usd.prims import applied_schemas, refuse, static_value, value
from wmspec.sim.usd.shader_inputs import source, srgb

_PREVIEW = (0.18, 0.18, 0.18)
"""Fallback of diffuseColor of UsdPreviewSurface, linear."""


def bound_materials(prims: Sequence[Usd.Prim], purpose: str) -> list[Usd.Prim | None]:
    """Return the material bound to each prim, directly or by an ancestor, for `purpose` ('preview' or 'physics')."""
    materials, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(list(prims), purpose)
    return [material.GetPrim() if material else None for material in materials]


def friction(material: Usd.Prim | None) -> Friction:
    """Return the physics material; the default if none is bound, and 0 for unauthored values of a bound one.

    If only one of static and dynamic friction is authored, it applies to both.

    Raises: StageError: if a value is out of range.
    """
    if material is None or "PhysicsMaterialAPI" not in applied_schemas(material):
        return Friction()
    names = {"static": "staticFriction", "dynamic": "dynamicFriction", "restitution": "restitution"}
    numbers = {key: float(value(material, f"physics:{name}", 0.0)) for key, name in names.items()}
    authored = [
        key for key in ("static", "dynamic") if material.GetAttribute(f"physics:{names[key]}").HasAuthoredValue()
    ]
    if len(authored) == 1:
        numbers["static"] = numbers["dynamic"] = numbers[authored[0]]
    for key, number in numbers.items():
        if not 0 <= number < float("inf") or (key == "restitution" and number > 1):
            refuse(material, f"physics:{names[key]} = {number:g}", "expected 0 or more, and a restitution of at most 1")
    return Friction(**numbers)


def density(material: Usd.Prim | None) -> float:
    """Return the density of the physics material in stage units, 0 if it has none."""
    return float(value(material, "physics:density", 0.0)) if material is not None else 0.0


def surface(prim: Usd.Prim, material: Usd.Prim | None, st: str = "st", *, pictured: bool = False) -> Surface | None:
    """Return the preview surface of the bound material, or the displayColor of a prim without one; None without both.

    `st` is the name of the texture coordinates. With `pictured`, textured roughness and metalness use their fallback.

    Raises: StageError: if the surface has another shader, is transparent, or its texture is missing.
    """
    shader = UsdShade.Material(material).ComputeSurfaceSource()[0] if material is not None else None
    return _preview(shader, st, pictured) if shader else _displayed(prim)


def _displayed(prim: Usd.Prim) -> Surface | None:
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    colors = static_value(primvar.GetAttr()) if primvar and primvar.HasValue() else None
    return Surface(srgb(colors[0])) if colors else None


def _preview(shader: UsdShade.Shader, st: str, pictured: bool) -> Surface:
    prim = shader.GetPrim()
    if shader.GetIdAttr().Get() != "UsdPreviewSurface":
        refuse(prim, "its surface is not a UsdPreviewSurface", "give the material a UsdPreviewSurface")
    if float(_input(shader, "opacity", 1.0)) < 1:
        refuse(prim, "transparency is not supported", "set inputs:opacity to 1")
    color = source(shader, "diffuseColor")
    roughness, metallic = (
        float(_input(shader, name, fallback, pictured)) for name, fallback in (("roughness", 0.5), ("metallic", 0.0))
    )
    if isinstance(color, UsdShade.Shader):
        return image(color, roughness, metallic, st)
    return Surface(srgb(Gf.Vec3f(color or _PREVIEW)), roughness, metallic)


def _input(shader: UsdShade.Shader, name: str, fallback: float, pictured: bool = False) -> float:
    plugged = source(shader, name)
    if isinstance(plugged, UsdShade.Shader):
        if pictured:
            return fallback
        refuse(plugged.GetPrim(), f"a texture for {name} is not supported", f"author a value for inputs:{name}")
    return fallback if plugged is None else float(plugged)
