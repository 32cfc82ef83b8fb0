"""Native output for SAPIEN."""

from __future__ import annotations

from wmspec.sim.scene.joints.articulations import Link, LoopClosure, MimicConstraint, ancestors
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics import rest
from wmspec.sim.scene.physics.rigid import Assembly, CollisionShape, Rigid
from wmspec.sim.scene.script import episode_script

from . import joints, shapes, world
from .physics import landing_bodies, prepare

CONSTANTS = {
    world: (
        "MAX_SPIN",
        "MAX_SEPARATION_SPEED",
        "POSITION_ITERATIONS",
        "VELOCITY_ITERATIONS",
        "LANDING_ITERATIONS",
        "JUMP_DISTANCE",
    ),
    rest: rest.CONSTANTS,
    shapes: ("CONTACT_OFFSET", "ALONG_X"),
    joints: ("JOINTS", "MIMIC_FREQUENCY", "MIMIC_DAMPING", "MAX_JOINT_SPEED"),
}
PARTS = (
    *(CollisionShape, Rigid, Link, LoopClosure, MimicConstraint, Assembly),
    *(rest.Rest, rest.is_moving, rest.bounding_box, rest.box_corners, rest.box_distance),
    *(
        joints.split_at_ball_joints,
        joints.connect,
        joints.couple,
        ancestors,
        joints.ball,
        joints.collision_words,
        joints.frame,
    ),
    *(shapes.lanes, shapes.geometric_mean, shapes.groups, shapes.shape),
    *(world.World, world.entity, world.solve, world.iterate),
)


def native(scene: Scene) -> dict[str, str]:
    """Return `run.py`: file name -> text. Raises WmsError for a scene that SAPIEN does not support."""
    whole, timeline = prepare(scene)
    constants = {name: getattr(module, name) for module, names in CONSTANTS.items() for name in names}
    values = constants | {"ASSEMBLY": whole, "LANDING": landing_bodies(scene), "EPISODE": timeline}
    made = "world = World(ASSEMBLY, LANDING)"
    return {"run.py": episode_script("SAPIEN", "sapien", scene, parts=PARTS, values=values, world=made)}
