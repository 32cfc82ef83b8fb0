"""Convex decomposition of meshes, computed once so that every engine collides the same parts.

The parts are those of CoACD (Wei et al., "Approximate Convex Decomposition for 3D Meshes with Collision-Aware
Concavity and Tree Search", ACM Transactions on Graphics 41, 2022), with a fixed seed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.core.native_output import silence
from wmspec.sim.scene.model import Array, Inertia, Pose
from wmspec.sim.scene.model.transform import apply, multiply
from wmspec.sim.scene.physics.inertia import inertia, principal
from wmspec.sim.shapes import Mesh

CONCAVITY = 0.05  # largest concavity of a part, relative to the size of the mesh
SEARCH: dict[str, Any] = {"mcts_nodes": 10, "mcts_iterations": 30, "resolution": 500, "max_ch_vertex": 128, "seed": 0}


def convex_parts(mesh: Mesh) -> tuple[Mesh, ...]:
    """Return the convex parts of a mesh; equal meshes give equal parts. Raises WmsError if CoACD is missing."""
    points, faces = np.asarray(mesh.points, np.float64), np.asarray(mesh.faces, np.int32)
    return _pieces(points.tobytes(), faces.tobytes())


@lru_cache(maxsize=256)
def _pieces(points: bytes, faces: bytes) -> tuple[Mesh, ...]:
    try:
        import coacd
    except ImportError as error:
        raise WmsError(
            f"decomposing a non-convex mesh needs CoACD ({error}); install it with "
            "`pip install 'wmspec[meshes]'`, or set physics:approximation to convexHull"
        ) from None
    solid = coacd.Mesh(np.frombuffer(points).reshape(-1, 3), np.frombuffer(faces, np.int32).reshape(-1, 3))
    with silence():
        coacd.set_log_level("error")
        parts = coacd.run_coacd(solid, threshold=CONCAVITY, **SEARCH)
    return tuple(_hull(np.asarray(corners, np.float64)) for corners, _ in parts)


def _hull(corners: Array) -> Mesh:
    import trimesh

    hull = trimesh.convex.convex_hull(corners)
    return Mesh(np.asarray(hull.vertices, np.float64), np.asarray(hull.faces, np.int32))


def mesh_mass_properties(mesh: Mesh, pose: Pose, taken_apart: Callable[[], Sequence[Mesh]]) -> tuple[float, Inertia]:
    """Return the volume (m³) of a mesh and its mass properties for 1 kg, transformed by `pose`.

    Closed shells count as the solid that they enclose together; otherwise the convex parts of the mesh count, or its
    hull if there are none.
    """
    from wmspec.sim.scene.physics.shells import enclosed_solid  # its libraries take a second to import

    solid = enclosed_solid(mesh)
    if solid is None:
        parts = taken_apart() or [mesh]
        sizes = [part.volume for part in parts]
        return sum(sizes), inertia([(part, pose, size / sum(sizes)) for part, size in zip(parts, sizes, strict=True)])
    axes, moments = principal(np.asarray(solid.moment_inertia, float) / float(solid.mass))
    center = apply(pose, np.asarray(solid.center_mass, float))
    return float(solid.volume), Inertia(1.0, center, multiply(pose.orientation, axes), moments)
