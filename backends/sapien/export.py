"""Native output for SAPIEN."""

from __future__ import annotations

from wmspec.sim.scene.joints.articulations import ancestors
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics import rest
from wmspec.sim.scene.script import episode_script

from . import joints, shapes, world
from .physics import landing_bodies, prepare


def native(scene: Scene) -> dict[str, str]:
    """Return `run.py`: file name -> text. Raises WmsError for a scene that SAPIEN does not support."""
    whole, timeline = prepare(scene)
    parts = (rest, joints, ancestors, shapes, world)
    values = {"ASSEMBLY": whole, "LANDING": landing_bodies(scene), "EPISODE": timeline}
    made = "world = World(ASSEMBLY, LANDING)"
    return {"run.py": episode_script("SAPIEN", "sapien", scene, parts=parts, values=values, world=made)}
