"""What prims of USD are made of: one colour or a picture, and the friction, restitution and density of materials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from pxr import Usd, UsdPhysics, UsdShade

from wmspec.importers.model import LOOKS, Color, Look, doubts
from wmspec.importers.triangles import Triangles
from wmspec.importers.usd_plugs import source, value
from wmspec.importers.usd_prims import Prims
from wmspec.importers.usd_textures import texture


def look(prims: Prims, prim: Usd.Prim, mesh: Triangles | None) -> Look:
    """How a prim looks, by its preview surface, or else its `displayColor`; `mesh` are its triangles if it is one."""
    with prims.faults.apart() as found:
        made = _look(prims, prim, mesh)
    return replace(made, doubts=doubts(found, LOOKS))


def _look(prims: Prims, prim: Usd.Prim, mesh: Triangles | None) -> Look:
    material = _bound(prim, "preview")
    shader = material.ComputeSurfaceSource()[0] if material else None
    if not shader:
        return Look(_displayed(prims, prim.GetParent() if prim.GetTypeName() == "GeomSubset" else prim))
    if shader.GetIdAttr().Get() != "UsdPreviewSurface":
        prims.faults.add(prims.where(prim), "its surface is no UsdPreviewSurface", "bind one, or none")
        return Look()
    if source(shader, "opacity")[0] or value(shader, "opacity", 1.0) != 1:
        prims.faults.add(prims.where(prim), "what is transparent is not supported", "author opacity = 1")
    image, tint = "", value(shader, "diffuseColor")
    if source(shader, "diffuseColor")[0]:
        image, tint = texture(prims, prim, shader, mesh)
    color = None if tint is None or (image and tuple(tint) == (1, 1, 1)) else _srgb(prims, prim, tint)
    return Look(color, image, _share(prims, prim, shader, "roughness", 0.5), _share(prims, prim, shader, "metallic", 0))


def _share(prims: Prims, prim: Usd.Prim, shader: UsdShade.Shader, name: str, fallback: float) -> float | None:
    """A number from 0 to 1; None if a picture says it, which is not read."""
    if source(shader, name)[0]:
        return None
    found = float(value(shader, name, fallback))
    if not 0 <= found <= 1:
        prims.faults.add(prims.where(prim), f"its {name} is not from 0 to 1", "correct it")
        return None
    return found


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
