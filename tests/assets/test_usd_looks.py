"""How prims of USD look: colours, pictures by texture coordinates, several materials on one mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Sdf, Usd, UsdShade, UsdUtils

from tests.assets.specs import checked, named, scene, spec
from tests.assets.test_usd_meshes import QUADS, SIDES
from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.model import Geom
from wmspec.sim.shapes import Mesh

CORNERS = ", ".join(str(i) for side in SIDES for i in side)
HEAD = '#usda 1.0\n(\nmetersPerUnit = 0.01\nupAxis = "Z"\n)'
MATERIAL = """def Material "{name}" {{
  asset inputs:picture = @./pictures/four.png@
  token outputs:surface.connect = </box/{name}/surface.outputs:surface>
  def Shader "surface" {{
    uniform token info:id = "UsdPreviewSurface"
    color3f inputs:diffuseColor.connect = </box/{name}/texture.outputs:rgb>
    token outputs:surface
  }}
  def Shader "texture" {{
    uniform token info:id = "UsdUVTexture"
    asset inputs:file.connect = </box/{name}.inputs:picture>
    float4 inputs:scale = {tint}
    token inputs:wrapS = "clamp"
    float2 inputs:st.connect = </box/{name}/reader.outputs:result>
    float3 outputs:rgb
  }}
  def Shader "reader" {{
    uniform token info:id = "UsdPrimvarReader_float2"
    string inputs:varname = "UVMap"
    float2 outputs:result
  }}
}}"""
PLAIN = """def Material "plain" {
  token outputs:surface.connect = </box/plain/surface.outputs:surface>
  def Shader "surface" {
    uniform token info:id = "UsdPreviewSurface"
    color3f inputs:diffuseColor = (1, 0, 0)
    token outputs:surface
  }
}"""
SUBSET = """def GeomSubset "{name}" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {{
  uniform token elementType = "face"
  uniform token familyName = "materialBind"
  int[] indices = [{faces}]
  rel material:binding = </box/{material}>
}}"""
BOX = """{head}
def Xform "box" ( prepend apiSchemas = ["PhysicsRigidBodyAPI"] ) {{
  {materials}
  def Mesh "sides" ( prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI"] ) {{
    uniform token physics:approximation = "convexHull"
    rel material:binding = </box/picture>
    {form}
    texCoord2f[] primvars:UVMap = [{st}] (
      interpolation = "{way}"
    )
    {subsets}
  }}
}}"""
EACH = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.0, 0.5)] * 6


def folder(tmp_path: Path, subsets: str = "", st: list[tuple[float, float]] = EACH, way: str = "faceVarying") -> Path:
    """A box with a picture on it, 2 cm wide, and the picture; another one lies outside."""
    (tmp_path / "pictures").mkdir(exist_ok=True)
    for name in ("pictures/four.png", "../outside.png"):
        Image.new("RGB", (8, 8), "red").save(tmp_path / name)
    kinds = [MATERIAL.format(name=n, tint=t) for n, t in (("picture", (1, 1, 1, 1)), ("tinted", (1, 0.25, 1, 1)))]
    said = {"materials": "\n".join([*kinds, PLAIN]), "form": QUADS.format(CORNERS), "subsets": subsets, "way": way}
    (tmp_path / "box.usda").write_text(BOX.format(head=HEAD, st=", ".join(map(str, st)), **said))
    return tmp_path


def drawn(where: Path, said: str = "") -> list[Geom]:
    task = spec(f'object a {{ file: "box.usda"  at: (0, 0, 0)  {said} }}', where)
    return [g for g in named(scene(task), "a").geoms if g.visible]


def test_a_picture_lies_as_its_coordinates_say(tmp_path: Path) -> None:
    (found,) = drawn(folder(tmp_path))
    assert found.surface.texture == str(tmp_path / "pictures/four.png")
    assert found.surface.repeats is None
    assert found.surface.color == pytest.approx((1, 1, 1))
    assert isinstance(found.shape, Mesh)
    assert found.shape.st is not None
    made = {(*np.round(100 * p, 6), *uv) for p, uv in zip(found.shape.points, found.shape.st, strict=True)}
    points = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
    assert len(found.shape.points) == len(made) == 19  # a corner of the box has up to three of them
    assert made == {(*points[i], *uv) for i, uv in zip((i for side in SIDES for i in side), EACH, strict=True)}


@pytest.mark.parametrize("way", ["vertex", "varying"])
def test_coordinates_of_points(tmp_path: Path, way: str) -> None:
    (found,) = drawn(folder(tmp_path, st=[(i / 8, 0.5) for i in range(9)], way=way))
    assert isinstance(found.shape, Mesh)
    assert found.shape.st is not None
    assert len(found.shape.points) == 8
    np.testing.assert_allclose(found.shape.st[:, 0], np.arange(8) / 8)


@pytest.mark.parametrize("said", ["color: green", "material: wood", "part box { color: green }"])
def test_a_spec_paints_over_a_picture(tmp_path: Path, said: str) -> None:
    (found,) = drawn(folder(tmp_path), said)
    assert found.surface.texture != str(tmp_path / "pictures/four.png")


def test_each_material_has_its_polygons(tmp_path: Path) -> None:
    """And the whole is what is touched and what weighs."""
    names = (("top", "0, 1", "tinted"), ("round", "2, 3, 4", "plain"), ("end", "5", "picture"))
    subsets = "\n".join(SUBSET.format(name=n, faces=f, material=m) for n, f, m in names)
    where = folder(tmp_path, subsets)
    top, around, end = drawn(where)
    assert [len(g.shape.faces) for g in (top, around, end) if isinstance(g.shape, Mesh)] == [4, 6, 2]
    assert top.surface.color == pytest.approx((1, 0.537099, 1), abs=1e-4)  # IEC 61966-2-1 of 0.25
    assert around.surface.color == pytest.approx((1, 0, 0))
    assert [bool(g.surface.texture) for g in (top, around, end)] == [True, False, True]
    found = named(scene(spec('object a { file: "box.usda"  at: (0, 0, 0) }', where)), "a")
    assert [g.collides for g in found.geoms] == [False, False, False, True]
    assert found.inertia is not None
    assert found.inertia.mass == pytest.approx(1000 * 0.02**3, rel=1e-5)


def test_a_flat_subset_of_a_spec_is_drawn_and_not_touched(tmp_path: Path) -> None:
    where = folder(tmp_path, SUBSET.format(name="top", faces="1", material="plain"))
    mark = 'object a { file: "box.usda#/box/sides/top"  at: (0, 0, 0)  solid: false  fixed: true }'
    (found,) = named(scene(spec(mark, where)), "a").geoms
    assert isinstance(found.shape, Mesh)
    assert np.ptp(found.shape.points, axis=0) == pytest.approx((0.02, 0.02, 0))
    with pytest.raises(WmsError, match="has no volume; use a mesh that is not flat"):
        scene(spec(mark.replace("solid: false", ""), where))


def test_a_package_is_read_but_for_its_pictures(tmp_path: Path) -> None:
    where = folder(tmp_path)
    assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(where / "box.usda")), str(where / "box.usdz"))
    text = 'object a {{ file: "box.usdz"  at: (0, 0, 0)  {0} }}'
    (found,) = (g for g in named(scene(spec(text.format("color: blue"), where)), "a").geoms if g.visible)
    assert isinstance(found.shape, Mesh)
    (where / "spec.wms").write_text(f"task t : custom {{ {text.format('')} }}")
    (reported,) = (d for d in checked(where / "spec.wms")[1].diagnostics if d.code == "WMS211")
    assert "there is no picture" in reported.message


#: What is changed of a material: the shader, its input, the value, and what is said about it.
ODD = [
    ("texture", "sourceColorSpace", "raw", "not in sRGB"),
    ("texture", "bias", (0.1, 0, 0, 0), "has a bias or a scale outside"),
    ("texture", "scale", (2, 1, 1, 1), "has a bias or a scale outside"),
    ("texture", "file", "none.png", "is not found"),
    ("texture", "file", "box.usda", "no picture that can be read"),
    ("texture", "file", "../four.png", "is not found"),
    ("texture", "file", "../outside.png", "there is no picture `outside.png` below the spec's folder"),
    ("reader", "varname", "other", "its image uses the texture coordinates 'other'"),
    ("surface", "opacity", 0.5, "transparency"),
]
TYPES = {"sourceColorSpace": "Token", "varname": "String", "file": "Asset", "opacity": "Float"}


@pytest.mark.parametrize(("shader", "name", "value", "reported"), ODD)
def test_unsupported_looks_are_reported_unless_painted_over(
    tmp_path: Path, shader: str, name: str, value: object, reported: str
) -> None:
    where = folder(tmp_path)
    stage = Usd.Stage.Open(str(where / "box.usda"))
    made = UsdShade.Shader(stage.GetPrimAtPath(f"/box/picture/{shader}"))
    plug = made.GetInput(name) or made.CreateInput(name, getattr(Sdf.ValueTypeNames, TYPES.get(name, "Float4")))
    plug.ClearSources()
    plug.Set(Sdf.AssetPath(value) if name == "file" else value)
    stage.Export(str(where / "box.usda"))
    (where / "spec.wms").write_text('task t : custom { object a { file: "box.usda"  at: (0, 0, 0) } }')
    (found,) = (d for d in checked(where / "spec.wms")[1].diagnostics if d.code == "WMS211")
    assert reported in found.message
    assert found.severity == "warning"
    assert "a plain colour is drawn" in found.message
    assert drawn(where)[0].surface.texture is None
    assert drawn(where, "color: red")


def test_numbers_of_a_surface_through_its_interface(tmp_path: Path) -> None:
    """A material's own inputs stand for those of its surface; a spec may say some of it."""
    where = folder(tmp_path)
    stage = Usd.Stage.Open(str(where / "box.usda"))
    material, surface = (UsdShade.ConnectableAPI(stage.GetPrimAtPath(f"/box/picture{x}")) for x in ("", "/surface"))
    for name, value in (("diffuseColor", (0, 1, 0)), ("roughness", 0.25), ("metallic", 0.75)):
        kind = getattr(Sdf.ValueTypeNames, "Color3f" if name == "diffuseColor" else "Float")
        public = material.CreateInput(name, kind)
        public.Set(value)
        plug = surface.CreateInput(name, kind)
        plug.ClearSources()
        plug.ConnectToSource(public)
    stage.Export(str(where / "box.usda"))
    (found,) = drawn(where)
    assert found.surface.color == pytest.approx((0, 1, 0), abs=1e-6)
    assert (found.surface.roughness, found.surface.metallic) == pytest.approx((0.25, 0.75))
    (found,) = drawn(where, "part box { metallic: 0 }")
    assert (found.surface.roughness, found.surface.metallic) == pytest.approx((0.25, 0))
    (found,) = drawn(where, "color: red")
    assert found.surface.metallic == 0
