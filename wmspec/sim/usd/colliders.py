"""Collision shapes of geoms: the geom itself, or for a mesh its `physics:approximation`."""

from __future__ import annotations

import numpy as np
from pxr import Usd

from wmspec.core import space
from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Array, Motion, Pose
from wmspec.sim.scene.model.transform import apply, compose, conjugate, rotate
from wmspec.sim.scene.physics.decompose import CONCAVITY, convex_parts
from wmspec.sim.shapes import Box, Mesh, Shape, Sphere
from wmspec.sim.usd import meshes
from wmspec.sim.usd.prims import refuse, value
from wmspec.sim.usd.shapes import PlacedShape
from wmspec.sim.usd.substitutions import STRICT, Substitutions

DECOMPOSED = ("convexDecomposition", "none", "meshSimplification")
APPROXIMATIONS = ("convexHull", "boundingCube", "boundingSphere", *DECOMPOSED)


_REMEDY = "set physics:approximation to convexDecomposition or convexHull"
DOWN = np.array([0.0, 0.0, -1.0])


def collision_approximation(prim: Usd.Prim, mesh: Mesh, motion: Motion, notes: Substitutions = STRICT) -> str:
    """Return the approximation of a mesh; `none` is its surface.

    Raises: StageError: if it is flat or non-convex, not static, and has no valid approximation.
    """
    way = value(prim, "physics:approximation", "none")
    if way not in APPROXIMATIONS:
        refuse(prim, f"the approximation '{way}' is not supported", f"set it to one of: {', '.join(APPROXIMATIONS)}")
    flat = meshes.is_flat(mesh)
    if way == "boundingSphere" or (way == "boundingCube" and not flat):
        return str(way)
    if not flat and collides_as_hull(prim, mesh):
        return "convexHull"
    if not flat and way == "convexDecomposition":
        return "convexDecomposition"
    if motion == "dynamic" and flat:
        refuse(prim, "a dynamic mesh that collides has no volume", "use a Cube, a Plane or a mesh that is not flat")
    if motion == "dynamic":
        reason = "a dynamic non-convex mesh cannot collide as its surface"
        notes.record(
            prim,
            reason,
            f"its convex decomposition is used, with an error of up to {100 * CONCAVITY:g} % of its size",
            _REMEDY,
        )
        return "convexDecomposition"
    return "none"


def collision_shapes(
    here: PlacedShape, motion: Motion, down: Array = DOWN, notes: Substitutions = STRICT
) -> tuple[tuple[Shape, Pose], ...]:
    """Return the collision shapes of a geom in the body frame, where `down` (3,) points down.

    Raises: StageError: if a mesh is flat and not static, or has an unsupported approximation.
    """
    prim, mesh = here.prim, here.shape
    if not isinstance(mesh, Mesh):
        return tuple((piece, _placed(here.pose, at)) for piece, at in mesh.pieces)
    match collision_approximation(prim, mesh, motion, notes):
        case "boundingSphere" | "boundingCube" as way:
            return (_bounds(mesh, here.pose, way),)
        case "convexHull":
            return ((mesh, here.pose),)
        case "none":
            return _surface(here, mesh, motion, down)
    try:
        return tuple((piece, here.pose) for piece in convex_parts(mesh))
    except WmsError as error:
        refuse(prim, str(error), "or split it into convex meshes")


def _placed(pose: Pose, at: space.Pose) -> Pose:
    return pose if at == space.IDENTITY else compose(pose, Pose(np.array(at.position), np.array(at.orientation)))


def _surface(here: PlacedShape, mesh: Mesh, motion: Motion, down: Array) -> tuple[tuple[Shape, Pose], ...]:
    from wmspec.sim.usd.thin_shells import thin_shells  # its libraries take a second to import

    below = rotate(conjugate(here.pose.orientation), down) if motion == "static" else None
    try:
        return tuple((sheet, here.pose) for sheet in thin_shells(mesh, below))
    except WmsError as error:
        refuse(here.prim, f"its surface cannot collide: {error}", _REMEDY)


def collides_as_hull(prim: Usd.Prim, mesh: Mesh) -> bool:
    """Whether a mesh collides as its convex hull: by its approximation, or because it is convex."""
    way = value(prim, "physics:approximation", "none")
    return way == "convexHull" or (way in DECOMPOSED and meshes.is_convex(mesh))


def _bounds(mesh: Mesh, pose: Pose, way: str) -> tuple[Shape, Pose]:
    """Return the bounding box of a mesh along the prim's axes, or the sphere around its centre."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    middle = (low + high) / 2
    at = Pose(apply(pose, middle), pose.orientation)
    if way == "boundingCube":
        x, y, z = ((high - low) / 2).tolist()
        return Box((x, y, z)), at
    return Sphere(float(np.linalg.norm(mesh.points - middle, axis=1).max())), at
