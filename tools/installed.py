"""Create an environment with wmspec and usdphysics-conformance from wheels: python -m tools.installed [FOLDER].

Dependencies are those of the running environment. From the checkout, only packages that are never shipped can be
imported. `wmspec` and `backends` come from the wheel, so a test fails if the wheel lacks a file.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "build/installed"
#: Packages that tests import and no wheel contains.
UNSHIPPED = ("tests", "tools", "benchmarks")


def main(folder: Path = FOLDER) -> None:
    """Build the wheels of this checkout and create the environment in a folder, which is replaced."""
    wheels = [
        build(ROOT, "wheel", folder.with_name(f"{folder.name}-wheel")),
        build(ROOT / "conformance", "wheel", folder.with_name(f"{folder.name}-conformance-wheel")),
    ]
    site = environment(folder, *wheels)
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    if (share := Path(sys.prefix, "share")).is_dir():
        (folder / "share").symlink_to(share)  # some of them keep data there
    for name in UNSHIPPED:
        (site / name).mkdir()
        (site / name / "__init__.py").write_text(f"__path__ = [{str(ROOT / name)!r}]\n")


def build(source: Path, target: str, into: Path) -> Path:
    """Build a "wheel" or "sdist" of a source tree into a folder, which is replaced; return the archive."""
    shutil.rmtree(into, ignore_errors=True)
    hatchling = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(into)]
    subprocess.run(hatchling, cwd=source, check=True, stdout=subprocess.DEVNULL)
    (archive,) = into.glob("*.tar.gz" if target == "sdist" else "*.whl")
    return archive


def environment(folder: Path, *wheels: Path) -> Path:
    """Create an environment with these wheels only; return its site-packages."""
    venv.create(folder, clear=True, symlinks=True)
    pip = [sys.executable, "-m", "pip", "--python", str(folder / "bin/python")]
    subprocess.run([*pip, "install", "--quiet", "--no-deps", "--no-index", *map(str, wheels)], check=True)
    return next(folder.glob("lib/python*/site-packages"))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
