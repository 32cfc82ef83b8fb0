"""The geometries of a body of USD as shapes: which are drawn and touched, and how meshes are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from wmspec.importers import triangles, usd_looks, usd_meshes, usd_shapes
from wmspec.importers.model import Array, Doubt, Fault, Look, Shape, doubts
from wmspec.importers.triangles import Triangles
from wmspec.importers.usd_prims import Prims

#: What is said by `physics:approximation`, as a word of the language.
_WAYS = {"convexHull": "hull", "convexDecomposition": "pieces", "boundingCube": "bounds"}
#: What touches as it is, which can be honoured of what is convex or never moves.
_EXACT = ("none", "meshSimplification")

#: How a mesh is touched, as a word of the language, and why it cannot be as its file says.
_Way = tuple[str, tuple[Doubt, ...]]


def is_solid(prims: Prims, prim: Usd.Prim) -> bool:
    """Whether a geometry can be touched."""
    return prim.HasAPI(UsdPhysics.CollisionAPI) and bool(prims.value(prim, "physics:collisionEnabled", True))


def is_drawn(prim: Usd.Prim) -> bool:
    """Whether a geometry can be seen."""
    seen = UsdGeom.Imageable(prim)
    return bool(seen.ComputeVisibility() != "invisible" and seen.ComputePurpose() in ("default", "render"))


def shapes(prims: Prims, prim: Usd.Prim, frame: Array, *, solid: bool, still: bool) -> tuple[Shape, ...]:
    """The shapes of a geometry in the frame of its body, which is `still` if it never moves. Faults are reported."""
    drawn = is_drawn(prim)
    if not (solid or drawn):
        return ()
    if prim.GetTypeName() == "Mesh":
        found = usd_meshes.mesh(prims, prim)
        touched = _touched(prims, prim, found, still) if found and solid else None
        return _meshes(prims, prim, frame, found, touched) if found else ()
    return _plain(prims, prim, frame, solid=solid, drawn=drawn)


def bare(prims: Prims, prim: Usd.Prim, frame: Array) -> tuple[Shape, ...]:
    """The shapes of a geometry where nothing says what is touched: all that is drawn, but for sheets."""
    if not is_drawn(prim):
        return ()
    if prim.GetTypeName() != "Mesh":
        return _plain(prims, prim, frame, solid=True, drawn=True)
    found = usd_meshes.mesh(prims, prim)
    if found is None:
        return ()
    return _meshes(prims, prim, frame, found, None if triangles.is_flat(found) else ("hull", ()))


def _plain(prims: Prims, prim: Usd.Prim, frame: Array, *, solid: bool, drawn: bool) -> tuple[Shape, ...]:
    """A geometry that is a shape of the language."""
    shape = usd_shapes.shape(prims, prim, frame)
    if shape is None:
        return ()
    look = usd_looks.look(prims, prim, None) if drawn else Look()
    return (replace(shape, solid=solid, drawn=drawn, look=look),)


def _meshes(prims: Prims, prim: Usd.Prim, frame: Array, found: Triangles, touched: _Way | None) -> tuple[Shape, ...]:
    """A mesh; if parts of it look different, each of these, and the whole if it can be touched."""
    drawn, place = is_drawn(prim), np.linalg.inv(frame) @ prims.rigid(prim, skewed=True)[0]
    way, why = touched or ("hull", ())
    file, solid = f"{prims.shown}#{prim.GetPath()}", touched is not None
    whole = Shape("mesh", (), place, file, solid=solid, drawn=drawn, collision=way, doubts=why)
    subsets = _subsets(prims, prim) if drawn else []
    if not subsets:
        return (replace(whole, look=usd_looks.look(prims, prim, found)) if drawn else whole,)
    seen = replace(whole, solid=False, doubts=())
    parts = [
        replace(seen, file=f"{prims.shown}#{some.GetPath()}", look=usd_looks.look(prims, some, found))
        for some in subsets
    ]
    return (*parts, replace(whole, drawn=False)) if solid else tuple(parts)


def _subsets(prims: Prims, prim: Usd.Prim) -> list[Usd.Prim]:
    """The polygons of a mesh that have materials of their own, which must be all of them, each once."""
    found = [subset.GetPrim() for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()]
    if not found:
        return []
    count = len(prims.value(prim, "faceVertexCounts", ()))
    faces = np.concatenate([usd_meshes.indices(prims, subset, "indices") for subset in found])
    if not np.array_equal(np.sort(faces), np.arange(count)):
        what = "its material subsets are not each of its faces once"
        prims.faults.add(prims.where(prim), what, "give the others a subset too, or remove the subsets")
    return found


def _touched(prims: Prims, prim: Usd.Prim, mesh: Triangles, still: bool) -> _Way:
    """How a mesh is touched, as a word of the language, and why it cannot be as the file says."""
    if triangles.is_flat(mesh):
        what = "what is touched is flat"
        prims.faults.add(prims.where(prim), what, "make it a Cube, or give the mesh some thickness")
        return "hull", ()
    way = str(prims.value(prim, "physics:approximation", "none"))
    if way in _WAYS:
        return _WAYS[way], ()
    convex = way in _EXACT and triangles.is_convex(mesh)
    if convex or (still and way in _EXACT):
        return "hull" if convex else "pieces", ()
    what = f"physics:approximation = {way[:40]} is not supported"
    if way in _EXACT:
        what = "a mesh that can move and is not convex cannot be touched as it is"
    remedy = "author physics:approximation = convexHull or convexDecomposition"
    return "hull", doubts([Fault(prims.where(prim), what, remedy)], ("collision",))
