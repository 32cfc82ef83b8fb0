"""Filament, opened once for a process.

Where it can't be opened it ends the process without a chance to say so: another process, this file, tries first.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from functools import cache
from typing import Any

from wmspec.diagnostics import GraphicsError
from wmspec.scene.silence import silence


@cache
def filament() -> tuple[Any, Any]:
    """Filament's module and a context of it, kept for all renderers. Raises GraphicsError where there is none."""
    command = [sys.executable, "-m", "wmspec.backends.mujoco.filament"]
    tried = subprocess.run(command, capture_output=True, text=True, check=False)
    if tried.returncode:
        words = tried.stderr.strip().splitlines() or ["it ends without a word"]
        raise GraphicsError(
            f"MuJoCo can't draw the look 'beauty': no Filament on Vulkan ({words[-1]}); it needs the package "
            "mujoco-studio and, without a GPU, Mesa 24.3 or newer (Debian: mesa-vulkan-drivers), see 'wmspec doctor'"
        )
    with silence():
        return _opened()


def _opened() -> tuple[Any, Any]:
    importlib.import_module("mujoco.studio")  # tells Filament where its materials are
    mjrf = importlib.import_module("mujoco.mjrf")
    return mjrf, mjrf.Context(mjrf.ContextConfig(graphics_api=mjrf.GraphicsApi.GRAPHICS_API_VULKAN))


if __name__ == "__main__":
    _opened()
