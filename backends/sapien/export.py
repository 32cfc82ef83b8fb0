"""The episode as a script for SAPIEN."""

from __future__ import annotations

from wmspec.sim.scene.joints.articulations import Gear, Link, Tie, ascent
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics.rigid import Assembly, Piece, Rigid
from wmspec.sim.scene.script import script

from . import joints, shapes, world
from .physics import landing, prepare

CONSTANTS = {
    world: ("FASTEST_SPIN", "APART", "POSITION_ITERATIONS", "VELOCITY_ITERATIONS", "LANDING_ITERATIONS", "JUMP"),
    shapes: ("CONTACT_OFFSET", "ALONG_X"),
    joints: ("JOINTS", "STIFFEST", "DAMPED", "FASTEST_JOINT"),
}
PARTS = (
    *(Piece, Rigid, Link, Tie, Gear, Assembly),
    *(
        joints.branches,
        joints.connect,
        joints.couple,
        ascent,
        joints.ball,
        joints.ignored,
        joints.frame,
    ),
    *(shapes.lanes, shapes.mean, shapes.groups, shapes.shape),
    *(world.World, world.entity, world.solve, world.iterate),
)


def native(scene: Scene) -> dict[str, str]:
    """`run.py`: file name -> text. Raises WmsError for a scene that SAPIEN can't honour."""
    whole, timeline = prepare(scene)
    constants = {name: getattr(module, name) for module, names in CONSTANTS.items() for name in names}
    values = constants | {"ASSEMBLY": whole, "LANDING": landing(scene), "EPISODE": timeline}
    made = "world = World(ASSEMBLY, LANDING)"
    return {"run.py": script("SAPIEN", "sapien", scene, parts=PARTS, values=values, world=made)}
