"""Every sort of mesh file gives the same mesh; a COLLADA file says its own unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.exchange.dae import export_collada

from tests.assets.specs import named, scene, spec
from wmspec.compile.layout.meshes import load
from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Report
from wmspec.lang.check.tables.vocabulary import FILES
from wmspec.sim.shapes import Mesh


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
def test_collada_file_has_a_unit(tmp_path: Path, said: str, metres: float) -> None:
    """Of several meshes too; its axes are taken as they are."""
    text = export_collada([wedge(), wedge().apply_translation((1, 0, 0))]).decode()
    assert "<unit" not in text
    (tmp_path / "a.dae").write_text(text.replace("</asset>", f"{said}</asset>", 1))
    found = load(str(tmp_path / "a.dae"), 1.0, "hull", True)
    np.testing.assert_allclose(np.ptp(found.points, axis=0), np.array((1.2, 0.3, 0.5)) * metres, rtol=1e-6)


@pytest.mark.parametrize(("up", "size"), [("z", (0.2, 0.3, 0.5)), ("y", (0.2, 0.5, 0.3)), ("x", (0.5, 0.3, 0.2))])
def test_units_and_up_axis_of_a_mesh(tmp_path: Path, up: str, size: tuple[float, float, float]) -> None:
    wedge().export(tmp_path / "a.stl")
    found = load(str(tmp_path / "a.stl"), 1.0, "hull", True, metres=0.001, up=up)
    np.testing.assert_allclose(np.ptp(found.points, axis=0), np.array(size) * 1e-3, rtol=1e-6)
    top = found.points[np.argmax(found.points[:, 2])]
    np.testing.assert_allclose(top, (0, 0, 1e-3 * size[2]), atol=1e-9)
    assert trimesh.Trimesh(found.points, found.faces).volume > 0


@pytest.mark.parametrize(
    ("ending", "said", "size"),
    [
        ("glb", "", (0.2, 0.5, 0.3)),
        ("glb", "up: z", (0.2, 0.3, 0.5)),
        ("stl", "", (0.2, 0.3, 0.5)),
        ("stl", "units: cm  up: y", (0.002, 0.005, 0.003)),
        ("obj", "units: inch  scale: (1, 1, 2)", (0.00508, 0.00762, 0.0254)),
    ],
)
def test_a_gltf_is_upright_by_its_standard(tmp_path: Path, ending: str, said: str, size: tuple[float, ...]) -> None:
    wedge().export(tmp_path / f"a.{ending}")
    found = scene(spec(f'object it {{ file: "a.{ending}"  at: (0, 0, 1 m)  {said} }}', tmp_path))
    (geom,) = named(found, "it").geoms
    assert isinstance(geom.shape, Mesh)
    np.testing.assert_allclose(np.ptp(geom.shape.points, axis=0), np.array(size), rtol=1e-6)


def test_a_mesh_in_millimetres_is_found_by_its_size(tmp_path: Path) -> None:
    mesh = wedge()
    mesh.apply_scale(1000)
    mesh.export(tmp_path / "a.stl")
    for said, warned in (("", True), ("units: mm", False)):
        task = spec(f'object it {{ file: "a.stl"  at: (0, 0, 1 m)  {said} }}', tmp_path)
        report = Report()
        dry_run(task, report)
        texts = [d.message for d in report.diagnostics if d.code == "WMS606"]
        assert bool(texts) == warned
        assert not warned or "the mesh of `it` is 500 m long and weighs" in texts[0]
