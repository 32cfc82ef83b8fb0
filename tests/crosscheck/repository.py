"""A fresh git repository with two specs: engines agree on `race`, and disagree on `tumble`."""

from __future__ import annotations

import subprocess
from pathlib import Path

HERE = Path(__file__).parent
PAIR = "mujoco,sapien"
LIBRARY = '''"""A plate that bounces."""
use room

object plate { shape: box  size: (6 m, 6 m, 2 cm)  restitution: 0.9  on: floor  fixed: true }
'''


def git(folder: Path, *arguments: str) -> str:
    identity = ("-c", "user.name=tester", "-c", "user.email=tester@example.org", "-c", "commit.gpgsign=false")
    command = ["git", "-C", str(folder), *identity, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def make(folder: Path) -> Path:
    """Create the repository; `tumble` uses a library of its own."""
    specs = folder / "specs"
    specs.mkdir(parents=True)
    (specs / "race.wms").write_text((HERE / "race.wms").read_text())
    tumble = (HERE / "tumble.wms").read_text().splitlines(keepends=True)
    text = "".join(line for line in tumble if "object plate" not in line).replace("use room\n", "use room\nuse plate\n")
    (specs / "tumble.wms").write_text(text)
    (specs / "plate.wms").write_text(LIBRARY)
    git(folder, "init", "--quiet", "--initial-branch", "main")
    commit(folder)
    return folder


def commit(folder: Path) -> None:
    git(folder, "add", "--all")
    git(folder, "commit", "--quiet", "--message", "change")
