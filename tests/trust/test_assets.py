"""Untrusted files beside a spec: links that lead out, and what would fill the memory."""

from __future__ import annotations

import json
import time
import warnings
from pathlib import Path

import pytest
import trimesh
from PIL import Image, PngImagePlugin

from tests.trust.made import wmspec
from wmspec.core.limits import PIXELS, TooLarge
from wmspec.core.safe_io import is_file_name, is_within, load_image

SPEC = """
use tabletop
task t : custom {{
  object thing {{ file: "{file}" {more} }}
  observe front at 0 s
}}
"""
PLAIN = SPEC.replace('{{ file: "{file}" {more} }}', "{{ shape: cube size: 10 cm {more} }}")


def checked(folder: Path, text: str) -> str:
    (folder / "t.wms").write_text(text)
    result = wmspec("check", folder / "t.wms")
    assert result.exit_code in (0, 2)
    return result.output


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "project").mkdir()
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / "cup.obj")
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / "project" / "cup.obj")
    Image.new("RGB", (8, 8), "red").save(tmp_path / "label.png")
    (tmp_path / "secret.wms").write_text("root:x:0:0:root:/root:/bin/bash\n")
    return tmp_path / "project"


def test_the_plain_project_is_right(project: Path) -> None:
    assert "no mistakes" in checked(project, SPEC.format(file="cup.obj", more=""))


def test_a_mesh_that_is_a_link_out_of_the_project(project: Path) -> None:
    (project / "out.obj").symlink_to("../cup.obj")
    output = checked(project, SPEC.format(file="out.obj", more=""))
    assert "`out.obj` is a link that leads out of the spec's folder" in output


def test_a_picture_that_is_a_link_out_of_the_project(project: Path) -> None:
    (project / "out.png").symlink_to("../label.png")
    output = checked(project, PLAIN.format(file="", more='image: "out.png"'))
    assert "`out.png` is a link that leads out of the spec's folder" in output


def test_a_library_that_is_a_link_out_of_the_project(project: Path) -> None:
    (project / "lib.wms").symlink_to("../secret.wms")
    output = checked(project, "use lib\n" + SPEC.format(file="cup.obj", more=""))
    assert "there is no library `lib`" in output
    assert "root:" not in output


def test_a_spec_in_a_folder_that_is_a_link_out_of_it(project: Path) -> None:
    (project / "spec.wms").symlink_to("../secret.wms")
    (project / "t.wms").write_text(SPEC.format(file="cup.obj", more=""))
    assert "root:" not in wmspec("check", project).output


@pytest.mark.parametrize("form", ["urdf", "mjcf"])
def test_the_mesh_of_an_asset_that_is_a_link_out_of_the_project(project: Path, form: str) -> None:
    (project / "out.obj").symlink_to("../cup.obj")
    urdf = (
        '<robot name="r"><link name="l"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" '
        'iyz="0"/></inertial><collision><geometry><mesh filename="out.obj"/></geometry></collision></link></robot>'
    )
    mjcf = (
        '<mujoco><asset><mesh name="m" file="out.obj"/></asset><worldbody><body><geom type="mesh" mesh="m"/></body>'
        "</worldbody></mujoco>"
    )
    name = {"urdf": "r.urdf", "mjcf": "r.xml"}[form]
    (project / name).write_text({"urdf": urdf, "mjcf": mjcf}[form])
    assert "there is no mesh `out.obj` below the spec's folder" in checked(project, SPEC.format(file=name, more=""))


def test_links_inside_are_followed(project: Path) -> None:
    (project / "same.obj").symlink_to("cup.obj")
    assert "no mistakes" in checked(project, SPEC.format(file="same.obj", more=""))


# ---------------------------------------------------------------- too large


def test_references_that_double(project: Path) -> None:
    """3 kB that ask for 2^25 prims: 60 s and 1.7 GB before they were refused."""
    layers = ['def Xform "p0" {\ndef Sphere "s" {}\n}']
    for i in range(1, 26):
        both = "\n".join(f'def "{side}" (references = </p{i - 1}>) {{}}' for side in "ab")
        layers.append(f'def Xform "p{i}" {{\n{both}\n}}')
    (project / "many.usda").write_text('#usda 1.0\n(defaultPrim = "p25")\n' + "\n".join(layers))
    began = time.process_time()
    output = checked(project, SPEC.format(file="many.usda", more=""))
    assert "many.usda: has more than 200,000 prims after composition" in output
    result = wmspec("run", project / "many.usda")
    assert result.exit_code == 2
    assert "has more than 200,000 prims after composition" in result.output
    assert time.process_time() - began < 30


def test_layers_that_double(project: Path) -> None:
    (project / "l0.usda").write_text('#usda 1.0\n(defaultPrim = "p")\ndef Sphere "p" {}')
    for i in range(1, 26):
        both = "\n".join(f'def "{side}" (payload = @l{i - 1}.usda@) {{}}' for side in "ab")
        (project / f"l{i}.usda").write_text(f'#usda 1.0\n(defaultPrim = "p")\ndef Xform "p" {{\n{both}\n}}')
    assert "has more than 200,000 prims" in checked(project, SPEC.format(file="l25.usda", more=""))


def test_circular_references_are_reported_by_usd(project: Path) -> None:
    (project / "round.usda").write_text('#usda 1.0\n(defaultPrim = "a")\ndef "a" (references = </a>) {}')
    assert "round.usda" in checked(project, SPEC.format(file="round.usda", more=""))


def test_a_mesh_of_too_many_faces(project: Path) -> None:
    with (project / "cup.stl").open("wb") as file:
        file.write(b"\0" * 80 + (400_000).to_bytes(4, "little"))
        file.truncate(84 + 400_000 * 50)
    output = checked(project, SPEC.format(file="cup.stl", more=""))
    assert "has more than 1,000,000 points or corners" in output


def test_a_file_of_too_many_bytes(project: Path) -> None:
    with (project / "cup.ply").open("wb") as file:
        file.truncate(100_000_001)
    assert "has more than 100,000,000 bytes" in checked(project, SPEC.format(file="cup.ply", more=""))


@pytest.mark.parametrize("size", ["1e300", "1e-300", "0", "nan", "inf"])
def test_mesh_of_extreme_numbers_is_an_error_without_warnings(project: Path, size: str) -> None:
    corners = f"v {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\nv 0 0 0\n"
    (project / "odd.obj").write_text(corners + "f 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "odd.obj" in checked(project, SPEC.format(file="odd.obj", more=""))


def test_a_picture_of_too_many_pixels(project: Path) -> None:
    """`generate` ended with a traceback, at every resume; now `check` says it."""
    Image.new("1", (30_000, 30_000)).save(project / "bomb.png")
    output = checked(project, PLAIN.format(file="", more='image: "bomb.png"'))
    assert "`bomb.png` has more than 67,108,864 pixels" in output


@pytest.mark.parametrize("content", [b"", b"GIF89a", b"\x89PNG\r\n\x1a\n" + b"\0" * 40])
def test_invalid_picture_is_an_error(project: Path, content: bytes) -> None:
    (project / "bad.png").write_bytes(content)
    output = checked(project, PLAIN.format(file="", more='image: "bad.png"'))
    assert "`bad.png` cannot be read: it is damaged, or no PNG or JPEG" in output


def test_compressed_texts_in_pictures_are_bounded(tmp_path: Path) -> None:
    info = PngImagePlugin.PngInfo()
    for i in range(80):
        info.add_text(f"t{i}", "x" * 1_000_000, zip=True)
    Image.new("RGB", (8, 8)).save(tmp_path / "texts.png", pnginfo=info)
    with pytest.raises(Exception, match="cannot be read"):
        load_image(tmp_path / "texts.png")


@pytest.mark.parametrize("horizon", ["601 s", "36000000 s"])
def test_a_horizon_that_is_too_far(project: Path, horizon: str) -> None:
    text = PLAIN.format(file="", more="").replace("observe front", f"horizon {horizon}\n  observe front")
    assert "`horizon` must be at most 600 s" in checked(project, text)


def test_an_observation_that_is_too_far(project: Path) -> None:
    text = PLAIN.format(file="", more="").replace("at 0 s", "at 20 min")
    output = checked(project, text.replace("20 min", "1200 s"))
    assert "the episode has more than 600 seconds here" in output


def test_a_crowd_is_warned_of(project: Path) -> None:
    many = "\n".join(f"  object s{i} {{ shape: sphere size: 2 cm at: ({i} m, 0 m, 3 m) }}" for i in range(120))
    text = PLAIN.format(file="", more="").replace("  observe", f"{many}\n  horizon 10 s\n  observe")
    assert "things can move, and" in checked(project, text)
    assert "things can move" not in checked(project, text.replace("10 s", "0.1 s"))


def test_a_check_that_takes_too_long_is_stopped(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever reads files of others takes any Exception for a mistake in them; this is none."""

    def endless(*arguments: object, **options: object) -> None:
        while True:
            time.sleep(0.01)

    monkeypatch.setattr("trimesh.load", endless)
    (project / "t.wms").write_text(SPEC.format(file="cup.obj", more=""))
    result = wmspec("check", project / "t.wms", "--timeout", "1")
    assert result.exit_code == 2
    assert "time limit of 1 s exceeded; check fewer specs, or set --timeout" in result.output


def test_a_damaged_crate_does_not_end_the_process(project: Path) -> None:
    """USD believes what a binary file says of its lengths: it read 3.7 GB, or died."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.CreateNew(str(project / "good.usdc"))
    stage.SetDefaultPrim(UsdGeom.Sphere.Define(stage, "/ball").GetPrim())
    stage.Save()
    content = bytearray((project / "good.usdc").read_bytes())
    assert "good.usdc: cannot be read" not in checked(project, SPEC.format(file="good.usdc", more=""))
    content[len(content) // 3 : len(content) // 3 + 300] = b"\xff" * 300
    (project / "bad.usdc").write_bytes(content)
    assert "bad.usdc: cannot be read: is damaged" in checked(project, SPEC.format(file="bad.usdc", more=""))
    assert "is damaged, or needs too much time or memory" in wmspec("run", project / "bad.usdc").output


def test_damaged_files_are_errors_or_read() -> None:
    """Some of the files of `benchmarks/fuzz.py --of files`, whose figures are in docs/benchmarks/robustness.md."""
    from benchmarks.damaged import KINDS, attempt_file

    came = {attempt_file(number) for number in range(12 * len(KINDS))}
    assert {f"{kind} refused" for kind in KINDS} <= came
    assert any(each.endswith(" read") for each in came)


# ---------------------------------------------------------------- refused by us, independent of the libraries


@pytest.mark.parametrize("uri", ["../secret.bin", "/etc/hostname", "file:///etc/hostname", "https://a.example/x.bin"])
def test_gltf_with_files_outside_its_folder(project: Path, uri: str) -> None:
    (project.parent / "secret.bin").write_bytes(b"\0" * 100)
    whole = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="gltf")
    text = json.loads(whole["model.gltf"])
    text["buffers"][0]["uri"] = uri
    (project / "cup.gltf").write_text(json.dumps(text))
    assert f"uses `{uri}`, which is not beside it" in checked(project, SPEC.format(file="cup.gltf", more=""))


@pytest.mark.parametrize("name", ["KHR_draco_mesh_compression", "EXT_meshopt_compression"])
def test_a_compressed_gltf_is_refused_with_the_name_of_its_extension(project: Path, name: str) -> None:
    whole = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="gltf")
    text = json.loads(whole["model.gltf"]) | {"extensionsRequired": [name]}
    (project / "cup.gltf").write_text(json.dumps(text))
    for buffer in set(whole) - {"model.gltf"}:
        (project / buffer).write_bytes(whole[buffer])
    said = checked(project, SPEC.format(file="cup.gltf", more=""))
    assert f"cup.gltf is compressed ({name}), which is not supported" in said
    assert "export it without compression" in said
    (project / "cup.gltf").write_text(json.dumps(text | {"extensionsRequired": ["KHR_materials_unlit"]}))
    assert "compressed" not in checked(project, SPEC.format(file="cup.gltf", more=""))


def test_a_dae_with_entities(project: Path) -> None:
    text = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="dae").decode()
    start = text.index("<COLLADA")
    (project / "good.dae").write_text(text)
    evil = '<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/hostname">]>'
    (project / "cup.dae").write_text(text[:start] + evil + text[start:])
    assert "has a DTD or entities" in checked(project, SPEC.format(file="cup.dae", more=""))
    assert "no mistakes" in checked(project, SPEC.format(file="good.dae", more=""))


# ---------------------------------------------------------------- the helpers


@pytest.mark.parametrize("name", ["collide", "a.b-c_1", "Ünïcode", "x" * 100])
def test_names(name: str) -> None:
    assert is_file_name(name)


@pytest.mark.parametrize(
    "name", ["", ".", "..", "a/b", "a\\b", ".hidden", "-o", "x" * 101, "a\0", "a\n", "a b", 7, None]
)
def test_unsafe_file_names(name: object) -> None:
    assert not is_file_name(name)


def test_inside_follows_links_and_survives_what_is_no_path(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "f").write_text("")
    (tmp_path / "a/link").symlink_to(tmp_path / "f")
    (tmp_path / "a/round").symlink_to(tmp_path / "a/round")
    assert is_within(tmp_path, tmp_path / "f")
    assert not is_within(tmp_path / "a", tmp_path / "a/link")
    assert not is_within(tmp_path, tmp_path / "a/round")
    assert not is_within(tmp_path, tmp_path / "a")
    assert not is_within(tmp_path, tmp_path / ("x" * 5000))
    assert not is_within(tmp_path, tmp_path / "a\0b")


def test_a_picture_is_as_large_as_the_limit(tmp_path: Path) -> None:
    Image.new("1", (8192, 8193)).save(tmp_path / "large.png")
    with pytest.raises(TooLarge, match=f"{PIXELS.most:,}"):
        load_image(tmp_path / "large.png")
