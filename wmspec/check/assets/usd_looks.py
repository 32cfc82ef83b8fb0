"""What prims of USD are made of: one colour or a picture, and the friction, restitution and density of materials."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Usd, UsdPhysics, UsdShade

from wmspec.check.assets.model import LOOKS, Color, Doubt
from wmspec.check.assets.triangles import Triangles
from wmspec.check.assets.usd_prims import Prims
from wmspec.check.assets.usd_textures import texture


def look(prims: Prims, prim: Usd.Prim, mesh: Triangles | None) -> tuple[Color | None, str, tuple[Doubt, ...]]:
    """The colour (sRGB) of a prim or None, the picture on it or nothing, and what is wrong with them.

    They are those of its preview surface, or else its `displayColor`; `mesh` are its triangles if it is one.
    """
    with prims.faults.apart() as found:
        color, image = _look(prims, prim, mesh)
    return color, image, tuple(Doubt(fault, LOOKS) for fault in found)


def _look(prims: Prims, prim: Usd.Prim, mesh: Triangles | None) -> tuple[Color | None, str]:
    material = _bound(prim, "preview")
    shader = material.ComputeSurfaceSource()[0] if material else None
    if not shader:
        of = prim.GetParent() if prim.GetTypeName() == "GeomSubset" else prim
        return _displayed(prims, of), ""
    if shader.GetIdAttr().Get() != "UsdPreviewSurface":
        prims.faults.add(prims.where(prim), "its surface is no UsdPreviewSurface", "bind one, or none")
        return None, ""
    opacity, diffuse = (shader.GetInput(name) for name in ("opacity", "diffuseColor"))
    if opacity and (opacity.HasConnectedSource() or opacity.Get() not in (None, 1.0)):
        prims.faults.add(prims.where(prim), "what is transparent is not supported", "author opacity = 1")
    if diffuse and diffuse.HasConnectedSource():
        image, tint = texture(prims, prim, diffuse, mesh)
        return (None if (tint == 1).all() else _srgb(prims, prim, tint)), image
    found = diffuse.Get() if diffuse else None
    return (None if found is None else _srgb(prims, prim, found)), ""


def _displayed(prims: Prims, prim: Usd.Prim) -> Color | None:
    """Its `displayColor`, which must be one."""
    shown = prims.value(prim, "primvars:displayColor", ())
    if not len(shown):
        return None
    if (np.ptp(np.asarray(shown, float), axis=0) > 1e-6).any():
        prims.faults.add(
            prims.where(prim), "it has a displayColor of several colours", "make it one, or bind a material"
        )
    return _srgb(prims, prim, shown[0])


def rubs(prims: Prims, colliders: Sequence[Usd.Prim]) -> dict[str, float]:
    """Friction and restitution of all colliders of a body; nothing if no material says them."""
    found = [_friction(prims, prim) for prim in colliders]
    if any(other != found[0] for other in found):
        what = "the colliders of a body have different physics materials"
        prims.faults.add(prims.where(colliders[0]), what, "bind one to all of them")
    return found[0] if found else {}


def density(prims: Prims, prim: Usd.Prim) -> float:
    """The density that the physics material of a collider says, in units of the stage; 0 if none does."""
    material = _bound(prim, "physics")
    return prims.number(material.GetPrim(), "physics:density", 0.0) if material else 0.0


def _friction(prims: Prims, prim: Usd.Prim) -> dict[str, float]:
    material = _bound(prim, "physics")
    if not material or not material.GetPrim().HasAPI(UsdPhysics.MaterialAPI):
        return {}
    found: dict[str, float] = {}
    of = material.GetPrim()
    frictions = [x for name in ("static", "dynamic") if (x := _authored(of, f"physics:{name}Friction")) is not None]
    if frictions:
        if max(frictions) > min(frictions):
            prims.faults.add(prims.where(of), "static and dynamic friction differ", "make them equal")
        found["friction"] = frictions[0]
    bounce = _authored(of, "physics:restitution")
    if bounce is not None:
        found["restitution"] = bounce
    for name, most in (("friction", 5.0), ("restitution", 1.0)):
        if not 0 <= found.get(name, 0.0) <= most:
            prims.faults.add(prims.where(of), f"its {name} is not from 0 to {most:g}", "correct it")
    return found


def _authored(prim: Usd.Prim, name: str) -> float | None:
    attribute = prim.GetAttribute(name)
    return float(attribute.Get()) if attribute and attribute.HasAuthoredValue() else None


def _bound(prim: Usd.Prim, purpose: str) -> Any:
    """The material bound for a purpose, or for all."""
    return UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(purpose)[0]


def _srgb(prims: Prims, prim: Usd.Prim, linear: Any) -> Color | None:
    """A linear colour as sRGB (IEC 61966-2-1)."""
    if not all(0 <= x <= 1 for x in linear):
        prims.faults.add(prims.where(prim), "its colour is not three numbers from 0 to 1", "correct it")
        return None
    red, green, blue = (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055 for x in linear)
    return red, green, blue
