"""Closed shells of triangle meshes, and the solid that they enclose together.

Shells may touch, overlap or contain one another; space that several of them enclose counts once. An inward-facing shell
inside another is a cavity. Unions are those of Manifold (Lalish, https://github.com/elalish/manifold).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import trimesh
from manifold3d import Manifold, Mesh64, OpType
from numpy.typing import NDArray

from wmspec.sim.scene.model import Array
from wmspec.sim.shapes import Mesh

Faces = NDArray[np.integer]

#: Relative overlap of two bounding boxes below which shells count as apart.
_APART = 1e-9


def enclosed_solid(mesh: Mesh) -> trimesh.Trimesh | None:
    """Return the solid that the shells of a mesh enclose, or None if a shell is open."""
    whole = trimesh.Trimesh(mesh.points, mesh.faces)
    points, faces = np.asarray(whole.vertices, np.float64), np.asarray(whole.faces)
    groups = _shells(points, faces) if len(faces) else None
    if groups is None:
        return None
    shells = [trimesh.Trimesh(points, faces[group], process=False) for group in groups]
    shells = [shell for shell in shells if abs(shell.volume) > 0]
    solids = _with_cavities(shells)
    if not any(_overlap(a.bounds, b.bounds) for a, b in combinations(solids, 2)):
        return trimesh.util.concatenate(solids) if solids else None
    return _union(solids)


def _shells(points: Array, faces: Faces) -> list[NDArray[np.intp]] | None:
    """Return the face indices of each closed shell; None if an edge has no partner."""
    starts, ends = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    forward = starts < ends
    edges = np.stack([np.minimum(starts, ends), np.maximum(starts, ends)], axis=1)
    _, edge, counts = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)
    if (np.bincount(edge, weights=np.where(forward, 1, -1)) != 0).any():
        return None
    order = np.argsort(edge, kind="stable")
    groups = np.split(order, np.cumsum(counts)[:-1])
    simple = counts == 2
    pairs = np.array([group for group, two in zip(groups, simple, strict=True) if two]).reshape(-1, 2) // 3
    patch = trimesh.graph.connected_component_labels(pairs, node_count=len(faces))
    crowded = [_paired(points, faces, g, forward, patch) for g, two in zip(groups, simple, strict=True) if not two]
    pairs = np.concatenate([pairs, *crowded])
    labels = trimesh.graph.connected_component_labels(pairs, node_count=len(faces))
    return [np.flatnonzero(labels == label) for label in range(labels.max() + 1)]


def _paired(
    points: Array, faces: Faces, sides: NDArray[np.intp], forward: NDArray[np.bool_], patch: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Return pairs of faces (n, 2) around an edge of more than two: each with the next across its interior.

    `sides` index the edges of the faces in order (face * 3 + corner). Of faces that coincide, the one of the same
    `patch` is next: otherwise two shells with a common edge would count as one that overlaps itself.
    """
    face, corner = sides // 3, sides % 3
    a, b = (points[faces[face, (corner + k) % 3]] for k in (0, 1))
    axis = (b - a)[forward[sides]][0]
    axis /= np.linalg.norm(axis)
    across = points[faces[face, (corner + 2) % 3]] - a
    across -= np.outer(across @ axis, axis)
    x = across[0] / max(np.linalg.norm(across[0]), 1e-300)
    angle = np.arctan2(across @ np.cross(axis, x), across @ x)
    pairs = []
    backward = [i for i in range(len(sides)) if not forward[sides[i]]]
    for i in np.flatnonzero(forward[sides]):  # its interior lies clockwise about the edge
        turn = [(angle[i] - angle[j]) % (2 * np.pi) or 2 * np.pi for j in backward]
        turn = [2 * np.pi if t < 1e-9 else t for t in turn]
        other_patch = [patch[face[i]] != patch[face[j]] for j in backward]
        nearest = np.isclose(turn, min(turn), rtol=0, atol=1e-9)
        partner = backward.pop(min(np.flatnonzero(nearest), key=lambda k: other_patch[k]))
        pairs.append((face[i], face[partner]))
    return np.array(pairs)


def _with_cavities(shells: Sequence[trimesh.Trimesh]) -> list[trimesh.Trimesh]:
    """Return the outer shells with their cavities; an inward-facing shell outside all others is turned over."""
    outer = [shell for shell in shells if shell.volume > 0]
    solids = [[shell] for shell in outer]
    for shell in shells:
        if shell.volume > 0:
            continue
        around = [i for i, one in enumerate(outer) if _within(shell.bounds, one.bounds)]
        if around:
            solids[min(around, key=lambda i: outer[i].volume)].append(shell)
        else:
            shell.invert()
            solids.append([shell])
    return [solid[0] if len(solid) == 1 else trimesh.util.concatenate(solid) for solid in solids]


def _within(inner: Array, outer: Array) -> bool:
    return bool((inner[0] >= outer[0]).all() and (inner[1] <= outer[1]).all())


def _overlap(a: Array, b: Array) -> bool:
    """Whether two bounding boxes (2, 3) share a volume."""
    common = np.minimum(a[1], b[1]) - np.maximum(a[0], b[0])
    return bool((common > _APART * np.ptp(np.concatenate([a, b]), axis=0)).all())


def _union(solids: Sequence[trimesh.Trimesh]) -> trimesh.Trimesh | None:
    parts = [Manifold(Mesh64(np.asarray(s.vertices, np.float64), np.asarray(s.faces, np.uint64))) for s in solids]
    if any(part.is_empty() for part in parts):
        return None
    made = Manifold.batch_boolean(parts, OpType.Add).to_mesh64()
    return trimesh.Trimesh(made.vert_properties[:, :3], made.tri_verts.astype(np.int64), process=False)
