"""Run a scene in SAPIEN."""

from __future__ import annotations

from wmspec.core.diagnostics import StageError
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.capability import require
from wmspec.sim.scene.model import Scene, Trace
from wmspec.sim.scene.physics.episode import Episode, Recording, play, told
from wmspec.sim.scene.physics.initial_drops import landings
from wmspec.sim.scene.physics.readback import readback
from wmspec.sim.scene.physics.rigid import Assembly, assembly
from wmspec.sim.scene.physics.timeline import episode
from wmspec.sim.scene.physics.to_trace import trace
from wmspec.sim.scene.validate import validate

from .cylinders import barrels
from .info import INFO
from .joints import ignored, once_limited
from .shapes import BITS, lanes, mean
from .world import World

SINGLE = 1e-6  # PhysX computes with 32 bits


def execute(scene: Scene) -> Trace:
    """The trace of the scene's episode.

    Raises WmsError for a scene that SAPIEN can't honour, EngineError when SAPIEN loses track of it.
    """
    whole, timeline = prepare(scene)
    return trace(INFO.name, scene, timeline, told(timeline) or _played(scene, whole, timeline))


def _played(scene: Scene, whole: Assembly, timeline: Episode) -> Recording:
    world = World(whole, landing(scene))
    verify(world, scene, timeline)
    return play(world, timeline)


def prepare(scene: Scene) -> tuple[Assembly, Episode]:
    """The scene in SAPIEN's words. Raises StageError, with the prim path, for what SAPIEN doesn't have."""
    validate(scene)
    require(INFO.lacks, scene)
    timeline = episode(scene, INFO.steps_per_second)
    whole = once_limited(barrels(assembly(scene, timeline)))
    bodies, needed = whole.bodies, lanes(whole.bodies)
    over = {material for pair, bit in needed.items() if bit >= BITS for material in pair}
    if over:
        paths = [b.path for b, r in zip(scene.bodies, bodies, strict=True) if over & {p.material for p in r.pieces}]
        raise StageError(
            f"SAPIEN tells {BITS} pairs of touching materials apart, this scene has {len(needed)}",
            PrimPlace(", ".join(paths)),
            "give some bodies the same friction and restitution",
        )
    if any(word >= 1 << BITS for word, _ in ignored(whole.apart, len(bodies))):
        raise StageError(
            f"SAPIEN tells {BITS} groups of bodies apart that pass through each other, this scene has more",
            PrimPlace(scene.name),
            "filter fewer pairs",
        )
    return whole, timeline


def landing(scene: Scene) -> tuple[int, ...]:
    """The numbers of the bodies that begin above others, and of those."""
    return tuple(sorted({number for pair in landings(scene) for number in pair}))


def verify_joints(world: World, scene: Scene) -> None:
    """Raise WmsError unless SAPIEN has the scene's limits and drives."""
    for limb in dict.fromkeys(limb for tree in world.trees.values() for limb in tree):
        path = scene.joints[limb.joint].path
        if limb.limits:
            readback(path, "the limits", world.joints[limb.joint].limits[0], limb.limits, tolerance=SINGLE)
        if limb.drive:
            joint = world.joints[limb.joint]
            readback(path, "the drive", [joint.stiffness, joint.damping], limb.drive[:2], tolerance=SINGLE)


def verify(world: World, scene: Scene, timeline: Episode) -> None:
    """Raise WmsError unless SAPIEN has the scene's physics."""
    readback("SAPIEN", "the time step", world.scene.get_timestep(), timeline.step, tolerance=SINGLE)
    readback("SAPIEN", "gravity", world.system.config.gravity, scene.gravity, tolerance=SINGLE)
    verify_joints(world, scene)
    for body, rigid, part in zip(scene.bodies, world.bodies, world.parts, strict=True):
        if body.motion == "dynamic":
            readback(body.path, "the mass", part.mass, rigid.mass, tolerance=SINGLE)
            readback(body.path, "the inertia", part.inertia, rigid.moments, tolerance=SINGLE)
        wanted = [mean(*pair) for piece in rigid.pieces for pair in world.lanes if piece.material in pair]
        made = [shape.physical_material for shape in part.collision_shapes]
        have = [[m.static_friction, m.dynamic_friction, m.restitution] for m in made]
        readback(body.path, "friction and restitution", have, wanted, tolerance=SINGLE)
