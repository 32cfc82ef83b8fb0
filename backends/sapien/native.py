"""The episode as a script for SAPIEN."""

from __future__ import annotations

from wmspec.backends.sapien import world
from wmspec.backends.sapien.execute import prepare
from wmspec.scene.model import Scene
from wmspec.scene.rigid import Piece, Rigid
from wmspec.scene.script import script

CONSTANTS = ("CONTACT_OFFSET", "FASTEST_SPIN", "ALONG_X", "JUMP")
PARTS = (Piece, Rigid, world.World, world.lanes, world.mean, world.groups, world.shape, world.solve, world.pose)


def native(scene: Scene) -> dict[str, str]:
    """`run.py`: file name -> text. Raises WmsError for a scene that SAPIEN can't honour."""
    bodies, timeline = prepare(scene)
    values = {name: getattr(world, name) for name in CONSTANTS} | {"BODIES": bodies, "EPISODE": timeline}
    line = "world = World(BODIES, EPISODE.gravity, EPISODE.step)"
    return {"run.py": script("SAPIEN", "sapien", scene, parts=PARTS, values=values, world=line)}
