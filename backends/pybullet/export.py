"""The episode as a script for PyBullet."""

from __future__ import annotations

from wmspec.sim.scene.joints.articulations import Gear, Link, Tie
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics.rigid import Assembly, Piece, Rigid
from wmspec.sim.scene.script import script

from . import articulations, shapes, world
from .physics import prepare

CONSTANTS = {
    world: (
        "ITERATE",
        "SETTLED",
        "HEAVY_MASS",
        "HEAVY_INERTIA",
        "DYNAMIC",
        "GIVEN",
        "ROUND",
        "SOFT_ERP",
        "TIE_FORCE",
        "FASTEST",
    ),
    shapes: ("HERE", "KINDS"),
    articulations: ("JOINTS", "MEETING"),
}
PARTS = (
    *(Piece, Rigid, Link, Tie, Gear, Assembly),
    *(shapes.shape, shapes.inside, shapes.xyzw, shapes.single, shapes.several, shapes.objects),
    *(articulations.branches, articulations.depth_first, articulations.still, articulations.put),
    world.World,
)


def native(scene: Scene) -> dict[str, str]:
    """`run.py`: file name -> text. Raises WmsError for a scene that PyBullet can't honour."""
    whole, timeline = prepare(scene)
    constants = {name: getattr(module, name) for module, names in CONSTANTS.items() for name in names}
    values = constants | {"ASSEMBLY": whole, "EPISODE": timeline}
    line = "world = World(ASSEMBLY)"
    return {"run.py": script("PyBullet", "pybullet", scene, parts=PARTS, values=values, world=line)}
