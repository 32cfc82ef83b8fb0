"""The recipe "adding a shape": one new file and its line in the table take a prism all the way into three engines."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from filecmp import dircmp
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from tests.engines import ENGINES, installed, quick
from tests.recipes.prism import Prism
from wmspec.sim.shapes.facets import tessellate

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
SPEC = HERE / "prism.wms"
READ_BACK = """
import sys
from pxr import Usd
from wmspec.sim.shapes import SHAPES
from wmspec.sim.usd import read
(nut,) = [b for b in read(Usd.Stage.Open(sys.argv[1])).bodies if b.name == "nut"]
shape = nut.geoms[0].shape
assert type(shape) is SHAPES["prism"]
print(shape, shape.volume, nut.inertia.mass)
"""


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A checkout in which the recipe has been carried out."""
    made = tmp_path_factory.mktemp("checkout")
    for folder in ("wmspec", "backends", "grammar", "specs"):
        shutil.copytree(ROOT / folder, made / folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(HERE / "prism.py", made / "wmspec/sim/shapes/prism.py")
    table = made / "wmspec/sim/shapes/__init__.py"
    text = table.read_text()
    text = text.replace('    "plane": Plane,\n', '    "plane": Plane,\n    "prism": Prism,\n')
    text = text.replace(
        "from wmspec.sim.shapes.shape", "from wmspec.sim.shapes.prism import Prism\nfrom wmspec.sim.shapes.shape"
    )
    table.write_text(text)
    return made


def python(checkout: Path, *arguments: str | Path, code: int = 0) -> str:
    """What Python says in that checkout."""
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    command = [sys.executable, *map(str, arguments)]
    done = subprocess.run(command, env=environment, cwd=checkout, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout + done.stderr


def wmspec(checkout: Path, *arguments: str | Path, code: int = 0) -> str:
    return python(checkout, "-m", "wmspec", *arguments, code=code)


def test_one_file_is_new_and_one_is_changed(checkout: Path) -> None:
    compared = dircmp(ROOT / "wmspec/sim/shapes", checkout / "wmspec/sim/shapes", ignore=["__pycache__"])
    assert (compared.right_only, compared.diff_files, compared.left_only) == (["prism.py"], ["__init__.py"], [])


@given(st.integers(3, 12), st.floats(0.01, 1), st.floats(0.01, 1))
def test_it_weighs_what_its_triangles_hold(sides: int, radius: float, height: float) -> None:
    prism = Prism(sides, radius, height)
    facets = tessellate(prism)
    solid = trimesh.Trimesh(facets.points, facets.faces)
    solid.merge_vertices(merge_tex=True, merge_norm=True)
    assert solid.is_watertight
    assert solid.volume == pytest.approx(prism.volume)
    np.testing.assert_allclose(solid.moment_inertia / solid.mass, prism.tensor, atol=1e-9)


def test_it_is_checked(checkout: Path, tmp_path: Path) -> None:
    wmspec(checkout, "check", SPEC)
    for wrong, message in (
        ("sides: 2", "`sides` must be at least 3"),
        ("sides: 4.5", "the prism `bar` cannot have 4.5 sides"),
        ("side: 4", "did you mean `sides`?"),
    ):
        spec = tmp_path / "wrong.wms"
        spec.write_text(SPEC.read_text().replace("sides: 4", wrong))
        assert message in wmspec(checkout, "check", spec, code=2)
    spec.write_text(SPEC.read_text().replace("    shape: prism\n", "    shape: cone\n"))
    assert "a cone has no `sides`" in wmspec(checkout, "check", spec, code=2)


@pytest.mark.parametrize("engine", quick("pybullet", "sapien"))
def test_it_rests_where_it_was_put(checkout: Path, tmp_path: Path, engine: str) -> None:
    installed(engine)
    wmspec(checkout, "run", SPEC, "--backend", engine, "-i", "5", "-o", tmp_path / "trace.npz")
    kept = np.load(tmp_path / "trace.npz")
    moving = [i for i, name in enumerate(kept["bodies"]) if name in ("nut", "bar")]
    assert len(moving) == 2
    path = kept["position"][:, moving]
    assert np.abs(path - path[0]).max() < 5e-4
    heights = dict(zip(kept["bodies"][moving].tolist(), path[0, :, 2].tolist(), strict=True))
    assert heights["nut"] - heights["bar"] == pytest.approx(0.025 - 0.03 / np.sqrt(2)), "on its end, and on its side"


@pytest.mark.parametrize("engine", quick("mujoco"))
def test_it_is_drawn(checkout: Path, tmp_path: Path, engine: str) -> None:
    from PIL import Image

    installed(engine)
    wmspec(checkout, "render", SPEC, "--backend", ENGINES[0], "--renderer", engine, "--size", "128", "-o", tmp_path)
    picture = np.asarray(Image.open(min(tmp_path.glob("*.png"))), int)
    red = (picture[..., 0] - picture[..., 1:].max(axis=-1) > 60).sum()
    blue = (picture[..., 2] - picture[..., :2].max(axis=-1) > 60).sum()
    assert red > 20
    assert blue > 20


def test_nothing_of_it_is_lost_on_the_stage(checkout: Path, tmp_path: Path) -> None:
    wmspec(checkout, "compile", SPEC, "-o", tmp_path)
    (stage,) = tmp_path.rglob("000000.usda")
    prism = Prism(5, 0.06, 0.05)
    read, volume, mass = python(checkout, "-c", READ_BACK, stage).rsplit(maxsplit=2)
    assert (read, float(volume)) == (str(prism), prism.volume)
    assert float(mass) == pytest.approx(600 * prism.volume, rel=1e-6)
    without = subprocess.run(
        [sys.executable, "-m", "wmspec", "run", stage, "--json"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert json.loads(without.stdout), "where the prism is not known, it is a mesh"
