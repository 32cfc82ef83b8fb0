"""Tries a spec for the page of `watch` and for editors: `wmspec check --try` in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

#: Instances of each task, and the time limit (s).
INSTANCES, TIMEOUT = 4, 300


def try_spec(path: Path, engine: str = "") -> str:
    """Return what `wmspec check --try` prints of a saved spec."""
    command = [sys.executable, "-m", "wmspec", "check", str(path.resolve()), "--try", str(INSTANCES)]
    command += ["--backend", engine] if engine else []
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)
    except subprocess.TimeoutExpired:
        return f"the trial took longer than {TIMEOUT} s"
    printed = done.stdout.strip()
    return printed if printed else done.stderr.strip()
