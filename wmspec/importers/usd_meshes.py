"""Mesh prims of USD: polygons to triangles in metres with z up, each side out, in the prim's own frame.

What is drawn is the control cage, not subdivided.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom

from wmspec.diagnostics import suggestion
from wmspec.importers.model import Array, Broken, Fault, Faults
from wmspec.importers.triangles import Triangles
from wmspec.importers.usd_open import opened
from wmspec.importers.usd_prims import Prims

Indices = NDArray[np.int64]

#: The most points of a mesh and corners of its faces.
MOST = 1_000_000


def triangles(path: Path, folder: Path | None, shown: str, prim: str) -> Triangles | tuple[Fault, ...]:
    """The mesh at a prim of a USD file, or the polygons of a GeomSubset; or else all that is wrong with it.

    It is seen from the prim's rigid frame: what the transforms to it scale, mirror or skew is in its points. `shown` is
    what the file is called, and all its layers are below `folder`, if one is given.
    """
    faults = Faults()
    made = None
    with suppress(Broken), opened(path, folder, shown, faults) as prims:
        at = prims.stage.GetPrimAtPath(prim) if Sdf.Path.IsValidPathString(prim) else None
        if at and is_mesh(at):
            made = mesh(prims, at)
        else:
            _none(prims, prim)
    return tuple(faults.found) or made or ()


def is_mesh(prim: Usd.Prim) -> bool:
    """Whether this is a mesh, or some polygons of one."""
    kind = prim.GetParent() if prim.GetTypeName() == "GeomSubset" else prim
    return bool(prim.IsDefined() and not prim.IsAbstract() and kind.GetTypeName() == "Mesh")


def _none(prims: Prims, prim: str) -> None:
    every = Usd.PrimRange(prims.stage.GetPseudoRoot(), Usd.TraverseInstanceProxies())
    known = [str(p.GetPath()) for p in every if p.GetTypeName() == "Mesh"]
    prims.faults.add(prims.shown, f"there is no mesh `{prim[:80]}`", suggestion(prim, known) or "it has no meshes")


def mesh(prims: Prims, prim: Usd.Prim) -> Triangles | None:
    """The triangles of a prim; None if they are broken, which was reported.

    Points that no face uses are dropped, and a point with several texture coordinates becomes several.
    """
    of = prim.GetParent() if prim.GetTypeName() == "GeomSubset" else prim
    points = np.asarray(prims.value(of, "points", ()), float).reshape(-1, 3)
    counts, corners = (indices(prims, of, name) for name in ("faceVertexCounts", "faceVertexIndices"))
    if wrong := _broken(points, counts, corners):
        prims.faults.add(prims.where(of), *wrong)
        return None
    shown = _shown(prims, of, prim, len(counts))
    st = _coordinates(prims, of, corners)
    if shown is None or (st is None and coordinates(of)):
        return None
    used = _fans(counts)[np.repeat(shown, counts - 2)]
    linear = (np.linalg.inv(prims.rigid(of, skewed=True)[0]) @ prims.world(of))[:3, :3]
    if (np.linalg.det(linear) < 0) != (prims.value(of, "orientation", "rightHanded") == "leftHanded"):
        used = used[:, ::-1]
    return _gathered(points @ linear.T, corners[used.reshape(-1)], None if st is None else st[used.reshape(-1)])


def coordinates(prim: Usd.Prim) -> str:
    """The name of the texture coordinates of a mesh: `st`, or else the only ones it has; empty if there are none."""
    found = [
        primvar.GetPrimvarName()
        for primvar in UsdGeom.PrimvarsAPI(prim).FindPrimvarsWithInheritance()
        if primvar.HasValue() and str(primvar.GetTypeName()) in ("texCoord2f[]", "texCoord2d[]", "texCoord2h[]")
    ]
    plain = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("st")
    if "st" in found or (plain and plain.HasValue()):
        return "st"
    return str(found[0]) if len(found) == 1 else ""


def indices(prims: Prims, prim: Usd.Prim, name: str) -> Indices:
    """The indices that an attribute says."""
    return np.asarray(prims.value(prim, name, ()), np.int64).reshape(-1)


def _broken(points: Array, counts: Indices, corners: Indices) -> tuple[str, str] | None:
    """What is wrong with the topology of a mesh, and what to do."""
    if max(len(points), len(corners)) > MOST:
        return f"it has more than {MOST:,} points or corners", "make it simpler"
    if not len(counts) or counts.min() < 3 or counts.sum() != len(corners):
        return "its faceVertexCounts and faceVertexIndices do not fit", "author polygons of 3 or more points"
    if corners.min() < 0 or corners.max() >= len(points):
        return "its faceVertexIndices and points do not fit", "author indices of points that exist"
    if not np.isfinite(points).all():
        return "its points are not finite", "correct them"
    return None


def _shown(prims: Prims, of: Usd.Prim, prim: Usd.Prim, count: int) -> NDArray[np.bool_] | None:
    """Which of its polygons are meant: all but the holes, or those of a subset."""
    chosen = indices(prims, prim, "indices") if prim != of else np.arange(count)
    if prim != of and prims.value(prim, "elementType", "face") != "face":
        prims.faults.add(prims.where(prim), "it is a subset of other things than faces", "make its elementType face")
    holes = indices(prims, of, "holeIndices")
    shown = np.zeros(count, bool)
    for part, kept in ((chosen, True), (holes, False)):
        if len(part) and not (part.min() >= 0 and part.max() < count):
            prims.faults.add(prims.where(prim), "it names faces that there are not", "correct its indices")
            return None
        shown[part] = kept
    if not shown.any():
        prims.faults.add(prims.where(prim), "it has no faces", "remove it, or give it some")
        return None
    return shown


def _coordinates(prims: Prims, prim: Usd.Prim, corners: Indices) -> Array | None:
    """The texture coordinates of each corner (k, 2); None if there are none, or they are broken, which is reported."""
    name = coordinates(prim)
    if not name:
        return None
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    way, flat = primvar.GetInterpolation(), primvar.ComputeFlattened()
    found: Any = np.asarray(flat if flat is not None else (), float)
    if found.ndim == 2 and found.shape[1] == 2 and np.isfinite(found).all():
        if way == UsdGeom.Tokens.faceVarying and len(found) == len(corners):
            return np.asarray(found)
        if way in (UsdGeom.Tokens.vertex, UsdGeom.Tokens.varying) and len(found) > corners.max():
            return np.asarray(found[corners])
    what = f"its primvars:{name} ({way}, {len(found)} values) do not fit its faces"
    prims.faults.add(prims.where(prim), what, "author them vertex or faceVarying, or remove them")
    return None


def _fans(counts: Indices) -> Indices:
    """Triangles (m, 3) of corners: each polygon as a fan around its first."""
    many = counts - 2
    first = np.repeat(np.cumsum(counts) - counts, many)
    step = np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many) + 1
    return np.stack([first, first + step, first + step + 1], axis=1)


def _gathered(points: Array, corners: Indices, st: Array | None) -> Triangles:
    """Triangles of corners, one after the other, with each point of the same coordinates once."""
    if st is None:
        kept, back = np.unique(corners, return_inverse=True)
        return Triangles(points[kept], back.reshape(-1, 3), None)
    rows, back = np.unique(np.hstack([corners[:, None], st]), axis=0, return_inverse=True)
    return Triangles(points[rows[:, 0].astype(np.int64)], back.reshape(-1, 3), rows[:, 1:])
