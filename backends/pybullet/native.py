"""The episode as a script for PyBullet."""

from __future__ import annotations

from wmspec.backends.pybullet import world
from wmspec.backends.pybullet.execute import prepare
from wmspec.scene.model import Scene
from wmspec.scene.rigid import Piece, Rigid
from wmspec.scene.script import script

CONSTANTS = ("HEAVY_MASS", "HEAVY_INERTIA", "DYNAMIC", "GIVEN", "ROUND", "HERE", "KINDS")
PARTS = (Piece, Rigid, world.World, world.xyzw, world.single, world.several)


def native(scene: Scene) -> dict[str, str]:
    """`run.py`: file name -> text. Raises WmsError for a scene that PyBullet can't honour."""
    bodies, timeline = prepare(scene)
    values = {name: getattr(world, name) for name in CONSTANTS} | {"BODIES": bodies, "EPISODE": timeline}
    line = "world = World(BODIES, EPISODE.gravity, EPISODE.step)"
    return {"run.py": script("PyBullet", "pybullet", scene, parts=PARTS, values=values, world=line)}
