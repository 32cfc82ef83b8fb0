"""Executes scenes in PyBullet."""

from __future__ import annotations

from wmspec.core.native_output import silence
from wmspec.sim.scene.capability import require
from wmspec.sim.scene.joints.drives import required_step_rate
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics.episode import Episode, Recording, play
from wmspec.sim.scene.physics.readback import require_equal
from wmspec.sim.scene.physics.rigid import Assembly, assembly
from wmspec.sim.scene.physics.timeline import episode
from wmspec.sim.scene.validate import validate

from .collision_margin import shrink_by_margin
from .cylinders import add_support_boxes
from .info import INFO
from .world import World

with silence():
    import pybullet


def record(scene: Scene, whole: Assembly, timeline: Episode) -> Recording:
    """Return the recording of an episode. Raises EngineError if the engine fails."""
    world = World(whole)
    try:
        verify(world, scene, timeline)
        return play(world, timeline)
    finally:
        world.close()


def prepare(scene: Scene) -> tuple[Assembly, Episode]:
    """Return assembly and timeline of a scene. Raises WmsError with the prim path of unsupported features."""
    validate(scene)
    require(INFO.lacks, scene)
    timeline = episode(scene, required_step_rate(scene, INFO.steps_per_second))
    return shrink_by_margin(add_support_boxes(assembly(scene, timeline))), timeline


def verify(world: World, scene: Scene, timeline: Episode) -> None:
    """Raise WmsError unless PyBullet has the physics of the scene (it does not report restitution and limits)."""
    engine = pybullet.getPhysicsEngineParameters(physicsClientId=world.client)
    require_equal("PyBullet", "the time step", engine["fixedTimeStep"], timeline.step)
    gravity = [engine[f"gravityAcceleration{axis}"] for axis in "XYZ"]
    require_equal("PyBullet", "gravity", gravity, scene.gravity)
    for i, (body, rigid) in enumerate(zip(scene.bodies, world.bodies, strict=True)):
        if body.motion != "dynamic":
            continue
        mass, friction, moments = pybullet.getDynamicsInfo(*world.ids[i], physicsClientId=world.client)[:3]
        require_equal(body.path, "the mass", mass, rigid.mass)
        require_equal(body.path, "the inertia", moments, rigid.moments)
        if rigid.pieces:
            require_equal(body.path, "friction", friction**2, rigid.pieces[0].material[1])
