"""Solids of meshes with several shells: space that they share counts once."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import example, given
from hypothesis import strategies as st

from wmspec.sim.scene.physics.shells import enclosed_solid
from wmspec.sim.shapes import Mesh

#: Boxes on a grid of tenths of a metre: lowest corner and edges.
CORNER, EDGES = st.integers(0, 6), st.integers(1, 5)
BOXES = st.lists(st.tuples(st.tuples(CORNER, CORNER, CORNER), st.tuples(EDGES, EDGES, EDGES)), min_size=1, max_size=5)


def joined(*parts: Any, soup: bool = False) -> Mesh:
    """One mesh of several; as `soup`, no two triangles share a point, as in STL."""
    whole = trimesh.util.concatenate(parts)
    points, faces = np.asarray(whole.vertices), np.asarray(whole.faces)
    if soup:
        points, faces = points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    return Mesh(points, faces.astype(np.int32))


def box(edges: tuple[float, float, float], corner: tuple[float, float, float] = (0, 0, 0)) -> Any:
    made = trimesh.creation.box(edges)
    made.apply_translation(np.array(corner) + np.array(edges) / 2)
    return made


def volume(mesh: Mesh) -> float | None:
    solid = enclosed_solid(mesh)
    return None if solid is None else float(solid.volume)


@example(boxes=[((0, 3, 0), (2, 4, 1)), ((0, 3, 0), (1, 1, 1))], soup=False)  # an edge in common
@given(boxes=BOXES, soup=st.booleans())
def test_boxes_that_touch_or_overlap_have_the_volume_of_their_cells(boxes: Any, soup: bool) -> None:
    cells = {c for low, size in boxes for c in product(*(range(a, a + n) for a, n in zip(low, size, strict=True)))}
    parts = [box(tuple(0.1 * n for n in size), tuple(0.1 * a for a in low)) for low, size in boxes]
    assert volume(joined(*parts, soup=soup)) == pytest.approx(len(cells) * 1e-3, rel=1e-6)


def test_an_inward_shell_is_a_cavity_and_a_body_in_it_counts() -> None:
    cavity, core = box((0.5, 0.5, 0.5), (0.25, 0.25, 0.25)), box((0.2, 0.2, 0.2), (0.4, 0.4, 0.4))
    cavity.invert()
    assert volume(joined(box((1, 1, 1)), cavity)) == pytest.approx(0.875)
    assert volume(joined(box((1, 1, 1)), cavity, core)) == pytest.approx(0.883)
    assert volume(joined(cavity)) == pytest.approx(0.125)


def test_the_centre_is_that_of_the_union() -> None:
    solid = enclosed_solid(joined(box((1, 1, 1)), box((1, 1, 1), (0.5, 0, 0))))
    assert solid is not None
    np.testing.assert_allclose(solid.center_mass, (0.75, 0.5, 0.5), atol=1e-9)


def test_an_open_shell_encloses_nothing() -> None:
    whole = box((1, 1, 1))
    assert volume(Mesh(np.asarray(whole.vertices), np.asarray(whole.faces[1:], np.int32))) is None
