"""Environments of their own for what cannot live in ours, or must be shown to need nothing of it.

They are made when a test first wants them and kept in the user's cache, by what is installed in them.
"""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import sys
import venv
from collections.abc import Sequence
from functools import cache
from hashlib import sha256
from pathlib import Path

import pytest

CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "wmspec/environments"
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--retries", "1", "--timeout", "30")


@cache
def python_with(*requirements: str) -> Path:
    """The Python of an environment that holds these and what they require. Skips if no registry is there."""
    name = sha256(repr((sys.version, requirements)).encode()).hexdigest()[:16]
    folder, done = CACHE / name, CACHE / name / "done"
    CACHE.mkdir(parents=True, exist_ok=True)
    with (CACHE / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # several workers may want it at once
        if not done.exists():
            shutil.rmtree(folder, ignore_errors=True)
            venv.create(folder, with_pip=False)
            _install(folder / "bin/python", requirements)
            done.write_text("\n".join(requirements) + "\n")
    return folder / "bin/python"


def _install(python: Path, requirements: Sequence[str]) -> None:
    found = _run([*PIP, "--python", str(python), "install", "-q", "--prefer-binary", *requirements])
    if found.returncode and _run([*PIP, "download", "-q", "--no-deps", "-d", str(CACHE / "probe"), "pip"]).returncode:
        pytest.skip(f"needs {', '.join(requirements)}, and no package registry can be reached")
    assert found.returncode == 0, found.stderr


def run(python: Path, *arguments: str | Path, folder: Path) -> str:
    """What a program prints, run in that environment from a folder, without sight of this checkout."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PXR_"))}
    found = _run([str(python), "-I", *map(str, arguments)], folder, clean)
    assert found.returncode == 0, f"{found.stdout}\n{found.stderr}"
    return found.stdout


def _run(
    command: Sequence[str], folder: Path | None = None, environment: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
