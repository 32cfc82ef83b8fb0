"""Images on things: what a UsdUVTexture with its tint and its UsdTransform2d becomes, and what is refused."""

from __future__ import annotations

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from wmspec.core.diagnostics import StageError
from wmspec.sim.materials import MATERIALS
from wmspec.sim.scene.model import Surface
from wmspec.sim.scene.render.color import to_linear
from wmspec.sim.usd import read

TINT = (0.12, 0.27, 0.80)
WOOD = MATERIALS["wood"]


def painted(repeats: float | None = WOOD.repeats, tint: tuple[float, float, float] = TINT) -> Usd.Stage:
    """A cube with an image, as wmspec writes it."""
    stage = Usd.Stage.CreateInMemory()
    cube = UsdGeom.Cube.Define(stage, "/World/cube").GetPrim()
    material = UsdShade.Material.Define(stage, "/World/look")
    surface, texture, st = (
        UsdShade.Shader.Define(stage, f"/World/look/{name}") for name in ("surface", "texture", "st")
    )
    surface.CreateIdAttr("UsdPreviewSurface")
    texture.CreateIdAttr("UsdUVTexture")
    st.CreateIdAttr("UsdPrimvarReader_float2")
    st.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    rgb = texture.CreateOutput("rgb", Sdf.ValueTypeNames.Color3f)
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(rgb)
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(WOOD.path))
    texture.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*to_linear(tint).tolist(), 1))
    for wrap in ("wrapS", "wrapT"):
        texture.CreateInput(wrap, Sdf.ValueTypeNames.Token).Set("repeat")
    texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB")
    coordinates = st.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    if repeats is not None:
        transform = UsdShade.Shader.Define(stage, "/World/look/repeat")
        transform.CreateIdAttr("UsdTransform2d")
        transform.CreateInput("scale", Sdf.ValueTypeNames.Float2).Set(Gf.Vec2f(repeats, repeats))
        transform.CreateInput("in", Sdf.ValueTypeNames.Float2).ConnectToSource(coordinates)
        coordinates = transform.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(coordinates)
    UsdShade.MaterialBindingAPI.Apply(cube).Bind(material)
    return stage


def surface_of(stage: Usd.Stage) -> Surface:
    return read(stage).bodies[0].geoms[0].surface


def test_tint_and_repeats_are_read() -> None:
    found = surface_of(painted())
    assert found.texture == str(WOOD.path)
    assert found.color == pytest.approx(TINT, abs=1e-6)
    assert found.repeats == pytest.approx((5.0, 5.0))


def test_without_a_transform_the_image_is_laid_out_once() -> None:
    assert surface_of(painted(None)).repeats is None


def test_without_a_scale_there_is_no_tint() -> None:
    stage = painted()
    UsdShade.Shader(stage.GetPrimAtPath("/World/look/texture")).GetInput("scale").GetAttr().Clear()
    assert surface_of(stage).color == pytest.approx((1, 1, 1))


@pytest.mark.parametrize(
    ("shader", "name", "kind", "value", "message"),
    [
        ("repeat", "rotation", "Float", 30.0, "does more than scale"),
        ("repeat", "translation", "Float2", Gf.Vec2f(0.5, 0), "does more than scale"),
        ("repeat", "scale", "Float2", Gf.Vec2f(0, 1), "does more than scale"),
        ("texture", "bias", "Float4", Gf.Vec4f(0.1), "has a bias or a scale outside"),
        ("texture", "scale", "Float4", Gf.Vec4f(2), "has a bias or a scale outside"),
        ("texture", "wrapS", "Token", "clamp", "wrap mode"),
        ("texture", "sourceColorSpace", "Token", "raw", "not in sRGB"),
        ("texture", "file", "Asset", "lost.png", "'lost.png' is not found"),
        ("st", "varname", "String", "uv", "but the mesh has 'st'"),
    ],
)
def test_unsupported_input_is_refused(shader: str, name: str, kind: str, value: object, message: str) -> None:
    stage = painted()
    prim = UsdShade.Shader(stage.GetPrimAtPath(f"/World/look/{shader}"))
    prim.CreateInput(name, getattr(Sdf.ValueTypeNames, kind)).Set(value)
    with pytest.raises(StageError, match=message):
        read(stage)
