"""Native output for PyBullet."""

from __future__ import annotations

from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics import rest
from wmspec.sim.scene.script import episode_script

from . import articulations, shapes, world
from .physics import prepare


def native(scene: Scene) -> dict[str, str]:
    """Return `run.py`: file name -> text. Raises WmsError for a scene that PyBullet does not support."""
    whole, timeline = prepare(scene)
    parts, values = (rest, shapes, articulations, world), {"ASSEMBLY": whole, "EPISODE": timeline}
    line = "world = World(ASSEMBLY)"
    return {"run.py": episode_script("PyBullet", "pybullet", scene, parts=parts, values=values, world=line)}
