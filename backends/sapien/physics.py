"""Executes scenes in SAPIEN."""

from __future__ import annotations

from dataclasses import replace

from wmspec.core.diagnostics import StageError
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.capability import require
from wmspec.sim.scene.joints.articulations import MimicConstraint
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.physics.episode import Episode, Recording, play
from wmspec.sim.scene.physics.initial_drops import initial_drops
from wmspec.sim.scene.physics.readback import require_equal
from wmspec.sim.scene.physics.rigid import Assembly, assembly
from wmspec.sim.scene.physics.timeline import episode
from wmspec.sim.scene.validate import validate

from .cylinders import add_rolling_capsules
from .info import INFO
from .joints import collision_words
from .shapes import BITS, geometric_mean, lanes
from .world import World

SINGLE_PRECISION = 1e-6  # PhysX uses 32-bit floats
LIMIT_EPSILON = 1e-6  # rad or m: tolerance of limits in 32-bit floats


def record(scene: Scene, whole: Assembly, timeline: Episode) -> Recording:
    """Return the recording of an episode. Raises EngineError if the engine fails."""
    world = World(whole, landing_bodies(scene))
    verify(world, scene, timeline)
    return play(world, timeline)


def prepare(scene: Scene) -> tuple[Assembly, Episode]:
    """Return assembly and timeline of a scene. Raises StageError with the prim path of unsupported features."""
    validate(scene)
    require(INFO.lacks, scene)
    timeline = episode(scene, INFO.steps_per_second)
    whole = without_redundant_limits(add_rolling_capsules(assembly(scene, timeline)))
    bodies, needed = whole.bodies, lanes(whole.bodies)
    over = {material for pair, bit in needed.items() if bit >= BITS for material in pair}
    if over:
        paths = [b.path for b, r in zip(scene.bodies, bodies, strict=True) if over & {p.material for p in r.pieces}]
        raise StageError(
            f"SAPIEN tells {BITS} pairs of materials, this scene has {len(needed)}",
            PrimPlace(", ".join(paths)),
            "give some bodies the same friction and restitution",
        )
    if any(word >= 1 << BITS for word, _ in collision_words(whole.non_colliding_pairs, len(bodies))):
        raise StageError(
            f"SAPIEN tells {BITS} groups of non-colliding bodies, this scene has more",
            PrimPlace(scene.name),
            "filter fewer pairs",
        )
    return whole, timeline


def without_redundant_limits(assembly: Assembly) -> Assembly:
    """Return the joints without limits that mimic joints enforce already.

    With both limits active PhysX drifts: closed gripper fingers were 59 mm apart after 1 s.
    """
    limits = {limb.body: limb.limits for tree in assembly.trees for limb in tree}
    kept = {gear.leader for gear in assembly.mimic_constraints if _within(gear, limits[gear.body], limits[gear.leader])}
    trees = (tuple(replace(limb, limits=()) if limb.body in kept else limb for limb in tree) for tree in assembly.trees)
    return replace(assembly, trees=tuple(trees))


def _within(gear: MimicConstraint, mimics: tuple[float, ...], leads: tuple[float, ...]) -> bool:
    """Whether the limits of a mimic joint keep its leader within its own."""
    if not mimics or not leads or not gear.ratio:
        return False
    low, high = sorted((end - gear.offset) / gear.ratio for end in mimics)
    return leads[0] - LIMIT_EPSILON <= low and high <= leads[1] + LIMIT_EPSILON


def landing_bodies(scene: Scene) -> tuple[int, ...]:
    """Return the numbers of bodies that start above others, and of those below."""
    return tuple(sorted({number for pair in initial_drops(scene) for number in pair}))


def verify_joints(world: World, scene: Scene) -> None:
    """Raise WmsError unless SAPIEN has the limits and drives of the scene."""
    for limb in dict.fromkeys(limb for tree in world.trees.values() for limb in tree):
        path = scene.joints[limb.joint].path
        if limb.limits:
            require_equal(
                path, "the limits", world.joints[limb.joint].limits[0], limb.limits, tolerance=SINGLE_PRECISION
            )
        if limb.drive:
            joint = world.joints[limb.joint]
            require_equal(
                path, "the drive", [joint.stiffness, joint.damping], limb.drive[:2], tolerance=SINGLE_PRECISION
            )


def verify(world: World, scene: Scene, timeline: Episode) -> None:
    """Raise WmsError unless SAPIEN has the physics of the scene."""
    require_equal("SAPIEN", "the time step", world.scene.get_timestep(), timeline.step, tolerance=SINGLE_PRECISION)
    require_equal("SAPIEN", "gravity", world.system.config.gravity, scene.gravity, tolerance=SINGLE_PRECISION)
    verify_joints(world, scene)
    for body, rigid, part in zip(scene.bodies, world.bodies, world.parts, strict=True):
        if body.motion == "dynamic":
            require_equal(body.path, "the mass", part.mass, rigid.mass, tolerance=SINGLE_PRECISION)
            require_equal(body.path, "the inertia", part.inertia, rigid.moments, tolerance=SINGLE_PRECISION)
        expected = [geometric_mean(*pair) for piece in rigid.pieces for pair in world.lanes if piece.material in pair]
        made = [shape.physical_material for shape in part.collision_shapes]
        have = [[m.static_friction, m.dynamic_friction, m.restitution] for m in made]
        require_equal(body.path, "friction and restitution", have, expected, tolerance=SINGLE_PRECISION)
