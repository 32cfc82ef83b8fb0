"""The episode as a script for PyBullet."""

from __future__ import annotations

from wmspec.backends.pybullet import shapes, trees, world
from wmspec.backends.pybullet.execute import prepare
from wmspec.scene.model import Scene
from wmspec.scene.rigid import Assembly, Piece, Rigid
from wmspec.scene.script import script
from wmspec.scene.trees import Limb

CONSTANTS = {
    world: ("HEAVY_MASS", "HEAVY_INERTIA", "DYNAMIC", "GIVEN", "ROUND", "SOFT_ERP", "FASTEST"),
    shapes: ("HERE", "KINDS"),
    trees: ("JOINTS", "MEETING"),
}
PARTS = (
    *(Piece, Rigid, Limb, Assembly),
    *(shapes.shape, shapes.inside, shapes.xyzw, shapes.single, shapes.several, shapes.objects),
    *(trees.branches, trees.still, trees.put),
    world.World,
)


def native(scene: Scene) -> dict[str, str]:
    """`run.py`: file name -> text. Raises WmsError for a scene that PyBullet can't honour."""
    whole, timeline = prepare(scene)
    constants = {name: getattr(module, name) for module, names in CONSTANTS.items() for name in names}
    values = constants | {"ASSEMBLY": whole, "EPISODE": timeline}
    line = "world = World(ASSEMBLY)"
    return {"run.py": script("PyBullet", "pybullet", scene, parts=PARTS, values=values, world=line)}
