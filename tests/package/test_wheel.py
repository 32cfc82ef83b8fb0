"""What is installed from an archive is whole, alone in site-packages, and works from any folder."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(not (ROOT / ".git").exists(), reason="what is tracked is known in a checkout only")

SPEC = "wmspec/specs/prediction/mechanistic/collide.wms"


def run(*command: str | Path, cwd: Path) -> str:
    elsewhere = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [str(c) for c in command], cwd=cwd, env=elsewhere, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def build(source: Path, target: str, into: Path) -> Path:
    run(sys.executable, "-m", "hatchling", "build", "-t", target, "-d", into, cwd=source)
    (archive,) = into.glob("*.tar.gz" if target == "sdist" else "*.whl")
    return archive


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel made from the source archive."""
    folder = tmp_path_factory.mktemp("archives")
    with tarfile.open(build(ROOT, "sdist", folder / "sdist")) as archive:
        assert not [m.name for m in archive if m.issym() or m.islnk()], "links would dangle elsewhere"
        archive.extractall(folder / "unpacked", filter="data")
    (source,) = (folder / "unpacked").iterdir()
    return build(source, "wheel", folder / "wheel")


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh environment with the wheel; what it depends on is seen in this one, so no network is needed."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False, symlinks=True)
    site = next(folder.glob("lib/python*/site-packages"))
    pip = [sys.executable, "-m", "pip", "--python", folder / "bin/python"]
    run(*pip, "install", "-q", "--no-deps", "--no-index", wheel, cwd=folder)
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder


def names(wheel: Path) -> set[str]:
    return set(zipfile.ZipFile(wheel).namelist())


def test_only_wmspec_goes_to_site_packages(wheel: Path) -> None:
    assert {n.split("/")[0] for n in names(wheel)} == {"wmspec", "wmspec-0.1.0.dist-info"}


def test_every_tracked_file_of_the_package_is_inside(wheel: Path) -> None:
    listed = run("git", "ls-files", "wmspec", "backends", "grammar", "specs", cwd=ROOT).split()
    wanted = {f if f.startswith("wmspec/") else f"wmspec/{f}" for f in listed}
    assert wanted <= names(wheel)
    assert {"wmspec/py.typed", "wmspec/grammar/wms.lark", SPEC} <= wanted
    assert any(n.endswith("plugInfo.json") for n in wanted)


def test_a_wheel_from_a_checkout_is_the_same(wheel: Path, tmp_path: Path) -> None:
    assert names(build(ROOT, "wheel", tmp_path)) == names(wheel)


def test_a_wheel_has_the_same_bytes_whenever_it_is_built(wheel: Path, tmp_path: Path) -> None:
    assert build(ROOT, "wheel", tmp_path).read_bytes() == wheel.read_bytes()


def test_it_runs_from_elsewhere(installed: Path, tmp_path: Path) -> None:
    (site,) = installed.glob("lib/python*/site-packages")
    where = run(installed / "bin/python", "-c", "import wmspec; print(wmspec.__file__)", cwd=tmp_path)
    assert where.strip() == str(site / "wmspec/__init__.py")
    wmspec = installed / "bin/wmspec"
    run(wmspec, "check", site / "wmspec/specs", cwd=tmp_path)
    run(wmspec, "compile", site / SPEC, "--backend", "all", "-o", tmp_path / "out", cwd=tmp_path)
    suffixes = {p.suffix for p in (tmp_path / "out").rglob("*") if p.is_file()}
    assert ".usda" in suffixes
    assert ".xml" in suffixes


def test_a_checkout_without_links_works(tmp_path: Path) -> None:
    """As from a zip archive, or on a system without links: what git tracks, links as plain files."""
    run("git", "-c", "core.symlinks=false", "checkout-index", "--all", f"--prefix={tmp_path}/", cwd=ROOT)
    here = run(sys.executable, "-c", "import wmspec.backends; print(wmspec.backends.__file__)", cwd=tmp_path)
    assert here.strip() == str(tmp_path / "backends/__init__.py")
    run(sys.executable, "-m", "wmspec", "run", SPEC.removeprefix("wmspec/"), cwd=tmp_path)
