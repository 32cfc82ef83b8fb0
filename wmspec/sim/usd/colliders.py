"""What collides for a geometry: itself, or for a mesh what its `physics:approximation` says."""

from __future__ import annotations

import numpy as np
from pxr import Usd

from wmspec.core import space
from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Array, Motion, Pose
from wmspec.sim.scene.model.transform import apply, compose, conjugate, rotate
from wmspec.sim.scene.physics.decompose import CONCAVITY, pieces
from wmspec.sim.shapes import Box, Mesh, Shape, Sphere
from wmspec.sim.usd import meshes
from wmspec.sim.usd.prims import refuse, value
from wmspec.sim.usd.shapes import Placed
from wmspec.sim.usd.substitutions import STRICT, Notes
from wmspec.sim.usd.thin_shells import sheets

APART = ("convexDecomposition", "none", "meshSimplification")
WAYS = ("convexHull", "boundingCube", "boundingSphere", *APART)


_REMEDY = "set physics:approximation to convexDecomposition or convexHull"
DOWN = np.array([0.0, 0.0, -1.0])


def touched(prim: Usd.Prim, mesh: Mesh, motion: Motion, notes: Notes = STRICT) -> str:
    """How a mesh is touched: the approximation that it gets in the end, `none` being the surface that it is.

    Raises:
        StageError: if it is flat or not convex, and neither static nor meant to be touched as something else.
    """
    way = value(prim, "physics:approximation", "none")
    if way not in WAYS:
        refuse(prim, f"the approximation '{way}' is not supported", f"set it to one of: {', '.join(WAYS)}")
    flat = meshes.is_flat(mesh)
    if way == "boundingSphere" or (way == "boundingCube" and not flat):
        return str(way)
    if not flat and as_hull(prim, mesh):
        return "convexHull"
    if not flat and way == "convexDecomposition":
        return "convexDecomposition"
    if motion == "dynamic" and flat:
        refuse(prim, "a dynamic mesh that collides has no volume", "use a Cube, a Plane or a mesh that is not flat")
    if motion == "dynamic":
        reason = "a dynamic mesh that is not convex can't collide as it is"
        notes.instead(
            prim, reason, f"it collides as convex pieces, up to {100 * CONCAVITY:g} % of its size off", _REMEDY
        )
        return "convexDecomposition"
    return "none"


def collider(here: Placed, motion: Motion, down: Array = DOWN, notes: Notes = STRICT) -> tuple[tuple[Shape, Pose], ...]:
    """The shapes that collide for a geometry, in the body's frame, where `down` (3,) is the way down.

    Raises:
        StageError: if a mesh is flat and not static, or can't collide as it is meant to.
    """
    prim, mesh = here.prim, here.shape
    if not isinstance(mesh, Mesh):
        return tuple((piece, _placed(here.pose, at)) for piece, at in mesh.pieces())
    match touched(prim, mesh, motion, notes):
        case "boundingSphere" | "boundingCube" as way:
            return (_bounds(mesh, here.pose, way),)
        case "convexHull":
            return ((mesh, here.pose),)
        case "none":
            return _surface(here, mesh, motion, down)
    try:
        return tuple((piece, here.pose) for piece in pieces(mesh))
    except WmsError as error:
        refuse(prim, str(error), "or split it into convex meshes")


def _placed(pose: Pose, at: space.Pose) -> Pose:
    return pose if at == space.HERE else compose(pose, Pose(np.array(at.position), np.array(at.orientation)))


def _surface(here: Placed, mesh: Mesh, motion: Motion, down: Array) -> tuple[tuple[Shape, Pose], ...]:
    below = rotate(conjugate(here.pose.orientation), down) if motion == "static" else None
    try:
        return tuple((sheet, here.pose) for sheet in sheets(mesh, below))
    except WmsError as error:
        refuse(here.prim, f"it can't collide as it is: {error}", _REMEDY)


def as_hull(prim: Usd.Prim, mesh: Mesh) -> bool:
    """Whether the mesh is taken for its convex hull: it is meant so, or is convex."""
    way = value(prim, "physics:approximation", "none")
    return way == "convexHull" or (way in APART and meshes.is_convex(mesh))


def _bounds(mesh: Mesh, pose: Pose, way: str) -> tuple[Shape, Pose]:
    """The box along the prim's own axes around a mesh, or the sphere around the middle of that box."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    middle = (low + high) / 2
    at = Pose(apply(pose, middle), pose.orientation)
    if way == "boundingCube":
        x, y, z = ((high - low) / 2).tolist()
        return Box((x, y, z)), at
    return Sphere(float(np.linalg.norm(mesh.points - middle, axis=1).max())), at
