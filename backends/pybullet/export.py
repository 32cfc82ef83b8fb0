"""Native output for PyBullet."""

from __future__ import annotations

from wmspec.sim.scene.joints.articulations import Link, LoopClosure, MimicConstraint
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics import rest
from wmspec.sim.scene.physics.rigid import Assembly, CollisionShape, Rigid
from wmspec.sim.scene.script import episode_script

from . import articulations, shapes, world
from .physics import prepare

CONSTANTS = {
    world: (
        "SOLVER_ITERATIONS",
        "SOLVER_RESIDUAL",
        "HEAVY_MASS",
        "HEAVY_INERTIA",
        "DYNAMIC",
        "PRESCRIBED",
        "ROUND",
        "SOFT_ERP",
        "TIE_FORCE",
        "MAX_JOINT_SPEED",
    ),
    rest: rest.CONSTANTS,
    shapes: ("IDENTITY_POSE", "KINDS"),
    articulations: ("JOINTS", "SELF_COLLISION_FLAGS"),
}
PARTS = (
    *(CollisionShape, Rigid, Link, LoopClosure, MimicConstraint, Assembly),
    *(rest.Rest, rest.is_moving, rest.bounding_box, rest.box_corners, rest.box_distance),
    *(shapes.shape, shapes.relative_pose, shapes.xyzw, shapes.single, shapes.several, shapes.objects),
    *(articulations.add_multibody, articulations.depth_first, articulations.disable_motor, articulations.reset_tree),
    world.World,
)


def native(scene: Scene) -> dict[str, str]:
    """Return `run.py`: file name -> text. Raises WmsError for a scene that PyBullet does not support."""
    whole, timeline = prepare(scene)
    constants = {name: getattr(module, name) for module, names in CONSTANTS.items() for name in names}
    values = constants | {"ASSEMBLY": whole, "EPISODE": timeline}
    line = "world = World(ASSEMBLY)"
    return {"run.py": episode_script("PyBullet", "pybullet", scene, parts=PARTS, values=values, world=line)}
