"""The geometries of USD that are shapes of the language."""

from __future__ import annotations

import numpy as np
from pxr import Usd

from wmspec.importers.model import Array, Shape
from wmspec.importers.usd_prims import Prims

#: Axis -> the turn that brings z there.
_TURNS = {
    "X": np.array(((0, 0, 1), (0, 1, 0), (-1, 0, 0)), float),
    "Y": np.array(((1, 0, 0), (0, 0, 1), (0, -1, 0)), float),
    "Z": np.eye(3),
}


def shape(prims: Prims, prim: Usd.Prim, frame: Array) -> Shape | None:
    """The shape of a prim in the frame of its body; None if it is not one, which was reported."""
    own, scale = prims.rigid(prim)
    place = np.linalg.inv(frame) @ own
    match str(prim.GetTypeName()):
        case "Cube":
            size = prims.number(prim, "size", 2.0, above=0.0)
            return Shape("box", tuple(size * scale), place)
        case "Sphere":
            radius = prims.number(prim, "radius", 1.0, above=0.0)
            _alike(prims, prim, scale, "a sphere keeps its form only if it is scaled equally")
            return Shape("sphere", (radius * scale[0],), place)
        case kind:
            return _round(prims, prim, kind, scale, place)


def _round(prims: Prims, prim: Usd.Prim, kind: str, scale: Array, place: Array) -> Shape:
    axis = str(prims.value(prim, "axis", "Z"))
    height = prims.number(prim, "height", 1.0 if kind == "Capsule" else 2.0, above=0.0)
    radius = prims.number(prim, "radius", 0.5 if kind == "Capsule" else 1.0, above=0.0)
    along = "XYZ".index(axis)
    _alike(prims, prim, np.delete(scale, along), "a round shape keeps its form only if it is scaled equally all around")
    across = float(np.delete(scale, along)[0])
    place = place.copy()
    place[:3, :3] = place[:3, :3] @ _TURNS[axis]
    if kind == "Capsule":
        _alike(prims, prim, scale, "a capsule keeps its form only if it is scaled equally")
        return Shape("capsule", (radius * across, height * float(scale[along]) + 2 * radius * across), place)
    sizes = (radius * across, height * float(scale[along]))
    return Shape("cylinder" if kind == "Cylinder" else "cone", sizes, place)


def _alike(prims: Prims, prim: Usd.Prim, scale: Array, why: str) -> None:
    if np.ptp(scale) > 1e-6 * scale.max():
        prims.faults.add(prims.where(prim), why, "scale it equally, or author its sizes")
