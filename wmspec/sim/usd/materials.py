"""Materials: how a geometry looks (UsdPreviewSurface) and how it rubs (PhysicsMaterialAPI)."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Gf, Usd, UsdGeom, UsdShade

from wmspec.sim.scene.model import Friction, Surface
from wmspec.sim.usd.images import image
from wmspec.sim.usd.prims import applied, refuse, still, value
from wmspec.sim.usd.shader_inputs import source, srgb

_PREVIEW = (0.18, 0.18, 0.18)
"""UsdPreviewSurface's own diffuseColor, linear."""


def bound(prims: Sequence[Usd.Prim], purpose: str) -> list[Usd.Prim | None]:
    """The Material that each prim is bound to, itself or by an ancestor, for `purpose` ('preview' or 'physics')."""
    materials, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(list(prims), purpose)
    return [material.GetPrim() if material else None for material in materials]


def friction(material: Usd.Prim | None) -> Friction:
    """The physics material; the default if none is bound, but 0 for what a bound one leaves out, as UsdPhysics says.

    If only one of the two frictions is authored, it is both: nothing rubs less at rest than in motion.

    Raises:
        StageError: if a value is out of its range.
    """
    if material is None or "PhysicsMaterialAPI" not in applied(material):
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
    """The physics material's density in the stage's units, 0 if it has none."""
    return float(value(material, "physics:density", 0.0)) if material is not None else 0.0


def surface(prim: Usd.Prim, material: Usd.Prim | None, st: str = "st", *, pictured: bool = False) -> Surface | None:
    """The preview surface of the bound material, or the displayColor of a prim without one; None without either.

    The texture coordinates of the prim are called `st`. If its roughness and metalness may be `pictured`, they are then
    those of a surface that does not say them.

    Raises:
        StageError: if the surface is of another kind, transparent, or its texture is missing.
    """
    shader = UsdShade.Material(material).ComputeSurfaceSource()[0] if material is not None else None
    return _preview(shader, st, pictured) if shader else _displayed(prim)


def _displayed(prim: Usd.Prim) -> Surface | None:
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    colors = still(primvar.GetAttr()) if primvar and primvar.HasValue() else None
    return Surface(srgb(colors[0])) if colors else None


def _preview(shader: UsdShade.Shader, st: str, pictured: bool) -> Surface:
    prim = shader.GetPrim()
    if shader.GetIdAttr().Get() != "UsdPreviewSurface":
        refuse(prim, "its surface is no UsdPreviewSurface", "give the material a UsdPreviewSurface")
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
