"""USD files as wholes: without physics, of several layers and instances, changed, too large."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.assets.specs import checked, named, scene, spec
from tests.assets.test_usd_meshes import ANGLE, QUADS, body, quads, solid, ways, written
from tests.work import calls
from wmspec.sim.scene.model.bounds import world_box

# ---------------------------------------------------------------- without any physics


def test_a_file_without_physics_is_one_thing(tmp_path: Path) -> None:
    """It rests on its lowest point, weighs by density what its hulls are, and what is flat or hidden is not touched."""
    sheet = QUADS.format("0, 1, 2, 3").replace("[4,4,4,4,4,4]", "[4]")
    text = f"""#usda 1.0
(
  metersPerUnit = 0.01
  upAxis = "Y"
)
def Xform "cup" {{
  def Mesh "side" {{
    {quads()}
    double3 xformOp:scale = (3, 5, 3)
    uniform token[] xformOpOrder = ["xformOp:scale"]
  }}
  def Sphere "knob" {{
    double radius = 1
    double3 xformOp:translate = (0, 6, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
  }}
  def Mesh "label" {{
    {sheet}
  }}
  def Mesh "proxy" {{
    {quads()}
    uniform token purpose = "guide"
  }}
}}"""
    (tmp_path / "cup.usda").write_text(text)
    found = body(tmp_path, 'object a { file: "cup.usda"  on: floor_ at (0, 0)  density: 500 kg/m^3 }')
    assert found.motion == "dynamic"
    assert [(g.collides, g.visible) for g in found.geoms] == [(True, True), (True, True), (False, True)]
    np.testing.assert_allclose(found.pose.position, (0, 0, 0.05), atol=1e-6)
    np.testing.assert_allclose(world_box(found.geoms, found.pose), [(-0.03, -0.03, 0), (0.03, 0.03, 0.12)], atol=1e-6)
    assert found.inertia is not None
    assert found.inertia.mass == pytest.approx(500 * (0.06 * 0.06 * 0.1 + 4 / 3 * np.pi * 0.01**3), rel=1e-5)


def test_a_file_with_colliders_alone_stands_still(tmp_path: Path) -> None:
    text = f'def Mesh "wall" ( prepend apiSchemas = ["PhysicsCollisionAPI"] ) {{\n{ANGLE}\n}}'
    (tmp_path / "wall.usda").write_text(f"#usda 1.0\n{text}")
    found = body(tmp_path, 'object a { file: "wall.usda"  at: (0, 0, 0) }')
    assert found.motion == "static"
    assert ways(tmp_path, 'object a { file: "wall.usda"  at: (0, 0, 0) }') == ["none"]


# ---------------------------------------------------------------- what else a stage is made of


def test_instances_are_meshes_like_others(tmp_path: Path) -> None:
    """Of a prototype in another layer, each in its own place and scale."""
    (tmp_path / "parts").mkdir()
    written(tmp_path / "parts", "one.usda")
    refers = "prepend references = @./parts/one.usda@</World/thing/form>\ninstanceable = true"
    made = [
        f'def "{name}" (\n{refers}\n) {{\ndouble3 xformOp:translate = ({x}, 0, 0)\n'
        f"double3 xformOp:scale = ({s}, {s}, {s})\n"
        'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]\n}'
        for name, x, s in (("a", 0, 1), ("b", 5, 2))
    ]
    wrapped = f'def Xform "World" {{\n{made[0]}\n{made[1]}\n}}'
    held = 'def Xform "pair" ( instanceable = true\nprepend references = </World> ) {\n}'
    (tmp_path / "pair.usda").write_text(f'#usda 1.0\n(\nmetersPerUnit = 1\nupAxis = "Z"\n)\n{wrapped}\n{held}')
    found = body(tmp_path, 'object a { file: "pair.usda"  at: (0, 0, 0) }')
    assert [g.collides for g in found.geoms] == [True] * 4
    np.testing.assert_allclose(world_box(found.geoms, found.pose), [(-1, -2, -2), (7, 2, 2)], atol=1e-6)
    proxy = body(tmp_path, 'object a { file: "pair.usda#/pair/b"  at: (0, 0, 0) }')
    assert solid(proxy).volume == pytest.approx(64, rel=1e-5)


def test_layers_outside_the_folder_are_refused(tmp_path: Path) -> None:
    written(tmp_path, "one.usda")
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs/two.usda").write_text("#usda 1.0\n(\nsubLayers = [@../one.usda@]\n)")
    (tmp_path / "specs/spec.wms").write_text('task t : custom { object a { file: "two.usda#/World/thing/form" } }')
    (reported,) = (d for d in checked(tmp_path / "specs/spec.wms")[1].diagnostics if d.code == "WMS210")
    assert reported.message == "two.usda: uses `one.usda`, which is not below the spec's folder"


def test_a_file_that_changes_is_read_again(tmp_path: Path) -> None:
    for times in (1, 3):
        written(tmp_path, "mesh.usda", scale=(times,) * 3)
        found = solid(body(tmp_path, 'object a { file: "mesh.usda#/World/thing/form"  at: (0, 0, 0) }'))
        assert np.ptp(found.bounds, axis=0) == pytest.approx((2 * times,) * 3, rel=1e-5)


def test_oversized_input_is_refused_early(tmp_path: Path) -> None:
    n = 250_001
    stage = Usd.Stage.CreateNew(str(tmp_path / "large.usdc"))
    made = UsdGeom.Mesh.Define(stage, "/large")
    made.GetPointsAttr().Set(np.zeros((4, 3), np.float32))
    made.GetFaceVertexCountsAttr().Set(np.full(n, 4, np.int32))
    made.GetFaceVertexIndicesAttr().Set(np.tile(np.arange(4, dtype=np.int32), n))
    stage.Save()
    (tmp_path / "spec.wms").write_text('task t : custom { object a { file: "large.usdc" } }')
    (_, report), work = calls(lambda: checked(tmp_path / "spec.wms"))
    (reported,) = (d for d in report.diagnostics if d.code == "WMS210")
    assert reported.message == "large.usdc: `/large`: it has more than 1,000,000 points or corners"
    assert work < 200_000


DOMINO = """#usda 1.0
(
  metersPerUnit = 1
  upAxis = "Z"
)
def Xform "domino" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {{
  float physics:mass = 0.025
  float3 physics:diagonalInertia = (1, 1, 1)
  def Mesh "form" (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"]) {{
    uniform token physics:approximation = "convexHull"
    {0}
    double3 xformOp:scale = (0.01, 0.02, 0.05)
    uniform token[] xformOpOrder = ["xformOp:scale"]
  }}
}}
"""


@pytest.mark.parametrize("kept", [True, False])
def test_impossible_mesh_inertia_is_recomputed_unless_kept(tmp_path: Path, kept: bool) -> None:
    (tmp_path / "domino.usda").write_text(DOMINO.format(quads()))
    said = "inertia: file" if kept else ""
    made = spec(f'object it {{ file: "domino.usda"  at: (0, 0, 0)  {said} }}', tmp_path)
    inertia = named(scene(made), "it").inertia
    assert inertia is not None
    assert inertia.mass == pytest.approx(0.025)
    assert (inertia.moments.max() > 0.9) == kept
