"""What each engine can do, and why it can't do the rest: the one table of refusals, `wmspec doctor` and the docs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from wmspec.diagnostics import WmsError
from wmspec.scene.contact import colliders
from wmspec.scene.drives import too_damped, too_stiff
from wmspec.scene.model import Cone, Joint, Mesh, Scene

RATES = {"mujoco": 3840, "pybullet": 1920}  # steps per second of engines that compute drives step by step
MOST_FRICTION = 10.0  # of a pair: Bullet's own limit
MOST_SHAPES = 16  # of a moving body: PyBullet's own limit; all hulls are one

NAMES = {"mujoco": "MuJoCo", "pybullet": "PyBullet", "sapien": "SAPIEN"}

Where = Iterator[tuple[str, str]]
"""Prim paths, and what is asked of each."""


@dataclass(frozen=True)
class Capability:
    """Something that a stage may ask for: `lacking` engines and why; `asked` finds where a scene asks for it."""

    name: str
    lacking: dict[str, str]
    asked: Callable[[Scene, str], Where]


def require(engine: str, scene: Scene) -> None:
    """Raise WmsError with the prim path of everything in a valid scene that the engine can't do."""
    problems = [
        f"{path}: {what}; {row.lacking[engine]}"
        for row in TABLE
        if engine in row.lacking
        for path, what in row.asked(scene, engine)
    ]
    if problems:
        raise WmsError("\n".join(problems))


def _nowhere(_scene: Scene, _engine: str) -> Where:
    yield from ()


def _cones(scene: Scene, _engine: str) -> Where:
    yield from ((j.path, "a ball joint with limits") for j in scene.joints if j.kind == "ball" and j.limits)


def _touching_neighbours(scene: Scene, _engine: str) -> Where:
    dynamic = {body.name for body in scene.bodies if body.motion == "dynamic"}
    for j in scene.joints:
        if j.collides and j.kind != "ball" and {j.first, j.second} <= dynamic:
            yield j.path, "the bodies of a joint that touch each other"


def _materials(scene: Scene, _engine: str) -> Where:
    for body in scene.bodies:
        if body.motion != "static" and len({geom.friction for geom in colliders(body)}) > 1:
            yield body.path, "a moving body with pieces of different friction or restitution"


def _many(scene: Scene, _engine: str) -> Where:
    for body in scene.bodies:
        hulls = [isinstance(geom.shape, Cone | Mesh) for geom in colliders(body)]
        if body.motion != "static" and hulls.count(False) + any(hulls) > MOST_SHAPES:
            yield body.path, f"a moving body of {len(hulls)} pieces"


def _rough(scene: Scene, _engine: str) -> Where:
    for body in scene.bodies:
        most = max((geom.friction.dynamic for geom in colliders(body)), default=0.0)
        if most > MOST_FRICTION:
            yield body.path, f"friction {most:g}, above {MOST_FRICTION:g}"


def _stiff(scene: Scene, engine: str) -> Where:
    yield from ((joint.path, _drive(joint)) for joint in too_stiff(scene, RATES[engine]))


def _damped(scene: Scene, engine: str) -> Where:
    yield from ((joint.path, _drive(joint)) for joint in too_damped(scene, RATES[engine]))


def _drive(joint: Joint) -> str:
    assert joint.drive is not None
    return (
        f"a drive of stiffness {joint.drive.stiffness:g} and damping {joint.drive.damping:g}, stiff for what it moves"
    )


_ONE_MATERIAL = "PyBullet has one material a moving body; give its pieces the same friction and restitution"
_FEW = f"PyBullet takes {MOST_SHAPES} pieces of a moving body, all hulls together counting as one; use fewer, or meshes"
_CONE = "{} has no such limits; remove the cone angles, or use hinges"
_STIFF = "{} computes drives step by step and would overshoot; make it softer or what it moves heavier"

TABLE = (
    Capability("boxes, spheres, cylinders, cones, capsules", {}, _nowhere),
    Capability(
        "cylinders that roll on", {"sapien": "PhysX rolls polygons, which brake; use spheres or capsules"}, _nowhere
    ),
    Capability(
        "meshes as convex hulls, convex decompositions, bounding boxes and spheres; as they are, but not dynamic ones",
        {},
        _nowhere,
    ),
    Capability("static, dynamic and kinematic bodies, all actions on them", {}, _nowhere),
    Capability("filtered pairs and collision groups", {}, _nowhere),
    Capability("fixed joints, hinges, sliders, ball joints; trees of them, held by the world or free", {}, _nowhere),
    Capability("limits of hinges and sliders, drives", {}, _nowhere),
    Capability(
        "ball joints with limits", {"mujoco": _CONE.format("MuJoCo"), "pybullet": _CONE.format("PyBullet")}, _cones
    ),
    Capability(
        "neighbours in a tree that touch each other",
        {"sapien": "PhysX lets the two bodies of a joint pass through each other; author physics:collisionEnabled = 0"},
        _touching_neighbours,
    ),
    Capability("drives however stiff", {e: _STIFF.format(NAMES[e]) for e in RATES}, _stiff),
    Capability("drives however damped", {"pybullet": _STIFF.format("PyBullet")}, _damped),
    Capability("several materials in a moving body", {"pybullet": _ONE_MATERIAL}, _materials),
    Capability(f"moving bodies of more than {MOST_SHAPES} pieces", {"pybullet": _FEW}, _many),
    Capability(
        f"friction above {MOST_FRICTION:g}",
        {"pybullet": f"Bullet's own limit is {MOST_FRICTION:g}; lower the friction"},
        _rough,
    ),
)
"""What stages may ask for, and who lacks it."""

_NOBODY = {
    "joints that close a loop, that break, gears, mimics, tendons, distance joints": (
        "the reader refuses them, as trees of joints are what all engines solve alike"
    ),
    "static friction other than the dynamic one": "engines have one coefficient; make them equal, or author one",
    "bodies with joints that start in motion": "give them an impulse or a drive instead of a velocity",
    "kinematic bodies with a velocity": "move them by a WmsAction that glides",
    "drives of ball joints": "use hinges",
    "several PhysicsScenes": "all bodies are in one; deactivate the others",
    "values and transforms that are animated": "author one value; move bodies by WmsActions",
}

NEVER = tuple(Capability(name, dict.fromkeys(NAMES, why), _nowhere) for name, why in _NOBODY.items())
"""What no engine is given: refused before. docs/stage.md lists the rest of it."""


def table() -> list[tuple[str, dict[str, str]]]:
    """What can be asked for, and for each engine why it lacks it, or nothing."""
    return [(row.name, {engine: row.lacking.get(engine, "") for engine in NAMES}) for row in (*TABLE, *NEVER)]
