"""Materials: appearance and friction in one prim, since some importers read a single binding only."""

from __future__ import annotations

from pathlib import Path

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Document, Prim
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.check.tables.color_math import linear, rgb
from wmspec.lang.parse.files import resolve_display_path
from wmspec.sim.materials import MATERIALS


def add_material(doc: Document, part: str, owner: str, values: Evaluator) -> str:
    """Add the material of an object or of one of its parts; returns its path."""
    path = f"/World/Materials/{part.replace('.', '/')}"
    there = (f"{owner}.present", f"{owner}.form")
    if part != owner and f"/World/Materials/{owner}" not in doc.prims:
        doc.add(f"/World/Materials/{owner}", "Scope", (), there)
    material = doc.add(path, "Material", ("PhysicsMaterialAPI",), there)
    material.connect("outputs:surface", "token", f"{path}/surface.outputs:surface")
    for name, written in (("friction", ("staticFriction", "dynamicFriction")), ("restitution", ("restitution",))):
        of = part if values.has(part, name) else owner
        for attribute in written:
            material.set(f"physics:{attribute}", "float", values.number(of, name), f"{of}.{name}")
    surface = doc.add(f"{path}/surface", "Shader", (), there)
    surface.set("info:id", "token", "UsdPreviewSurface", uniform=True)
    _color(doc, surface, path, part, values, there)
    for name in ("roughness", "metallic"):
        surface.set(f"inputs:{name}", "float", values.number(part, name), f"{part}.{name}")
    surface.set("outputs:surface", "token", None)
    return path


def plain_material(doc: Document, path: str, shade: tuple[float, float, float], *sources: str) -> str:
    """Add an untextured material of one colour (sRGB) without friction; returns its path."""
    material = doc.add(path, "Material")
    material.connect("outputs:surface", "token", f"{path}/surface.outputs:surface")
    surface = doc.add(f"{path}/surface", "Shader")
    surface.set("info:id", "token", "UsdPreviewSurface", uniform=True)
    red, green, blue = (linear(c) for c in shade)
    surface.set("inputs:diffuseColor", "color3f", (red, green, blue), *sources)
    surface.set("inputs:roughness", "float", MATERIALS["plastic"].roughness)
    surface.set("inputs:metallic", "float", MATERIALS["plastic"].metallic)
    surface.set("outputs:surface", "token", None)
    return path


def _color(doc: Document, surface: Prim, path: str, part: str, values: Evaluator, there: tuple[str, ...]) -> None:
    """Set the colour, or an image that it tints."""
    red, green, blue = (linear(c) for c in rgb(values.text(part, "color")))
    image, repeats = _image(part, values)
    patterned = (f"{part}.material", f"{part}.image", *((f"{part}.repeats",) if values.has(part, "repeats") else ()))
    if image is None:
        surface.set("inputs:diffuseColor", "color3f", (red, green, blue), f"{part}.color", *patterned)
        return
    surface.connect("inputs:diffuseColor", "color3f", f"{path}/texture.outputs:rgb", f"{part}.color", *patterned)
    reader = doc.add(f"{path}/st", "Shader", (), (*patterned, *there))
    reader.set("info:id", "token", "UsdPrimvarReader_float2", uniform=True)
    reader.set("inputs:varname", "string", "st")
    reader.set("outputs:result", "float2", None)
    texture = doc.add(f"{path}/texture", "Shader", (), (*patterned, *there))
    texture.set("info:id", "token", "UsdUVTexture", uniform=True)
    texture.set("inputs:file", "asset", str(image), *patterned)
    texture.set("inputs:sourceColorSpace", "token", "sRGB")
    texture.set("inputs:wrapS", "token", "repeat")
    texture.set("inputs:wrapT", "token", "repeat")
    texture.set("inputs:scale", "float4", (red, green, blue, 1.0), f"{part}.color")
    st = f"{path}/st.outputs:result"
    if repeats:
        transform = doc.add(f"{path}/repeats", "Shader", (), (*patterned, *there))
        transform.set("info:id", "token", "UsdTransform2d", uniform=True)
        transform.connect("inputs:in", "float2", st)
        transform.set("inputs:scale", "float2", repeats, *patterned)
        transform.set("outputs:result", "float2", None)
        st = f"{path}/repeats.outputs:result"
    texture.connect("inputs:st", "float2", st, *patterned)
    texture.set("outputs:rgb", "float3", None)


def _image(part: str, values: Evaluator) -> tuple[Path | None, tuple[float, float] | None]:
    """Return the image on a surface and its repetitions per metre; None repetitions if it is laid out once."""
    if values.has(part, "image"):
        path = resolve_display_path(values.text(part, "image"))
        if not path.is_file():
            raise ImpossibleValue(f"there is no picture {path}", values.source_location(part, "image"))
        return path, values.pair(part, "repeats") if values.has(part, "repeats") else None
    material = MATERIALS[values.text(part, "material")]
    return material.path, (material.repeats, material.repeats)
