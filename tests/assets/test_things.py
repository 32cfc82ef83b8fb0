"""`wmspec things add`: meshes on disk become a library, with sizes, collision shapes, masses, licences and pictures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from PIL import Image

from tests.assets.specs import checked, named, scene
from tests.engines import ENGINES, installed
from wmspec.api import load
from wmspec.cli import main

SPEC = """use things

task row : custom {
  factor side in [1, 2]
  object ground { shape: box  size: (4 m, 4 m, 10 cm)  at: (0, 0, -5 cm)  fixed: true }
  object a : potato { on: ground at (-30 cm * side, 0) }
  object b : bowl   { on: ground at (0, 0) }
  object c : statue { on: ground at (30 cm, 0) }
  camera front { at: (0, -1 m, 60 cm)  look_at: (0, 0, 5 cm) }
  horizon 0.3 s
  observe front at [0 s, 0.3 s]
  question "Is the potato near?" { options [1, 2]  answer side }
}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scan in millimetres, an open box, and an upright glTF, in folders as collections of scans have them."""
    home = tmp_path_factory.mktemp("scans")
    chance = np.random.default_rng(0)
    potato = trimesh.creation.icosphere(subdivisions=2, radius=40)
    potato.vertices *= 1 + 0.04 * chance.standard_normal((len(potato.vertices), 1))
    walls = [trimesh.creation.box(bounds=((x, -0.05, 0), (x + 0.02, 0.05, 0.06))) for x in (-0.05, 0.03)]
    floor = trimesh.creation.box(bounds=((-0.05, -0.05, 0), (0.05, 0.05, 0.02)))
    bowl = trimesh.boolean.union([*walls, floor], engine="manifold")
    statue = trimesh.creation.cylinder(0.03, 0.16)
    statue.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, (1, 0, 0)))  # upright is y
    for mesh, file in (
        (potato, "011_potato/google_16k/textured.stl"),
        (bowl, "bowl.obj"),
        (statue, "Statue/model.glb"),
    ):
        (home / file).parent.mkdir(parents=True, exist_ok=True)
        mesh.export(home / file)
    return home


def add(*arguments: object) -> str:
    result = CliRunner().invoke(main, ["things", "add", *map(str, arguments)])
    assert result.exit_code == 0, result.output
    return result.output


@pytest.fixture(scope="module")
def library(folder: Path) -> Path:
    pytest.importorskip("mujoco")
    add(folder / "011_potato", "--to", folder, "--units", "mm", "--mass", "potato=180g", "--licence", "CC-BY-4.0",
        "--source", "YCB")  # fmt: skip
    add(folder / "bowl.obj", folder / "Statue", "--to", folder, "--licence", "CC0-1.0")
    (folder / "row.wms").write_text(SPEC)
    return folder / "things.wms"


def test_sizes_collision_shapes_and_masses(library: Path) -> None:
    record = {t["name"]: t for t in json.loads((library.parent / "things.json").read_text())["things"]}
    assert sorted(record) == ["bowl", "potato", "statue"]
    assert record["potato"]["size"] == pytest.approx([0.08] * 3, rel=0.2)
    assert record["statue"]["size"] == pytest.approx([0.06, 0.06, 0.16], rel=0.02)
    assert {name: t["collision"] for name, t in record.items()} == {
        "bowl": "pieces",
        "potato": "hull",
        "statue": "hull",
    }
    spec, report = checked(library.parent / "row.wms")
    assert spec is not None, [d.render() for d in report.diagnostics]
    found = scene(spec)
    assert named(found, "a").mass == pytest.approx(0.18)
    assert spec.licenses == ("CC-BY-4.0", "CC0-1.0")
    assert spec.source == "YCB"


def test_each_has_a_picture(library: Path) -> None:
    for name in ("bowl", "potato", "statue"):
        with Image.open(library.parent / f"thumbnails/{name}.png") as picture:
            assert picture.size == (256, 256)
            assert len(picture.convert("RGB").getcolors(2**16) or ()) > 100


@pytest.mark.parametrize("engine", ENGINES)
def test_they_rest_where_they_are_put(library: Path, engine: str) -> None:
    installed(engine)
    episode = load(library.parent / "row.wms")[0].run(engine)
    for name in ("b", "c"):
        track = episode[name].center
        assert np.linalg.norm(track[-1] - track[0]) < 0.01


def test_a_second_call_renews_the_entry(folder: Path, library: Path) -> None:
    before = library.read_text()
    add(folder / "bowl.obj", "--licence", "CC0-1.0", "--no-thumbnails")
    assert library.read_text() == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["011_potato"], "is 8"),
        (["bowl.obj", "--mass", "cup=1kg"], "the names are `bowl`"),
        (["bowl.obj", "--mass", "bowl=heavy"], "expected NAME=MASS"),
        (["bowl.obj", "--to", "Statue"], "is not below"),
        (["row.txt"], "is no mesh"),
        (["none.obj"], "no such file"),
        (["broken.stl"], "has no faces"),
        (["bowl.obj", "--licence", 'a"b'], "one line without quotes"),
    ],
)
def test_refusals(folder: Path, arguments: list[str], message: str) -> None:
    (folder / "row.txt").write_text("")
    (folder / "broken.stl").write_bytes(b"solid x")
    first, *others = arguments
    others = [str(folder / each) if each == "Statue" else each for each in others]
    result = CliRunner().invoke(main, ["things", "add", str(folder / first), *others, "--no-thumbnails"])
    assert result.exit_code == 2
    assert message in result.output
