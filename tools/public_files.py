"""Fetch public URDF and MJCF files of Python packages, read them and write docs/benchmarks/public_files.md.

python -m tools.public_files fetch FOLDER   the wheels, unpacked into a folder of their name
python -m tools.public_files read FOLDER    reads each file as an asset; results in FOLDER/results.json
python -m tools.public_files table FOLDER   rewrites the page from the results
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tools.reference import table
from wmspec.lang.importers.blocks import relevant_faults
from wmspec.lang.importers.model import RejectedAsset
from wmspec.lang.importers.read import read

PAGE = Path(__file__).parent.parent / "docs/benchmarks/public_files.md"
START, STOP = "<!-- files -->\n", "<!-- /files -->\n"
#: Packages with their versions, as measured.
PACKAGES = {
    "airo-models": "0.0.12",
    "brax": "0.14.2",
    "dm-control": "1.0.50",
    "example-robot-data": "6.0.0",
    "genesis-world": "1.4.5",
    "gym-aloha": "0.1.5",
    "gymnasium": "1.4.0",
    "gymnasium-robotics": "1.4.2",
    "hello-robot-stretch-urdf": "0.1.2",
    "icub-models": "3.2.0",
    "mjlab": "1.6.0",
    "newton": "1.8.0",
    "pybullet": "3.2.7",
}
ENDINGS = (".urdf", ".xml", ".obj", ".stl", ".dae", ".msh", ".ply", ".glb")
#: The generated objects of PyBullet are alike: of its thousand folders these are read.
RANDOM, READ_RANDOM = "random_urdfs", ("000", "001")
#: Messages about files that hold no model of their own, such as parts of others.
FRAGMENTS = (
    "is neither a URDF nor an MJCF",
    "has no `worldbody`",
    "has no bodies",
    "has no links",
    "the base of the asset has no shape",
)
#: Messages about files that the native loader refuses too.
NATIVE = ("MuJoCo refuses it",)


def fetch(folder: Path) -> None:
    """Download the wheels and unpack their models and meshes."""
    for name, version in PACKAGES.items():
        wheels = folder / "wheels" / name
        subprocess.run(
            [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "-d", str(wheels), f"{name}=={version}"],
            check=True,
        )
        for wheel in wheels.glob("*.whl"):
            with zipfile.ZipFile(wheel) as archive:
                members = [m for m in archive.namelist() if m.lower().endswith(ENDINGS)]
                archive.extractall(folder / name, members)


def models(folder: Path) -> Iterator[Path]:
    """Yield the URDF and MJCF files of a package."""
    for path in sorted(folder.rglob("*")):
        if RANDOM in path.parts and path.parent.name not in READ_RANDOM:
            continue
        if path.suffix == ".urdf" or (path.suffix == ".xml" and b"<mujoco" in path.read_bytes()[:20_000]):
            yield path


def read_all(folder: Path) -> None:
    """Read the files of all packages; files with a result are skipped."""
    results = folder / "results.json"
    done: dict[str, Any] = json.loads(results.read_text()) if results.exists() else {}
    for name in PACKAGES:
        for path in models(folder / name):
            key = f"{name}/{path.relative_to(folder / name)}"
            if key not in done:
                made = read(folder / name, str(path.relative_to(folder / name)))
                faults = relevant_faults(made, {}, ())
                said = [f"{d.severity} {d.place}: {d.message}" for d in faults]
                done[key] = {"read": not isinstance(made, RejectedAsset), "faults": said}
                results.write_text(json.dumps(done, indent=1))


def counted(results: dict[str, Any]) -> str:
    """Return the page's tables: files by package, and reasons of refusals."""
    packages: dict[str, Counter[str]] = {name: Counter() for name in PACKAGES}
    refused: list[tuple[str, str, str]] = []
    for key, found in sorted(results.items()):
        package, _, path = key.partition("/")
        errors = [text.removeprefix("error ") for text in found["faults"] if text.startswith("error")]
        if found["read"]:
            packages[package]["exactly" if not found["faults"] else "approximately"] += 1
        elif any(words in errors[0] for words in FRAGMENTS):
            packages[package]["fragments"] += 1
        else:
            native = any(words in text for words in NATIVE for text in errors)
            packages[package]["native" if native else "refused"] += 1
            refused.append((f"`{package}`", f"`{Path(path).name}`", errors[0][:160]))
    whole = sum(packages.values(), Counter())
    read_, models_ = whole["exactly"] + whole["approximately"], sum(whole.values()) - whole["fragments"]
    columns = ("exactly", "approximately", "refused", "native", "fragments")
    rows = [(f"`{name}` {PACKAGES[name]}", *(str(packages[name][c]) for c in columns)) for name in PACKAGES]
    head = ("package", "read exactly", "read with warnings", "refused", "refused by MuJoCo too", "no model")
    text = f"Of {models_} models, wmspec reads {read_} ({100 * read_ / models_:.0f} %).\n\n"
    return text + "\n".join((*table(head, rows), *table(("package", "file", "refused because"), refused)))


def main() -> None:
    """Run one step."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("step", choices=["fetch", "read", "table"])
    parser.add_argument("folder", type=Path)
    chosen = parser.parse_args()
    if chosen.step == "fetch":
        fetch(chosen.folder)
    elif chosen.step == "read":
        read_all(chosen.folder)
    else:
        before, _, rest = PAGE.read_text().partition(START)
        made = counted(json.loads((chosen.folder / "results.json").read_text()))
        PAGE.write_text(f"{before}{START}\n{made}\n{STOP}{rest.partition(STOP)[2]}")


if __name__ == "__main__":
    main()
