"""Every sort of mesh file gives the same mesh; a COLLADA file says its own unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.exchange.dae import export_collada

from wmspec.compile.layout.meshes import load
from wmspec.lang.check.tables.vocabulary import FILES


def wedge() -> trimesh.Trimesh:
    """A tetrahedron that looks different from every side."""
    return trimesh.Trimesh(
        [(0, 0, 0), (0.2, 0, 0), (0, 0.3, 0), (0, 0, 0.5)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    )


@pytest.mark.parametrize("ending", FILES["file"])
def test_the_same_mesh(tmp_path: Path, ending: str) -> None:
    if ending == ".gltf":
        for name, content in wedge().export(file_type="gltf").items():
            (tmp_path / name.replace("model.gltf", "a.gltf")).write_bytes(content)
    else:
        wedge().export(tmp_path / f"a{ending}")
    found = load(str(tmp_path / f"a{ending}"), (1.0, -2.0, 1.0), "hull", True)
    np.testing.assert_allclose(np.ptp(found.points, axis=0), (0.2, 0.6, 0.5), rtol=1e-6)
    assert found.volume == pytest.approx(0.2 * 0.6 * 0.5 / 6, rel=1e-6)
    made = trimesh.Trimesh(found.points, found.faces)
    assert made.is_watertight
    assert made.volume == pytest.approx(found.volume, rel=1e-6)


@pytest.mark.parametrize(("said", "metres"), [("", 1.0), ('<unit name="inch" meter="0.0254"/>', 0.0254)])
def test_a_collada_file_says_its_unit(tmp_path: Path, said: str, metres: float) -> None:
    """Of several meshes too; its axes are taken as they are."""
    text = export_collada([wedge(), wedge().apply_translation((1, 0, 0))]).decode()
    assert "<unit" not in text
    (tmp_path / "a.dae").write_text(text.replace("</asset>", f"{said}</asset>", 1))
    found = load(str(tmp_path / "a.dae"), 1.0, "hull", True)
    np.testing.assert_allclose(np.ptp(found.points, axis=0), np.array((1.2, 0.3, 0.5)) * metres, rtol=1e-6)
