"""Meshes: polygons to triangles in metres, counter-clockwise from outside, with texture coordinates per vertex."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdGeom, UsdShade

from wmspec.sim.scene.model import Array
from wmspec.sim.shapes import Mesh
from wmspec.sim.usd.prims import NOW, refuse, static_value, value

_Indices = NDArray[np.int32]
_CONVEX = 1e-5
_MAX_PAIRS, _PAIRS_PER_CHUNK = (
    2_000_000_000,
    4_000_000,
)  # pairs of point and face: limit in all, and per chunk
_COORDINATES = ("texCoord2f[]", "texCoord2d[]", "texCoord2h[]")


def mesh(prim: Usd.Prim, stretch: Gf.Matrix4d, faces: _Indices | None = None) -> Mesh:
    """Return the polygons `faces` (or all) of a Mesh prim with `stretch` baked in: the control cage, not subdivided.

    Unused points are dropped; a point with several texture coordinates becomes several points.

    Raises: StageError: if topology or texture coordinates are invalid.
    """
    points = np.asarray(value(prim, "points", []), np.float64).reshape(-1, 3)
    vertices = np.asarray(value(prim, "faceVertexIndices", []), np.int32)
    corners = _triangulate(prim, points, vertices, faces)
    linear = np.array(stretch, np.float64)[:3, :3]
    if (np.linalg.det(linear) < 0) != (value(prim, "orientation") == "leftHanded"):
        corners = corners[:, ::-1]
    used = corners.reshape(-1)
    st, per_point = _texture_coordinates(prim, vertices)
    if st is None or per_point:
        _, first, back = np.unique(vertices[used], return_index=True, return_inverse=True)
    else:
        keys = np.column_stack([vertices[used], st[used]])
        _, first, back = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    moved = np.ascontiguousarray(points[vertices[used[first]]] @ linear)
    return Mesh(moved, back.reshape(-1, 3).astype(np.int32), st[used[first]] if st is not None else None)


def parts(prim: Usd.Prim) -> list[tuple[Usd.Prim, _Indices]]:
    """Return the parts of a mesh by material: each subset with its polygons, and the prim with the rest."""
    subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets() if prim.GetTypeName() == "Mesh" else []
    if not subsets:
        return []
    named = [(s.GetPrim(), subset(s.GetPrim())) for s in subsets]
    count = len(value(prim, "faceVertexCounts", []))
    rest = np.setdiff1d(np.arange(count, dtype=np.int32), np.concatenate([faces for _, faces in named]))
    return [(prim, rest)] * bool(len(rest)) + named


def subset(prim: Usd.Prim) -> _Indices:
    """Return the polygons of a GeomSubset. Raises StageError if its elements are not faces."""
    if value(prim, "elementType", "face") != "face":
        refuse(prim, "its elements are not faces", "make its elementType face")
    return np.asarray(value(prim, "indices", []), np.int32)


def coordinates(prim: Usd.Prim) -> str:
    """Return the name of the texture coordinates: `st`, or the only ones; '' without any."""
    primvars = UsdGeom.PrimvarsAPI(prim)
    if (plain := primvars.FindPrimvarWithInheritance("st")) and plain.HasValue():
        return "st"
    names = [
        str(primvar.GetPrimvarName())
        for primvar in primvars.FindPrimvarsWithInheritance()
        if str(primvar.GetTypeName()) in _COORDINATES and primvar.HasValue()
    ]
    return names[0] if len(names) == 1 else ""


def is_convex(mesh: Mesh) -> bool:
    """Whether a mesh is closed and convex within 1e-5 of its size. Very large meshes return False."""
    import trimesh

    points, faces = mesh.points, mesh.faces
    if len(points) * len(faces) > _MAX_PAIRS or not trimesh.Trimesh(points, faces).is_watertight:
        return False
    near = _CONVEX * np.ptp(points, axis=0).max()
    for some in np.array_split(faces, 1 + len(points) * len(faces) // _PAIRS_PER_CHUNK):
        a, b, c = (points[some[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        if (normals @ points.T - (normals * a).sum(axis=1)[:, None]).max(initial=0.0) > near:
            return False
    return True


def is_flat(mesh: Mesh) -> bool:
    """Whether all points are coplanar, collinear or equal within 1e-6 of the size."""
    spread = np.linalg.svd(mesh.points - mesh.points.mean(axis=0), compute_uv=False)
    return len(spread) < 3 or not spread[-1] > 1e-6 * spread[0]


def _triangulate(prim: Usd.Prim, points: Array, vertices: _Indices, faces: _Indices | None) -> _Indices:
    """Return triangle fans (m, 3) of corners, as indices into faceVertexIndices."""
    counts = np.asarray(value(prim, "faceVertexCounts", []), np.int32)
    if counts.sum() != len(vertices) or (counts < 3).any() or not len(counts):
        refuse(prim, "its faceVertexCounts and faceVertexIndices do not fit", "author polygons of 3 or more points")
    if vertices.min() < 0 or vertices.max() >= len(points):
        refuse(prim, "its faceVertexIndices and points do not fit", "author indices in 0 .. len(points) - 1")
    expected = np.arange(len(counts)) if faces is None else faces
    expected = np.setdiff1d(expected, np.asarray(value(prim, "holeIndices", []), np.int32))
    if not len(expected) or expected.min() < 0 or expected.max() >= len(counts):
        refuse(prim, "it has no faces, or a subset names missing faces", "author face indices that exist")
    first, triangles = np.cumsum(counts) - counts, counts[expected] - 2
    fan = np.repeat(first[expected], triangles)
    step = 1 + np.arange(len(fan)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.column_stack([fan, fan + step, fan + step + 1]).astype(np.int32)


def _texture_coordinates(prim: Usd.Prim, vertices: _Indices) -> tuple[Array | None, bool]:
    """Return texture coordinates per corner (k, 2), or None, and whether each point has only one."""
    if not (name := coordinates(prim)):
        return None, False
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    for attribute in filter(None, (primvar.GetAttr(), primvar.GetIndicesAttr())):
        static_value(attribute)
    st = np.asarray(primvar.ComputeFlattened(NOW), np.float64).reshape(-1, 2)
    interpolation = primvar.GetInterpolation()
    per_point = interpolation in (UsdGeom.Tokens.vertex, UsdGeom.Tokens.varying) and len(st) > vertices.max()
    if not per_point and not (interpolation == UsdGeom.Tokens.faceVarying and len(st) == len(vertices)):
        reason = f"its primvars:{name} ({interpolation}, {len(st)} values) does not fit"
        refuse(prim, reason, "author it vertex or faceVarying")
    return (np.asarray(st[vertices]), True) if per_point else (st, False)
