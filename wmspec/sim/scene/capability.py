"""Features of stages, and which engines lack them: source of refusals, `wmspec doctor` and the capability matrix."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from math import atan, degrees

from wmspec.core.diagnostics import Diagnostic, Report, StageError
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import ancestors, loop_joints, trees
from wmspec.sim.scene.joints.drives import mobility, too_damped, too_stiff
from wmspec.sim.scene.model import PassThrough, Scene
from wmspec.sim.scene.physics.contact import colliders
from wmspec.sim.scene.physics.speed import max_speed, min_thickness, step_multiplier
from wmspec.sim.scene.regime_thresholds import MAX_ENTERED_FRACTION

Occurrences = Iterator[tuple[str, str]]
"""Pairs of prim path and description."""


def _nowhere(_scene: Scene) -> Occurrences:
    yield from ()


@dataclass(frozen=True)
class Capability:
    """A feature that a stage may use; `asked` finds its uses in a scene."""

    name: str
    occurrences: Callable[[Scene], Occurrences] = _nowhere


@dataclass(frozen=True)
class Lack:
    """A feature that an engine lacks, the reason and the alternative."""

    capability: Capability
    reason: str
    #: Whether the engine approximates the feature instead of refusing it.
    approximate: bool = False


def require(lacks: Iterable[Lack], scene: Scene, *, strict: bool = False) -> None:
    """Raise StageError with the prim paths of all features of a valid scene that an engine lacks.

    With `strict`, approximated features count as lacking.
    """
    report = Report(StageError)
    for lack in lacks:
        if strict or not lack.approximate:
            report.include(
                Diagnostic(what, PrimPlace(path), lack.reason) for path, what in lack.capability.occurrences(scene)
            )
    report.stop_if_failed()


def approximation_warnings(lacks: Iterable[Lack], scene: Scene) -> tuple[Diagnostic, ...]:
    """Return a warning for each feature of a valid scene that an engine approximates."""
    return tuple(
        Diagnostic(f"{what} ({lack.reason})", PrimPlace(path), severity="warning")
        for lack in lacks
        if lack.approximate
        for path, what in lack.capability.occurrences(scene)
    )


APPROXIMATE = "nearly: "
"""Prefix of the reason of an approximated feature."""


def capability_table(engines: Mapping[str, Iterable[Lack]]) -> list[tuple[str, dict[str, str]]]:
    """Return all features and, for each engine, the reason why it lacks or approximates them, or ''.

    Common features come first, then features that some engine lacks, then features that no engine supports.
    """
    rows: dict[str, dict[str, str]] = {capability.name: {} for capability in COMMON}
    for engine, lacks in engines.items():
        for lack in lacks:
            rows.setdefault(lack.capability.name, {})[engine] = (
                f"{APPROXIMATE if lack.approximate else ''}{lack.reason}"
            )
    rows |= {name: dict.fromkeys(engines, why) for name, why in NEVER_SUPPORTED.items()}
    return [(name, {engine: reasons.get(engine, "") for engine in engines}) for name, reasons in rows.items()]


# ---------------------------------------------------------------- occurrences in scenes


def _meshes(scene: Scene) -> Occurrences:
    for body in scene.bodies:
        if any(not geom.shape.prims for geom in colliders(body)):
            yield body.path, "a mesh that collides"


def _jointed(scene: Scene) -> Occurrences:
    yield from ((joint.path, f"a joint ({joint.kind})") for joint in scene.joints)


def _filtered(scene: Scene) -> Occurrences:
    paths = {body.name: body.path for body in scene.bodies}
    yield from ((paths[first], f"{second} that does not collide with it") for first, second in scene.filtered)


def _belts(scene: Scene) -> Occurrences:
    yield from ((body.path, "a belt") for body in scene.bodies if any(body.surface_velocity))


def _passages(scene: Scene) -> Occurrences:
    paths = {body.name: body.path for body in scene.bodies}
    for action in scene.actions:
        if isinstance(action, PassThrough):
            yield paths[action.body], f"{action.name}, by which it goes through {action.through}"


def _cones(scene: Scene) -> Occurrences:
    yield from ((j.path, "a ball joint with limits") for j in scene.joints if j.kind == "ball" and j.limits)


def _touching_neighbours(scene: Scene) -> Occurrences:
    dynamic = {body.name for body in scene.bodies if body.motion == "dynamic"}
    for j in scene.joints:
        if j.collides and j.kind != "ball" and {j.first, j.second} <= dynamic:
            yield j.path, "the bodies of a joint that touch each other"


def _materials(scene: Scene) -> Occurrences:
    for body in scene.bodies:
        if body.motion != "static" and len({geom.friction for geom in colliders(body)}) > 1:
            yield body.path, "a moving body with pieces of different friction or restitution"


def _many(scene: Scene, most: int) -> Occurrences:
    for body in scene.bodies:
        hulls = [geom.shape.primitive is None for geom in colliders(body)]
        if body.motion != "static" and hulls.count(False) + any(hulls) > most:
            yield body.path, f"a moving body of {len(hulls)} pieces"


def _rough(scene: Scene, most: float) -> Occurrences:
    for body in scene.bodies:
        friction = max((geom.friction.dynamic for geom in colliders(body)), default=0.0)
        if friction > most:
            yield body.path, f"friction {friction:g}, above {most:g}"


def _hasty(scene: Scene, rate: int, *, stiff: bool = True, damped: bool = True) -> Occurrences:
    hasty = (*(too_stiff(scene, rate) if stiff else ()), *(too_damped(scene, rate) if damped else ()))
    for joint, drive in {joint.name: (joint, joint.drive) for joint in hasty if joint.drive}.values():
        yield (
            joint.path,
            f"a drive of stiffness {drive.stiffness:g} and damping {drive.damping:g}, stiff for its load",
        )


def _armatures(scene: Scene, least: float, most: float) -> Occurrences:
    for tree in trees(scene) if any(joint.armature for joint in scene.joints) else ():
        for number, lightness in mobility(scene, tree).items():
            joint = scene.joints[number] if number >= 0 else None
            share = joint.armature * lightness if joint else 0.0
            if joint and least < share <= most:
                yield joint.path, f"an armature of {joint.armature:.3g}, {100 * share:.2g} % of what the joint moves"


def _sticking(scene: Scene) -> Occurrences:
    for body in scene.bodies:
        for f in dict.fromkeys(geom.friction for geom in colliders(body)):
            if f.static != f.dynamic:
                slopes = " and ".join(f"{degrees(atan(number)):.3g}" for number in (f.static, f.dynamic))
                yield (
                    body.path,
                    f"friction {f.static:g} at rest and {f.dynamic:g} in motion (it slips from {slopes} degrees)",
                )


def _hitting(scene: Scene, gives: float, most: int) -> Occurrences:
    speed, path = max_speed(scene)
    thin, depth = min_thickness(scene), gives * speed / most
    if step_multiplier(scene, gives, most) == most and depth > MAX_ENTERED_FRACTION * thin:
        entered = f"{1e3 * depth:.2g} mm deep into a body {1e3 * thin:.2g} mm thick"
        yield path, f"an impact at {speed:.3g} m/s that penetrates {entered}"


def _loops(scene: Scene) -> Occurrences:
    yield from ((scene.joints[j].path, "a joint that closes a loop") for j in loop_joints(scene))


def _mimics(scene: Scene) -> Occurrences:
    yield from ((joint.path, f"a joint that mimics {joint.mimic.leader}") for joint in scene.joints if joint.mimic)


def _mimics_apart(scene: Scene) -> Occurrences:
    tree = {scene.joints[link.joint].name: i for i, tree in enumerate(trees(scene)) for link in tree if link.joint >= 0}
    for joint in scene.joints:
        if joint.mimic and tree[joint.name] != tree[joint.mimic.leader]:
            yield joint.path, f"a joint that mimics {joint.mimic.leader}, of another mechanism"


def _mimics_past(scene: Scene) -> Occurrences:
    links = {link.body: link for tree in trees(scene) for link in tree}
    held = {scene.joints[link.joint].name: link.body for link in links.values() if link.joint >= 0}
    above = {link.body: link.parent for link in links.values() if link.kind not in ("ball", "free")}
    for joint in scene.joints:
        if joint.mimic:
            one, other = (ancestors(held[name], above) for name in (joint.name, joint.mimic.leader))
            passed = {*one[:-1], *other[:-1]} - (set(one[1:]) & set(other[1:]))
            if one[-1] != other[-1] or not all(links[body].kind in ("hinge", "slider") for body in passed):
                yield joint.path, f"a joint that mimics {joint.mimic.leader}, with a ball or fixed joint between"


# ---------------------------------------------------------------- features

PRIMITIVES = Capability("boxes, spheres, cylinders, cones, capsules")
ROLLING_CYLINDERS = Capability("discs that roll on: cylinders shorter than thick")
LEANING_CYLINDERS = Capability("cylinders that stand on slopes on which they nearly tip")
HEAVY_LANDINGS = Capability("what lands on something much lighter that rests")
DOUBLE_PENDULUMS = Capability("the energy of fast double pendulums")
FAST_SPINS = Capability("the energy of gyroscopes and of what tumbles, from 30 rad/s on")
SLIDING_MESHES = Capability("convex meshes, cones and hulls that slide on flat sides")
MESHES = Capability(
    "meshes as convex hulls, convex decompositions, bounding boxes and spheres; as they are, but not dynamic ones",
    _meshes,
)
MOTIONS = Capability("static, dynamic and kinematic bodies, all actions on them")
BELTS = Capability("belts: surfaces that move while their bodies stay", _belts)
PASSAGES = Capability("bodies that go through others for a time", _passages)
FILTERS = Capability("filtered pairs and collision groups", _filtered)
JOINTS = Capability("fixed joints, hinges, sliders, ball joints; trees of them, held by the world or free", _jointed)
DRIVES = Capability("limits of hinges and sliders, drives")
LOOPS = Capability("loops of joints, closed by a fixed joint, a hinge or a ball joint", _loops)
MIMICS = Capability("joints that mimic others", _mimics)
COMMON = (
    *(
        PRIMITIVES,
        ROLLING_CYLINDERS,
        LEANING_CYLINDERS,
        MESHES,
        SLIDING_MESHES,
        MOTIONS,
        BELTS,
        HEAVY_LANDINGS,
        PASSAGES,
        FILTERS,
    ),
    *(JOINTS, DOUBLE_PENDULUMS, FAST_SPINS, DRIVES, LOOPS, MIMICS),
)

TWO_FRICTIONS = Capability("static friction other than the dynamic one", _sticking)
BALL_LIMITS = Capability("ball joints with limits", _cones)
MIMICS_APART = Capability("joints that mimic those of other free mechanisms", _mimics_apart)
MIMICS_PAST = Capability("joints that mimic others beyond ball or fixed joints", _mimics_past)
TOUCHING_NEIGHBOURS = Capability("neighbours in a tree that touch each other", _touching_neighbours)
SEVERAL_MATERIALS = Capability("several materials in a moving body", _materials)


def fast_impacts(gives: float, most: int) -> Capability:
    """Fast impacts on thin bodies, where contacts yield by `gives` (s) times the speed (see `physics.speed`)."""
    return Capability("fast impacts on thin bodies", partial(_hitting, gives=gives, most=most))


def stiff_drives(rate: int) -> Capability:
    """Drives that oscillate too fast for `rate` steps per second."""
    return Capability("drives however stiff", partial(_hasty, rate=rate, damped=False))


def fine_drives(rate: int, *, damped: bool = True) -> Capability:
    """Drives that need more than the usual `rate` of steps per second; with `damped`, damping counts like stiffness."""
    return Capability("drives that need smaller steps", partial(_hasty, rate=rate, damped=damped))


def damped_drives(rate: int) -> Capability:
    """Drives that decay too fast for `rate` steps per second."""
    return Capability("drives however damped", partial(_hasty, rate=rate, stiff=False))


def armatures_above(share: float) -> Capability:
    """Armatures of more than a `share` of the inertia that their joint moves."""
    return Capability(
        f"armatures above {100 * share:g} % of what a joint moves", partial(_armatures, least=share, most=1.0)
    )


def armatures_below(share: float) -> Capability:
    """Armatures of at most a `share` of that inertia."""
    return Capability(
        f"armatures up to {100 * share:g} % of what a joint moves", partial(_armatures, least=0.0, most=share)
    )


def pieces_above(most: int) -> Capability:
    """Moving bodies with more than `most` geoms, where all hulls together count as one."""
    return Capability(f"moving bodies of more than {most} pieces", partial(_many, most=most))


def friction_above(most: float) -> Capability:
    """Friction coefficients above a limit."""
    return Capability(f"friction above {most:g}", partial(_rough, most=most))


NEVER_SUPPORTED = {
    "joints that break, gears, tendons, distance joints": (
        "the reader refuses them, as trees of joints, and loops of such, are what all engines solve alike"
    ),
    "kinematic bodies with a velocity": "move them by a WmsAction that glides",
    "drives of ball joints": "use hinges",
    "several PhysicsScenes": "all bodies are in one; deactivate the others",
    "values and transforms that are animated": "author one value; move bodies by WmsActions",
}
"""Features that the reader refuses for every engine, and why. docs/stage.md lists the others."""
