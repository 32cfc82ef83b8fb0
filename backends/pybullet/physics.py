"""Run a scene in PyBullet."""

from __future__ import annotations

from wmspec.core.native_output import silence
from wmspec.sim.scene.capability import require
from wmspec.sim.scene.joints.drives import enough
from wmspec.sim.scene.model import Scene, Trace
from wmspec.sim.scene.physics.episode import Episode, Recording, play, told
from wmspec.sim.scene.physics.readback import readback
from wmspec.sim.scene.physics.rigid import Assembly, assembly
from wmspec.sim.scene.physics.timeline import episode
from wmspec.sim.scene.physics.to_trace import trace
from wmspec.sim.scene.validate import validate

from .collision_margin import within_margins
from .cylinders import footed
from .info import INFO
from .world import World

with silence():
    import pybullet


def execute(scene: Scene) -> Trace:
    """The trace of the scene's episode.

    Raises WmsError for a scene that PyBullet can't honour, EngineError when PyBullet loses track of it.
    """
    whole, timeline = prepare(scene)
    return trace(INFO.name, scene, timeline, told(timeline) or _played(scene, whole, timeline))


def _played(scene: Scene, whole: Assembly, timeline: Episode) -> Recording:
    world = World(whole)
    try:
        verify(world, scene, timeline)
        return play(world, timeline)
    finally:
        world.close()


def prepare(scene: Scene) -> tuple[Assembly, Episode]:
    """The scene in PyBullet's words. Raises WmsError, with the prim path, for what PyBullet doesn't have."""
    validate(scene)
    require(INFO.lacks, scene)
    timeline = episode(scene, enough(scene, INFO.steps_per_second))
    return within_margins(footed(assembly(scene, timeline))), timeline


def verify(world: World, scene: Scene, timeline: Episode) -> None:
    """Raise WmsError unless PyBullet has the scene's physics (it doesn't tell restitution and limits)."""
    engine = pybullet.getPhysicsEngineParameters(physicsClientId=world.client)
    readback("PyBullet", "the time step", engine["fixedTimeStep"], timeline.step)
    gravity = [engine[f"gravityAcceleration{axis}"] for axis in "XYZ"]
    readback("PyBullet", "gravity", gravity, scene.gravity)
    for i, (body, rigid) in enumerate(zip(scene.bodies, world.bodies, strict=True)):
        if body.motion != "dynamic":
            continue
        mass, friction, moments = pybullet.getDynamicsInfo(*world.ids[i], physicsClientId=world.client)[:3]
        readback(body.path, "the mass", mass, rigid.mass)
        readback(body.path, "the inertia", moments, rigid.moments)
        if rigid.pieces:
            readback(body.path, "friction", friction**2, rigid.pieces[0].material[1])
