"""What stages may ask for, and what of it engines lack: the refusals, `wmspec doctor` and the docs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from math import atan, degrees

from wmspec.core.diagnostics import Diagnostic, Report, StageError
from wmspec.core.places import PrimPlace
from wmspec.sim.scene.joints.articulations import ascent, closing, trees
from wmspec.sim.scene.joints.drives import too_damped, too_stiff
from wmspec.sim.scene.model import Joint, Scene
from wmspec.sim.scene.physics.contact import colliders
from wmspec.sim.scene.physics.speed import fastest, steps, thinnest
from wmspec.sim.scene.regime_thresholds import ENTERED

Where = Iterator[tuple[str, str]]
"""Prim paths, and what is asked of each."""


def _nowhere(_scene: Scene) -> Where:
    yield from ()


@dataclass(frozen=True)
class Capability:
    """Something that a stage may ask for; `asked` finds where a scene does."""

    name: str
    asked: Callable[[Scene], Where] = _nowhere


@dataclass(frozen=True)
class Lack:
    """What an engine can't do, why, and what to do instead."""

    capability: Capability
    reason: str
    #: Whether it is executed nearly so, as the reason says, instead of being refused.
    nearly: bool = False


def require(lacks: Iterable[Lack], scene: Scene, *, strict: bool = False) -> None:
    """Raise StageError with the prim path of everything in a valid scene that an engine lacks.

    If `strict`, what it does only nearly is lacking too.
    """
    report = Report(StageError)
    for lack in lacks:
        if strict or not lack.nearly:
            report.include(
                Diagnostic(what, PrimPlace(path), lack.reason) for path, what in lack.capability.asked(scene)
            )
    report.stop_if_failed()


def approximated(lacks: Iterable[Lack], scene: Scene) -> tuple[Diagnostic, ...]:
    """What of a valid scene an engine executes only nearly as it is meant, as warnings."""
    return tuple(
        Diagnostic(f"{what} ({lack.reason})", PrimPlace(path), severity="warning")
        for lack in lacks
        if lack.nearly
        for path, what in lack.capability.asked(scene)
    )


NEARLY = "nearly: "
"""How the reason begins of what an engine does, though not exactly."""


def table(engines: Mapping[str, Iterable[Lack]]) -> list[tuple[str, dict[str, str]]]:
    """What can be asked for, and for each engine why it lacks it, or nothing.

    First what is known to be asked for, then what some engine says that it lacks, then what none is ever given. What an
    engine does nearly so begins with `NEARLY`.
    """
    rows: dict[str, dict[str, str]] = {capability.name: {} for capability in COMMON}
    for engine, lacks in engines.items():
        for lack in lacks:
            rows.setdefault(lack.capability.name, {})[engine] = f"{NEARLY if lack.nearly else ''}{lack.reason}"
    rows |= {name: dict.fromkeys(engines, why) for name, why in NEVER.items()}
    return [(name, {engine: reasons.get(engine, "") for engine in engines}) for name, reasons in rows.items()]


# ---------------------------------------------------------------- where scenes ask


def _meshes(scene: Scene) -> Where:
    for body in scene.bodies:
        if any(not geom.shape.prims for geom in colliders(body)):
            yield body.path, "a mesh that collides"


def _jointed(scene: Scene) -> Where:
    yield from ((joint.path, f"a joint ({joint.kind})") for joint in scene.joints)


def _filtered(scene: Scene) -> Where:
    paths = {body.name: body.path for body in scene.bodies}
    yield from ((paths[first], f"{second} that passes through it") for first, second in scene.filtered)


def _cones(scene: Scene) -> Where:
    yield from ((j.path, "a ball joint with limits") for j in scene.joints if j.kind == "ball" and j.limits)


def _touching_neighbours(scene: Scene) -> Where:
    dynamic = {body.name for body in scene.bodies if body.motion == "dynamic"}
    for j in scene.joints:
        if j.collides and j.kind != "ball" and {j.first, j.second} <= dynamic:
            yield j.path, "the bodies of a joint that touch each other"


def _materials(scene: Scene) -> Where:
    for body in scene.bodies:
        if body.motion != "static" and len({geom.friction for geom in colliders(body)}) > 1:
            yield body.path, "a moving body with pieces of different friction or restitution"


def _many(scene: Scene, most: int) -> Where:
    for body in scene.bodies:
        hulls = [geom.shape.primitive is None for geom in colliders(body)]
        if body.motion != "static" and hulls.count(False) + any(hulls) > most:
            yield body.path, f"a moving body of {len(hulls)} pieces"


def _rough(scene: Scene, most: float) -> Where:
    for body in scene.bodies:
        friction = max((geom.friction.dynamic for geom in colliders(body)), default=0.0)
        if friction > most:
            yield body.path, f"friction {friction:g}, above {most:g}"


def _stiff(scene: Scene, rate: int) -> Where:
    yield from ((joint.path, _drive(joint)) for joint in too_stiff(scene, rate))


def _hasty(scene: Scene, rate: int) -> Where:
    joints = {joint.name: joint for joint in (*too_stiff(scene, rate), *too_damped(scene, rate))}
    yield from ((joint.path, _drive(joint)) for joint in joints.values())


def _damped(scene: Scene, rate: int) -> Where:
    yield from ((joint.path, _drive(joint)) for joint in too_damped(scene, rate))


def _sticking(scene: Scene) -> Where:
    for body in scene.bodies:
        for f in dict.fromkeys(geom.friction for geom in colliders(body)):
            if f.static != f.dynamic:
                slopes = " and ".join(f"{degrees(atan(number)):.3g}" for number in (f.static, f.dynamic))
                yield (
                    body.path,
                    f"friction {f.static:g} at rest and {f.dynamic:g} in motion (it slips from {slopes} degrees)",
                )


def _hitting(scene: Scene, gives: float, most: int) -> Where:
    speed, path = fastest(scene)
    thin, depth = thinnest(scene), gives * speed / most
    if steps(scene, gives, most) == most and depth > ENTERED * thin:
        entered = f"{1e3 * depth:.2g} mm deep into what is {1e3 * thin:.2g} mm thick"
        yield path, f"an impact at {speed:.3g} m/s, which goes {entered}"


def _loops(scene: Scene) -> Where:
    yield from ((scene.joints[j].path, "a joint that closes a loop") for j in closing(scene))


def _mimics(scene: Scene) -> Where:
    yield from ((joint.path, f"a joint that mimics {joint.mimic.leader}") for joint in scene.joints if joint.mimic)


def _mimics_apart(scene: Scene) -> Where:
    tree = {scene.joints[link.joint].name: i for i, tree in enumerate(trees(scene)) for link in tree if link.joint >= 0}
    for joint in scene.joints:
        if joint.mimic and tree[joint.name] != tree[joint.mimic.leader]:
            yield joint.path, f"a joint that mimics {joint.mimic.leader}, of a mechanism apart"


def _mimics_past(scene: Scene) -> Where:
    links = {link.body: link for tree in trees(scene) for link in tree}
    held = {scene.joints[link.joint].name: link.body for link in links.values() if link.joint >= 0}
    above = {link.body: link.parent for link in links.values() if link.kind not in ("ball", "free")}
    for joint in scene.joints:
        if joint.mimic:
            one, other = (ascent(held[name], above) for name in (joint.name, joint.mimic.leader))
            passed = {*one[:-1], *other[:-1]} - (set(one[1:]) & set(other[1:]))
            if one[-1] != other[-1] or not all(links[body].kind in ("hinge", "slider") for body in passed):
                yield joint.path, f"a joint that mimics {joint.mimic.leader}, with a ball or fixed joint between"


def _drive(joint: Joint) -> str:
    assert joint.drive is not None
    return (
        f"a drive of stiffness {joint.drive.stiffness:g} and damping {joint.drive.damping:g}, stiff for what it moves"
    )


# ---------------------------------------------------------------- what may be asked for

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
FILTERS = Capability("filtered pairs and collision groups", _filtered)
JOINTS = Capability("fixed joints, hinges, sliders, ball joints; trees of them, held by the world or free", _jointed)
DRIVES = Capability("limits of hinges and sliders, drives")
LOOPS = Capability("loops of joints, closed by a fixed joint, a hinge or a ball joint", _loops)
MIMICS = Capability("joints that mimic others", _mimics)
COMMON = (
    *(PRIMITIVES, ROLLING_CYLINDERS, LEANING_CYLINDERS, MESHES, SLIDING_MESHES, MOTIONS, HEAVY_LANDINGS, FILTERS),
    *(JOINTS, DOUBLE_PENDULUMS, FAST_SPINS, DRIVES, LOOPS, MIMICS),
)

TWO_FRICTIONS = Capability("static friction other than the dynamic one", _sticking)
BALL_LIMITS = Capability("ball joints with limits", _cones)
MIMICS_APART = Capability("joints that mimic those of other free mechanisms", _mimics_apart)
MIMICS_PAST = Capability("joints that mimic others beyond ball or fixed joints", _mimics_past)
TOUCHING_NEIGHBOURS = Capability("neighbours in a tree that touch each other", _touching_neighbours)
SEVERAL_MATERIALS = Capability("several materials in a moving body", _materials)


def fast_impacts(gives: float, most: int) -> Capability:
    """Fast impacts on thin bodies, where contacts give way by `gives` (s) times the speed (`physics.speed`)."""
    return Capability("fast impacts on thin bodies", partial(_hitting, gives=gives, most=most))


def stiff_drives(rate: int) -> Capability:
    """Drives that vibrate faster than `rate` steps per second can follow."""
    return Capability("drives however stiff", partial(_stiff, rate=rate))


def fine_drives(rate: int) -> Capability:
    """Drives that would need more than the usual `rate` of steps per second."""
    return Capability("drives that need smaller steps", partial(_hasty, rate=rate))


def damped_drives(rate: int) -> Capability:
    """Drives that brake in less than `rate` steps per second can follow."""
    return Capability("drives however damped", partial(_damped, rate=rate))


def pieces_above(most: int) -> Capability:
    """Moving bodies of more than so many pieces, where all hulls together count as one."""
    return Capability(f"moving bodies of more than {most} pieces", partial(_many, most=most))


def friction_above(most: float) -> Capability:
    """Coefficients of friction above a limit."""
    return Capability(f"friction above {most:g}", partial(_rough, most=most))


NEVER = {
    "joints that break, gears, tendons, distance joints": (
        "the reader refuses them, as trees of joints, and loops of such, are what all engines solve alike"
    ),
    "kinematic bodies with a velocity": "move them by a WmsAction that glides",
    "drives of ball joints": "use hinges",
    "several PhysicsScenes": "all bodies are in one; deactivate the others",
    "values and transforms that are animated": "author one value; move bodies by WmsActions",
}
"""What no engine is given, and why: refused before. docs/stage.md lists the rest of it."""
