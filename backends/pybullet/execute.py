"""Run a scene in PyBullet."""

from __future__ import annotations

from wmspec.backends.pybullet.world import World
from wmspec.errors import WmsError
from wmspec.scene.contact import colliders
from wmspec.scene.episode import Episode, play
from wmspec.scene.honoured import honoured
from wmspec.scene.model import Body, Cone, Mesh, Scene, Trace
from wmspec.scene.recording import trace
from wmspec.scene.rigid import Rigid, rigids
from wmspec.scene.silence import silence
from wmspec.scene.timeline import episode
from wmspec.scene.validate import validate

with silence():
    import pybullet

STEPS_PER_SECOND = 1920
MOST_FRICTION = 10.0  # of a pair: Bullet's own limit


def execute(scene: Scene) -> Trace:
    """The trace of the scene's episode.

    Raises WmsError for a scene that PyBullet can't honour, EngineError when PyBullet loses track of it.
    """
    bodies, timeline = prepare(scene)
    world = World(bodies, timeline.gravity, timeline.step)
    try:
        verify(world, scene, timeline)
        recording = play(world, timeline)
    finally:
        world.close()
    return trace("pybullet", scene, timeline, recording)


def prepare(scene: Scene) -> tuple[tuple[Rigid, ...], Episode]:
    """The scene in PyBullet's words. Raises WmsError, with the prim path, for what PyBullet doesn't have."""
    validate(scene)
    problems = [f"{body.path}: {problem}" for body in scene.bodies for problem in _unsupported(body)]
    if problems:
        raise WmsError("\n".join(problems))
    return rigids(scene), episode(scene, STEPS_PER_SECOND)


def _unsupported(body: Body) -> list[str]:
    geoms = colliders(body)
    materials = {geom.friction for geom in geoms}
    problems = [
        f"friction {f.dynamic:g} is above PyBullet's limit of {MOST_FRICTION:g}"
        for f in sorted(materials, key=str)
        if f.dynamic > MOST_FRICTION
    ]
    if body.motion != "static" and len(materials) > 1:
        problems.append("its pieces differ in friction or restitution, but PyBullet has one material a moving body")
    if body.motion != "static" and len(geoms) > 1 and any(isinstance(g.shape, Cone | Mesh) for g in geoms):
        problems.append(
            "PyBullet can't join a cone or a mesh with other shapes in a moving body; use boxes or cylinders"
        )
    return problems


def verify(world: World, scene: Scene, timeline: Episode) -> None:
    """Raise WmsError unless PyBullet has the scene's physics (it doesn't tell restitution)."""
    engine = pybullet.getPhysicsEngineParameters(physicsClientId=world.client)
    honoured("PyBullet", "the time step", engine["fixedTimeStep"], timeline.step)
    gravity = [engine[f"gravityAcceleration{axis}"] for axis in "XYZ"]
    honoured("PyBullet", "gravity", gravity, scene.gravity)
    for i, (body, rigid) in enumerate(zip(scene.bodies, world.bodies, strict=True)):
        if body.motion != "dynamic":
            continue
        mass, friction, moments = pybullet.getDynamicsInfo(world.ids[i], -1, physicsClientId=world.client)[:3]
        honoured(body.path, "the mass", mass, rigid.mass)
        honoured(body.path, "the inertia", moments, rigid.moments)
        if rigid.pieces:
            honoured(body.path, "friction", friction**2, rigid.pieces[0].material[1])
