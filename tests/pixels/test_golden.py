"""Pictures stay as they are: one picture for all engines, by tolerance, since drivers round differently.

`WMSPEC_GOLDEN=write` redraws it (with MuJoCo); look at it before you commit it.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from wmspec.sim.scene.model import Scene, Shot

GOLDEN = Path(__file__).parent / "golden"


@pytest.mark.parametrize("view", ["front", "top", "oblique"])
def test_picture_is_the_golden_one(engine: str, view: str, table: Scene, renderer: Any) -> None:
    file = GOLDEN / f"{view}.png"
    rgb = renderer(engine, table, 128, 128).draw(Shot(view, [body.pose for body in table.bodies])).rgb
    if os.environ.get("WMSPEC_GOLDEN") == "write" and engine == "mujoco":
        Image.fromarray(rgb).save(file, optimize=True)
    apart = np.abs(rgb.astype(float) - np.array(Image.open(file)))
    assert apart.mean() < 2
    assert np.mean(apart.max(axis=2) > 16) < 0.04
