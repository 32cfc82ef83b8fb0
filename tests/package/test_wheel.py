"""What is installed from an archive is whole, alone in site-packages, and works from any folder without a checkout."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tarfile
import zipfile
from importlib.metadata import Distribution, distribution, distributions
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from PIL import Image

from tests.engines import ENGINES, installed
from tools.installed import build, environment

ROOT = Path(__file__).parents[2]
SPEC = "specs/prediction/mechanistic/collide.wms"
in_a_checkout = pytest.mark.skipif(not (ROOT / ".git").exists(), reason="what is tracked is known in a checkout only")


def run(*command: object, cwd: Path, **env: str) -> str:
    """What a command prints, started as a user does: Python's settings of these tests are none of its business."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        list(map(str, command)), cwd=cwd, env=clean | env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    assert "Traceback" not in done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel made from the source archive."""
    folder = tmp_path_factory.mktemp("archives")
    with tarfile.open(build(ROOT, "sdist", folder / "sdist")) as archive:
        assert not [m.name for m in archive if m.issym() or m.islnk()], "links would dangle elsewhere"
        archive.extractall(folder / "unpacked", filter="data")
    (source,) = (folder / "unpacked").iterdir()
    return build(source, "wheel", folder / "wheel")


def names(wheel: Path) -> set[str]:
    return set(zipfile.ZipFile(wheel).namelist())


def test_only_wmspec_goes_to_site_packages(wheel: Path) -> None:
    assert {n.split("/")[0] for n in names(wheel)} == {
        "wmspec",
        wheel.name.removesuffix("-py3-none-any.whl") + ".dist-info",
    }


@in_a_checkout
def test_every_tracked_file_of_the_package_is_inside(wheel: Path) -> None:
    listed = run("git", "ls-files", "wmspec", "backends", "grammar", "specs", cwd=ROOT).split()
    expected = {f if f.startswith("wmspec/") else f"wmspec/{f}" for f in listed}
    assert expected <= names(wheel)
    assert {"wmspec/py.typed", "wmspec/grammar/wms.lark", f"wmspec/{SPEC}"} <= expected
    assert any(n.endswith("plugInfo.json") for n in expected)


@in_a_checkout
def test_a_wheel_from_a_checkout_has_the_same_bytes_whenever_it_is_built(wheel: Path, tmp_path: Path) -> None:
    here = build(ROOT, "wheel", tmp_path)
    assert names(here) == names(wheel)
    assert here.read_bytes() == wheel.read_bytes()


@in_a_checkout
def test_a_checkout_without_links_works(tmp_path: Path) -> None:
    """As from a zip archive, or on a system without links: what git tracks, links as plain files."""
    run("git", "-c", "core.symlinks=false", "checkout-index", "--all", f"--prefix={tmp_path}/", cwd=ROOT)
    here = run(sys.executable, "-c", "import wmspec.backends; print(wmspec.backends.__file__)", cwd=tmp_path)
    assert here.strip() == str(tmp_path / "backends/__init__.py")
    run(sys.executable, "-m", "wmspec", "run", "specs/prediction/mechanistic/slide.wms", cwd=tmp_path)


# ------------------------------------------------------------------ the wheel alone


@pytest.fixture(scope="module")
def alone(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of an environment with what `pip install wmspec[engines]` would install, and nothing else.

    The packages are links to the files of those that are installed here, so no network is needed.
    """
    folder = tmp_path_factory.mktemp("environment")
    site = environment(folder, wheel)
    for package in required(site, "engines").values():
        link(package, site)
    return folder / "bin"


def required(site: Path, extra: str) -> dict[str, Distribution]:
    """The packages, installed here, that the wheel in `site` requires with an extra, directly or not, by name."""
    (ours,) = distributions(name="wmspec", path=[str(site)])
    found: dict[tuple[str, str], Distribution] = {}
    waiting = [("wmspec", extra)]
    while waiting:
        name, chosen = waiting.pop()
        if (name, chosen) in found:
            continue
        package = found[name, chosen] = ours if name == "wmspec" else distribution(name)
        for requirement in map(Requirement, package.requires or ()):
            if requirement.marker is None or requirement.marker.evaluate({"extra": chosen}):
                waiting += [(str(canonicalize_name(requirement.name)), e) for e in ("", *requirement.extras)]
    return {name: package for (name, _), package in found.items() if package is not ours}


def link(package: Distribution, site: Path) -> None:
    """Puts each file of a package into another environment's site-packages, without its programs."""
    assert package.files, package.name
    for file in package.files:
        if ".." not in file.parts and not (site / file).exists():  # two packages may share a file
            (site / file).parent.mkdir(parents=True, exist_ok=True)
            (site / file).symlink_to(Path(str(package.locate_file(file))).absolute())


@pytest.mark.slow
def test_wheel_needs_only_its_dependencies(alone: Path, tmp_path: Path) -> None:
    """From an empty folder to a dataset of all engines, looked at and made again; no development package.

    Otherwise `make check` compares imports with dependencies, and all tests run on an installed wheel.
    """
    for engine in ENGINES:
        installed(engine)
    python = alone / "python"
    home = {"HOME": str(tmp_path / "home"), "XDG_CACHE_HOME": str(tmp_path / "home/cache")}
    work = tmp_path / "work"
    work.mkdir()

    def wmspec(*arguments: str) -> str:
        return run(alone / "wmspec", *arguments, cwd=work, **home)

    found = {finding["name"]: finding["ok"] for finding in json.loads(wmspec("doctor", "--json"))["findings"]}
    assert all(found[f"{engine} {does}"] for engine in ENGINES for does in ("executes", "renders")), found

    names = "from importlib.metadata import *; print(*(d.name for d in distributions()))"
    there = {str(canonicalize_name(name)) for name in run(python, "-c", names, cwd=work).split()}
    (site,) = alone.parent.glob("lib/python*/site-packages")
    assert there == {"wmspec", *required(site, "engines")}, "no more, such as what only developers install"

    wmspec("new", "my")
    wmspec("check", "my.wms")
    wmspec("generate", "my.wms", "--backend", "all", "-o", "all", "--per-task", "1", "--size", "64", "-j", "1")
    made = pq.read_table(work / "all/data", columns=["engine", "agreement"]).to_pylist()
    assert [row["engine"] for row in made] == [ENGINES[0]], "one row stands for all engines"
    assert {vote["engine"] for vote in made[0]["agreement"]} == set(ENGINES)
    assert "byte-identical" in wmspec("verify", "all", "--sample", "1", "-j", "1")
    wmspec("view", "all")
    wmspec("view", "all", "-o", "sheet.png")
    assert (work / "gallery.html").read_text().count("data:image/") >= len(ENGINES)
    wmspec("render", "my.wms", "--backend", "all", "--size", "64", "-o", "pictures")
    for picture in [work / "sheet.png", *(work / "pictures").iterdir()]:
        assert np.asarray(Image.open(picture).convert("RGB")).std() > 1, picture
    for engine in ENGINES:
        assert list((work / "pictures").glob(f"*{engine}*.png")), engine

    wmspec("compile", "my.wms", "--backend", "all", "-o", "compiled")
    for engine in ENGINES:
        (script,) = (work / "compiled").rglob(f"*.{engine}/run.py")
        run(python, script.name, cwd=script.parent, **home)
        with np.load(script.with_name("trace.npz")) as trace:
            assert np.ptp(trace["position"], axis=0).max() > 0.01, "something moves"
    read = "import mujoco, sys; print(mujoco.MjModel.from_xml_path(sys.argv[1]).nbody)"
    (model,) = (work / "compiled").rglob("scene.xml")
    assert int(run(python, "-c", read, model, cwd=work)) > 1
