"""Pictures on meshes of USD: a UsdUVTexture that reads a file beside the asset at the mesh's texture coordinates."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdShade

from wmspec.check.vocabulary import FILES
from wmspec.importers.model import Array
from wmspec.importers.triangles import Triangles
from wmspec.importers.usd_meshes import coordinates
from wmspec.importers.usd_plugs import source, value
from wmspec.importers.usd_prims import Prims

#: What a UsdTransform2d must leave as it is.
_PLAIN: dict[str, Any] = {"rotation": 0.0, "translation": (0.0, 0.0), "scale": (1.0, 1.0)}


def texture(prims: Prims, prim: Usd.Prim, surface: UsdShade.Shader, mesh: Triangles | None) -> tuple[str, Array]:
    """The file of a picture that is a surface's colour, seen from the spec's folder, and the linear colour of its tint.

    Whatever else it does goes to the faults.
    """
    white = np.ones(3)
    shader, output = source(surface, "diffuseColor")
    if shader is None or shader.GetIdAttr().Get() != "UsdUVTexture" or output != "rgb":
        what = "its colour is made by other shaders than the rgb of a UsdUVTexture"
        prims.faults.add(prims.where(prim), what, "author a value")
        return "", white
    if mesh is None or mesh.st is None:
        what = "pictures are supported on meshes with texture coordinates only"
        prims.faults.add(prims.where(prim), what, "give it some")
        return "", white
    _laid(prims, prim, shader, mesh.st)
    return _file(prims, shader), _tint(prims, shader)


def _laid(prims: Prims, prim: Usd.Prim, shader: UsdShade.Shader, st: Array) -> None:
    """Complain about a picture that does not lie as its mesh's coordinates say, repeated beyond its edges."""
    where = prims.where(shader.GetPrim())
    ways = {value(shader, wrap) for wrap in ("wrapS", "wrapT")}
    if ways - {None, "repeat", "useMetadata"} and (st.min() < -1e-6 or st.max() > 1 + 1e-6):
        prims.faults.add(
            where, "its picture does not repeat, and the mesh goes beyond it", "make wrapS and wrapT repeat"
        )
    mesh = prim.GetParent() if prim.GetTypeName() == "GeomSubset" else prim
    reader, _ = source(shader, "st")
    if reader is not None and reader.GetIdAttr().Get() == "UsdTransform2d":
        moved = [n for n, plain in _PLAIN.items() if not np.allclose(value(reader, n, plain), plain)]
        if moved:
            what = "it moves, turns or scales texture coordinates"
            prims.faults.add(prims.where(reader.GetPrim()), what, "bake that into them")
        reader, _ = source(reader, "in")
    name = value(reader, "varname") if reader is not None else None
    if reader is not None and (reader.GetIdAttr().Get() != "UsdPrimvarReader_float2" or name != coordinates(mesh)):
        what = f"its picture lies by `{name}`, and the texture coordinates of the mesh are `{coordinates(mesh)}`"
        prims.faults.add(where, what, "let a UsdPrimvarReader_float2 read these")


def _file(prims: Prims, shader: UsdShade.Shader) -> str:
    where = prims.where(shader.GetPrim())
    if value(shader, "sourceColorSpace") == "raw":
        prims.faults.add(where, "its picture is not in sRGB", "make sourceColorSpace sRGB")
    found = value(shader, "file")
    named = str(found.path) if isinstance(found, Sdf.AssetPath) else ""
    if PurePosixPath(named).suffix.lower() not in FILES["image"]:
        prims.faults.add(
            where, f"`{named[:80]}` is no picture that can be read", f"make it {', '.join(FILES['image'])}"
        )
        return ""
    path = Path(found.resolvedPath).resolve() if found.resolvedPath else Path("/")
    home = (prims.folder or Path()).resolve()
    if not (path.is_file() and path.is_relative_to(home)):
        what = f"there is no picture `{named[:80]}` below the spec's folder"
        prims.faults.add(where, what, "put it there, outside any package")
        return ""
    return path.relative_to(home).as_posix()


def _tint(prims: Prims, shader: UsdShade.Shader) -> Array:
    """What the picture is multiplied by, a linear colour."""
    scale, bias = (np.asarray(value(shader, n, p), float) for n, p in (("scale", (1,) * 4), ("bias", (0,) * 4)))
    if bias.any() or not ((scale[:3] >= 0) & (scale[:3] <= 1)).all():
        what = "its picture is made lighter"
        prims.faults.add(prims.where(shader.GetPrim()), what, "author a scale of 0 to 1 and no bias")
        return np.ones(3)
    return np.asarray(scale[:3])
