"""Rules on motion that some or all engines get wrong, as measured in docs/conformance.md."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations, permutations

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import mass, pieces, volume
from wmspec.compile.layout.solids import PlacedShape, bounds
from wmspec.compile.lint.overlap import may_be_within, separation
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import LintScene
from wmspec.core.diagnostics import Note
from wmspec.core.space import ORIGIN, UP, add, dot, inverse, rotate, scale, unit
from wmspec.lang.check.ir.ir import Entity
from wmspec.lang.check.types import units
from wmspec.sim.scene.regime_thresholds import (
    COARSEST_STEP_RATE,
    ELASTIC_RESTITUTION,
    FAST_IMPACT,
    FAST_SPIN,
    HEAVY_LANDING_RATIO,
    HEAVY_LANDING_SPEED,
    MAX_ENTERED_FRACTION,
    MAX_STEP_MULTIPLIER,
    MAX_STEP_RESPONSE,
    STEEP_COSINE,
    WHEEL_OFFSET,
    is_disc,
    is_leaning,
)
from wmspec.sim.shapes.cylinder import Cylinder
from wmspec.sim.shapes.shape import AXES
from wmspec.sim.shapes.sphere import Sphere

#: Maximum duration (s) of an impact; collisions within that time are resolved together.
IMPACT_DURATION = 0.003
#: Objects closer than this (m) touch in every engine.
CONTACT_DISTANCE = 1e-4
#: Penetration of the softest contacts per speed (s), with the step size used for fast impacts.
PENETRATION_PER_SPEED = 2.2e-3 / MAX_STEP_MULTIPLIER
#: Highest step rate (Hz) of the coarsest engine.
_RATE = MAX_STEP_MULTIPLIER * COARSEST_STEP_RATE
#: Remedy that names no engine: the language does not depend on engines.
ENGINES_REMEDY = "leave those engines out; `wmspec explain WMS608` names them"


@rule("WMS608")
def struck_in_a_row(scene: LintScene) -> Iterator[Breach]:
    """Find rows of elastic objects that touch, or nearly: an impact passes through all of them at once."""
    values = scene.values
    speed = max(_speeds(values), default=0.0)
    free = list(_movable(values))
    nearby = max(IMPACT_DURATION * speed, CONTACT_DISTANCE)
    for a, b in combinations(free, 2) if speed or _can_fall(values) else ():
        if _bounce(values, a, b) < ELASTIC_RESTITUTION or not may_be_within(values, a, b, nearby):
            continue
        gap, way = separation(values, a, b)
        if gap > nearby or abs(way[2]) > STEEP_COSINE:
            continue
        touch = gap < CONTACT_DISTANCE
        how = "touch" if touch else f"are {_length(gap)} apart"
        who = "every engine resolves" if touch else "engines with compliant contacts resolve"
        what = f"`{a}` and `{b}` {how} {scene.where}: {who} both collisions in the same step"
        note = Note(f"`{a}` is declared here", values.source_location(a))
        others = "" if touch else f", or {ENGINES_REMEDY}"
        apart = (
            f"leave {_length(IMPACT_DURATION * speed)} between them" if speed else "leave some millimetres between them"
        )
        remedy = f"{apart}, or give them a `restitution` below {ELASTIC_RESTITUTION:g}{others}"
        yield Breach(what, values.source_location(b), remedy, (note,), about=(a, b))


@rule("WMS608")
def rolling_cylinder(scene: LintScene) -> Iterator[Breach]:
    """Find cylinders shorter than thick that lie on their side and may roll."""
    values = scene.values
    for name in _unjointed(values):
        if any(_lying(values, name)):
            what = f"`{name}` is a disc on its rim {scene.where}; some engines brake it as it rolls"
            remedy = f"make it as long as it is thick, or {ENGINES_REMEDY}"
            yield Breach(what, values.source_location(name, "shape"), remedy, about=name)


@rule("WMS608")
def leaning_cylinder(scene: LintScene) -> Iterator[Breach]:
    """Find cylinders that stand on a slope close to their tipping angle."""
    values = scene.values
    for name in _unjointed(values):
        (piece, *others) = pieces(values, name)
        if others or not isinstance(piece.solid, Cylinder):
            continue
        angle = math.acos(min(1.0, abs(_rise(values, name, piece))))
        if is_leaning(piece.solid.radius, piece.solid.height, angle):
            tips = math.atan(2 * piece.solid.radius / piece.solid.height)
            what = f"`{name}` stands {_degrees(angle)} from upright {scene.where}, and tips from {_degrees(tips)} on"
            remedy = f"let the slope be gentler or steeper, make it a box, or {ENGINES_REMEDY}"
            yield Breach(
                f"{what}; some engines tip it before", values.source_location(name, "shape"), remedy, about=name
            )


@rule("WMS608")
def heavy_landing(scene: LintScene) -> Iterator[Breach]:
    """Find heavy, inelastic objects that start in the air above much lighter ones."""
    values = scene.values
    if not values.gravity:
        return
    boxes = {name: bounds(pieces(values, name), values.pose(name)) for name in _unjointed(values)}
    for a, b in permutations(boxes, 2):
        (low, high), (least, most) = boxes[a], boxes[b]
        above = low[2] - most[2] > HEAVY_LANDING_SPEED**2 / (2 * values.gravity)
        if (
            above
            and all(low[i] < most[i] and least[i] < high[i] for i in range(2))
            and _bounce(values, a, b) < ELASTIC_RESTITUTION
        ):
            heavier = mass(values, a) / mass(values, b)
            if heavier >= HEAVY_LANDING_RATIO:
                what = f"`{a}` falls on `{b}` {scene.where} and is {heavier:.3g} times as heavy"
                remedy = f"make their masses more alike, or {ENGINES_REMEDY}"
                yield Breach(f"{what}; some engines let it rise again", values.source_location(a), remedy, about=(a, b))


@rule("WMS608")
def double_pendulum(scene: LintScene) -> Iterator[Breach]:
    """Find the first undamped double pendulum where questions have no margin."""
    values = scene.values
    questions = values.spec.questions
    if questions and all(question.margins for question in questions):
        return
    swings = {j.name: _ends(values, j.name) for j in _joints(values) if j.model in ("hinge", "ball")}
    free = {j: ends for j, ends in swings.items() if not _is_driven(values, j)}
    for name, ends in free.items():
        if any(_is_balanced(values, name, end) for end in ends):
            continue
        if len(ends) == 2 and any(ends & others for j, others in free.items() if j != name):
            of, to = values.reference(name, "of"), values.reference(name, "to")
            what = f"`{of}` swings from `{to}`, which swings itself, {scene.where}"
            remedy = "ask early, and with a `margin` of some per cent"
            doubt = "all engines lose or gain a few per cent of the energy of such"
            yield Breach(f"{what}; {doubt}", values.source_location(name), remedy, about=name)
            return


@rule("WMS608")
def sliding_mesh(scene: LintScene) -> Iterator[Breach]:
    """Find convex meshes that are launched and may slide."""
    values = scene.values
    loose = set(_unjointed(values))
    for action in values.spec.things:
        if action.kind != "action" or action.verb != "launch" or not values.is_present(action.name):
            continue
        name = values.reference(action.name, "object")
        if name in loose and any(piece.solid.primitive is None for piece in pieces(values, name)):
            kinds = "neither box, ball, capsule nor cylinder"
            what = f"`{name}` is launched {scene.where} and is {kinds}; some engines brake it as it slides"
            remedy = f"make it of those, or {ENGINES_REMEDY}"
            yield Breach(what, values.source_location(name, "shape"), remedy, about=name)


@rule("WMS608")
def fast_spin(scene: LintScene) -> Iterator[Breach]:
    """Find fast spinning objects other than balls: engines do not conserve energy when their axis turns."""
    values = scene.values
    for name in _movable(values):
        spin = math.hypot(*values.vector(name, "spin")) if values.has(name, "spin") else 0.0
        (piece, *others) = pieces(values, name)
        if spin > FAST_SPIN and (others or not isinstance(piece.solid, Sphere) or name in _jointed(values)):
            what = f"`{name}` spins at {spin:.3g} rad/s {scene.where}"
            doubt = "some engines gain or lose energy as its axis turns"
            remedy = f"let it spin at less than {FAST_SPIN:g} rad/s, or {ENGINES_REMEDY}"
            yield Breach(f"{what}; {doubt}", values.source_location(name, "spin"), remedy, about=name)


@rule("WMS608")
def fast_and_thin(scene: LintScene) -> Iterator[Breach]:
    """Find thin objects that fast ones penetrate in engines with soft contacts."""
    values = scene.values
    speed = max(_speeds(values), default=0.0)
    if speed <= FAST_IMPACT:
        return
    depth = PENETRATION_PER_SPEED * speed
    for name in _touchable(values):
        thin = min(_thickness(piece) for piece in pieces(values, name))
        if depth > MAX_ENTERED_FRACTION * thin:
            fast = f"something moves at {units.format_quantity(speed, units.SPEED)} {scene.where}"
            deep = f"where contacts are soft that goes {_length(depth)} deep"
            what = f"`{name}` is {_length(thin)} thick, and {fast}; {deep}"
            remedy = f"make it thicker, the other slower, or {ENGINES_REMEDY}"
            yield Breach(what, values.source_location(name), remedy, about=name)


@rule("WMS608")
def stiff_drive(scene: LintScene) -> Iterator[Breach]:
    """Find drives of the last object of a chain that oscillate or decay within a few steps.

    The inertia of an object whose moments are given, and of one that carries others, is not known here.
    """
    values = scene.values
    joints = _joints(values)
    ends = [end for joint in joints for end in values.ends(joint.name)]
    for joint in joints:
        if joint.of or joint.model not in ("hinge", "slider"):
            continue
        moved = values.reference(joint.name, "of")
        if ends.count(moved) > 1 or values.flag(moved, "fixed") or values.has(moved, "moments"):
            continue
        load = mass(values, moved) if joint.model == "slider" else _moment(values, joint, moved)
        load += values.number(joint.name, "armature") if values.has(joint.name, "armature") else 0.0
        for word, power in (("stiffness", 2), ("damping", 1)):
            most = MAX_STEP_RESPONSE * _RATE**power * load
            if values.number(joint.name, word) > most:
                what = f"the {word} of `{joint.name}` is too high for its load `{moved}` {scene.where}"
                why = "engines that integrate drives explicitly refuse it"
                remedy = f"keep it below {float(f'{most:.1g}'):g}, make `{moved}` heavier, or {ENGINES_REMEDY}"
                yield Breach(f"{what}; {why}", values.source_location(joint.name, word), remedy, about=joint.name)


RULES = (
    *(struck_in_a_row, rolling_cylinder, leaning_cylinder, heavy_landing, double_pendulum),
    *(sliding_mesh, fast_spin, fast_and_thin, stiff_drive),
)


def _touchable(values: Evaluator) -> list[str]:
    """Return the present, touchable objects."""
    objects = (t.name for t in values.spec.things if t.kind == "object")
    return [name for name in objects if values.is_present(name) and values.flag(name, "solid")]


def _speeds(values: Evaluator) -> Iterator[float]:
    """Yield the speeds (m/s) of launches and paths."""
    for action in values.spec.things:
        if action.kind == "action" and values.is_present(action.name) and "speed" in action.properties:
            yield values.number(action.name, "speed")


def _bounce(values: Evaluator, a: str, b: str) -> float:
    return math.sqrt(values.number(a, "restitution") * values.number(b, "restitution"))


def _lying(values: Evaluator, name: str) -> Iterator[bool]:
    for piece in pieces(values, name):
        if isinstance(piece.solid, Cylinder) and is_disc(piece.solid.radius, piece.solid.height):
            yield abs(_rise(values, name, piece)) < STEEP_COSINE


def _rise(values: Evaluator, name: str, piece: PlacedShape) -> float:
    """Return the cosine of the angle between the axis of a piece and the vertical."""
    return dot(rotate(values.pose(name).orientation, rotate(piece.pose.orientation, UP)), UP)


def _can_fall(values: Evaluator) -> bool:
    """Whether any free object may fall: it has a joint, or rests on nothing."""
    joined = _jointed(values)
    return any(name in joined or not values.has(name, "on") for name in _movable(values))


def _movable(values: Evaluator) -> Iterator[str]:
    """Yield the touchable objects that can move."""
    return (name for name in _touchable(values) if not values.flag(name, "fixed"))


def _unjointed(values: Evaluator) -> Iterator[str]:
    """Yield the movable objects without joints."""
    joined = _jointed(values)
    return (name for name in _movable(values) if name not in joined)


def _jointed(values: Evaluator) -> set[str]:
    """Return the objects that have joints."""
    return {end for j in _joints(values) for end in values.ends(j.name)}


def _joints(values: Evaluator) -> list[Entity]:
    return [t for t in values.spec.things if t.kind == "joint" and values.is_present(t.name)]


def _ends(values: Evaluator, joint: str) -> set[str]:
    """Return the movable objects of a joint, one or two."""
    return {end for end in values.ends(joint) if not values.flag(end, "fixed")}


def _is_balanced(values: Evaluator, joint: str, end: str) -> bool:
    """Whether an object's centre of mass is on the axis of its hinge, or at its ball joint.

    For hinges of an asset the file, which may give the centre of mass, decides.
    """
    thing = values.spec.thing(joint)
    if thing.of:
        return False
    parts = pieces(values, end)
    room = sum(piece.solid.volume for piece in parts)
    middle = ORIGIN
    for piece in parts:
        middle = add(middle, scale(piece.solid.volume / room, piece.pose.apply(piece.solid.center)))
    away = add(values.pose(end).apply(middle), scale(-1.0, values.vector(joint, "at")))
    if thing.model == "hinge" and math.hypot(*(axis := values.vector(joint, "axis"))) > 0:
        axis = unit(axis)
        away = add(away, scale(-dot(away, axis), axis))
    return math.hypot(*away) < WHEEL_OFFSET * max(_thickness(piece) for piece in parts)


def _is_driven(values: Evaluator, joint: str) -> bool:
    """Whether a joint has a drive or a brake."""
    return any(values.has(joint, name) and values.number(joint, name) for name in ("stiffness", "damping"))


def _thickness(piece: PlacedShape) -> float:
    """Return the minimum thickness (m) of a piece along its own axes."""
    return min(piece.solid.reach(axis) + piece.solid.reach(scale(-1.0, axis)) for axis in AXES)


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.3g} degrees"


def _length(metres: float) -> str:
    return units.format_quantity(float(f"{metres:.2g}"), units.LENGTH)


def _moment(values: Evaluator, joint: Entity, moved: str) -> float:
    """Return the moment of inertia (kg m²) of an object about the axis of its hinge (Huygens and Steiner)."""
    axis, pose = unit(values.vector(joint.name, "axis")), values.pose(moved)
    density, moment = mass(values, moved) / volume(values, moved), 0.0
    for piece in pieces(values, moved):
        place = pose.compose(piece.pose)
        along = rotate(inverse(place.orientation), axis)
        own = sum(a * dot(row, along) for a, row in zip(along, piece.solid.tensor, strict=True))
        arm = add(place.apply(piece.solid.center), scale(-1.0, values.vector(joint.name, "at")))
        moment += density * piece.solid.volume * (own + dot(arm, arm) - dot(arm, axis) ** 2)
    return moment
