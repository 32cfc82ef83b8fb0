"""Where graphics are missing, every command that draws says so with the remedy, and blames no instance for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.endtoend.test_commands import SPEED, wmspec

NO_EGL, NO_VULKAN = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/none"}, {"VK_DRIVER_FILES": "/none"}
RENDER, GENERATE = ["render", SPEED, "--size", "32"], ["generate", SPEED, "--per-task", "1", "--size", "32"]


@pytest.mark.parametrize(
    ("without", "arguments", "said"),
    [
        pytest.param(NO_EGL, [*RENDER, "-b", "mujoco"], "libegl1", marks=pytest.mark.slow),
        (NO_EGL, [*GENERATE, "-b", "mujoco"], "libegl1"),
        (NO_VULKAN, [*RENDER, "-b", "sapien"], "Mesa 24.3 or newer"),
        pytest.param(NO_VULKAN, [*GENERATE, "-b", "sapien"], "Mesa 24.3 or newer", marks=pytest.mark.slow),
    ],
    ids=lambda value: " ".join(map(str, value)) if isinstance(value, list) else "",
)
def test_missing_graphics_are_an_error(
    without: dict[str, str], arguments: list[str], said: str, tmp_path: Path
) -> None:
    pytest.importorskip(arguments[arguments.index("-b") + 1])
    reported = wmspec(*arguments, "-o", "out", folder=tmp_path, code=2, MUJOCO_GL="egl", **without).stderr
    assert said in reported
    assert "wmspec doctor" in reported
    assert len(reported.strip().splitlines()) <= 2, "one message"
