"""Rules on motion that engines get wrong, all of them or some: agreement is not truth; docs/conformance.md measures."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations, permutations

from wmspec.compile.layout.geometry import mass, pieces
from wmspec.compile.layout.solids import Piece, bounds
from wmspec.compile.layout.values import Values
from wmspec.compile.lint.overlap import separation
from wmspec.compile.lint.rule import Breach, rule
from wmspec.compile.lint.scene_rules import Scene
from wmspec.core.diagnostics import Note
from wmspec.core.space import ORIGIN, UP, add, dot, rotate, times, unit
from wmspec.lang.check.ir.ir import Thing
from wmspec.lang.check.types import units
from wmspec.sim.scene.regime_thresholds import (
    BALANCED,
    BOUNCY,
    ENTERED,
    FAST,
    FINEST,
    HEAVIER,
    LANDS,
    SPINS,
    STEEP,
    disc,
    leaning,
)
from wmspec.sim.shapes.cylinder import Cylinder
from wmspec.sim.shapes.shape import AXES
from wmspec.sim.shapes.sphere import Sphere

#: How long (s) an impact takes where it takes longest: what is met within that time is met at once.
IMPACT = 0.003
#: Things that are no further (m) apart touch, in every engine.
TOUCHING = 1e-4
#: What the softest contacts give way for each m/s (s), with as many steps as are made for fast impacts.
GIVES = 2.2e-3 / FINEST
#: The language knows nothing of engines: a page names them.
OTHERS = "leave those engines out; `wmspec explain WMS608` names them"


@rule("WMS608")
def struck_in_a_row(scene: Scene) -> Iterator[Breach]:
    """Bouncy things in a row, touching or nearly: an impact goes through all of them at once."""
    values = scene.values
    speed = max(_speeds(values), default=0.0)
    free = list(_free(values))
    for a, b in combinations(free, 2) if speed or _falling(values) else ():
        gap, way = separation(values, a, b)
        if gap > max(IMPACT * speed, TOUCHING) or abs(way[2]) > STEEP or _bounce(values, a, b) < BOUNCY:
            continue
        touch = gap < TOUCHING
        how = "touch" if touch else f"are {_length(gap)} apart"
        who = "every engine lets" if touch else "engines in which impacts take time let"
        what = f"`{a}` and `{b}` {how} {scene.where}: {who} both answer what strikes one of them, at once"
        note = Note(f"`{a}` is declared here", values.place(a))
        others = "" if touch else f", or {OTHERS}"
        apart = f"leave {_length(IMPACT * speed)} between them" if speed else "leave some millimetres between them"
        remedy = f"{apart}, or give them a `restitution` below {BOUNCY:g}{others}"
        yield Breach(what, values.place(b), remedy, (note,), about=(a, b))


@rule("WMS608")
def rolling_cylinder(scene: Scene) -> Iterator[Breach]:
    """A cylinder shorter than thick that lies on its side, where it may roll."""
    values = scene.values
    for name in _loose(values):
        if any(_lying(values, name)):
            what = f"`{name}` is a disc on its rim {scene.where}; some engines brake it as it rolls"
            remedy = f"make it as long as it is thick, or {OTHERS}"
            yield Breach(what, values.place(name, "shape"), remedy, about=name)


@rule("WMS608")
def leaning_cylinder(scene: Scene) -> Iterator[Breach]:
    """A cylinder that stands on a slope on which it nearly tips."""
    values = scene.values
    for name in _loose(values):
        (piece, *others) = pieces(values, name)
        if others or not isinstance(piece.solid, Cylinder):
            continue
        angle = math.acos(min(1.0, abs(_rise(values, name, piece))))
        if leaning(piece.solid.radius, piece.solid.height, angle):
            tips = math.atan(2 * piece.solid.radius / piece.solid.height)
            what = f"`{name}` stands {_degrees(angle)} from upright {scene.where}, and tips from {_degrees(tips)} on"
            remedy = f"let the slope be gentler or steeper, make it a box, or {OTHERS}"
            yield Breach(f"{what}; some engines tip it before", values.place(name, "shape"), remedy, about=name)


@rule("WMS608")
def heavy_landing(scene: Scene) -> Iterator[Breach]:
    """Something heavy that begins in the air above something much lighter, and hardly bounces."""
    values = scene.values
    if not values.gravity:
        return
    boxes = {name: bounds(pieces(values, name), values.pose(name)) for name in _loose(values)}
    for a, b in permutations(boxes, 2):
        (low, high), (least, most) = boxes[a], boxes[b]
        above = low[2] - most[2] > LANDS**2 / (2 * values.gravity)
        if above and all(low[i] < most[i] and least[i] < high[i] for i in range(2)) and _bounce(values, a, b) < BOUNCY:
            heavier = mass(values, a) / mass(values, b)
            if heavier >= HEAVIER:
                what = f"`{a}` falls on `{b}` {scene.where} and is {heavier:.3g} times as heavy"
                remedy = f"make their masses more alike, or {OTHERS}"
                yield Breach(f"{what}; some engines let it rise again", values.place(a), remedy, about=(a, b))


@rule("WMS608")
def double_pendulum(scene: Scene) -> Iterator[Breach]:
    """What swings from something that swings, without a drive, where questions have no margin: the first of such."""
    values = scene.values
    questions = values.spec.questions
    if questions and all(question.margins for question in questions):
        return
    swings = {j.name: _ends(values, j.name) for j in _joints(values) if j.model in ("hinge", "ball")}
    free = {j: ends for j, ends in swings.items() if not _driven(values, j)}
    for name, ends in free.items():
        if any(_balanced(values, name, end) for end in ends):
            continue
        if len(ends) == 2 and any(ends & others for j, others in free.items() if j != name):
            of, to = values.reference(name, "of"), values.reference(name, "to")
            what = f"`{of}` swings from `{to}`, which swings itself, {scene.where}"
            remedy = "ask early, and with a `margin` of some per cent"
            doubt = "all engines lose or gain a few per cent of the energy of such"
            yield Breach(f"{what}; {doubt}", values.place(name), remedy, about=name)
            return


@rule("WMS608")
def sliding_mesh(scene: Scene) -> Iterator[Breach]:
    """A convex mesh that is sent off, and may slide."""
    values = scene.values
    loose = set(_loose(values))
    for action in values.spec.things:
        if action.kind != "action" or action.verb != "launch" or not values.there(action.name):
            continue
        name = values.reference(action.name, "object")
        if name in loose and any(piece.solid.primitive is None for piece in pieces(values, name)):
            kinds = "neither box, ball, capsule nor cylinder"
            what = f"`{name}` is launched {scene.where} and is {kinds}; some engines brake it as it slides"
            remedy = f"make it of those, or {OTHERS}"
            yield Breach(what, values.place(name, "shape"), remedy, about=name)


@rule("WMS608")
def fast_spin(scene: Scene) -> Iterator[Breach]:
    """What begins to spin fast and is no ball: its axis may turn, and engines gain or lose its energy then."""
    values = scene.values
    for name in _free(values):
        spin = math.hypot(*values.vector(name, "spin")) if values.has(name, "spin") else 0.0
        (piece, *others) = pieces(values, name)
        if spin > SPINS and (others or not isinstance(piece.solid, Sphere) or name in _joined(values)):
            what = f"`{name}` spins at {spin:.3g} rad/s {scene.where}"
            doubt = "some engines gain or lose energy as its axis turns"
            remedy = f"let it spin at less than {SPINS:g} rad/s, or {OTHERS}"
            yield Breach(f"{what}; {doubt}", values.place(name, "spin"), remedy, about=name)


@rule("WMS608")
def fast_and_thin(scene: Scene) -> Iterator[Breach]:
    """Something so fast that engines with soft contacts let it into, or through, what is thin."""
    values = scene.values
    speed = max(_speeds(values), default=0.0)
    if speed <= FAST:
        return
    depth = GIVES * speed
    for name in _touchable(values):
        thin = min(_thickness(piece) for piece in pieces(values, name))
        if depth > ENTERED * thin:
            fast = f"something moves at {units.told(speed, units.SPEED)} {scene.where}"
            deep = f"where contacts are soft that goes {_length(depth)} deep"
            what = f"`{name}` is {_length(thin)} thick, and {fast}; {deep}"
            remedy = f"make it thicker, the other slower, or {OTHERS}"
            yield Breach(what, values.place(name), remedy, about=name)


RULES = (
    *(struck_in_a_row, rolling_cylinder, leaning_cylinder, heavy_landing, double_pendulum),
    *(sliding_mesh, fast_spin, fast_and_thin),
)


def _touchable(values: Values) -> list[str]:
    """The objects that are there and can be touched."""
    objects = (t.name for t in values.spec.things if t.kind == "object")
    return [name for name in objects if values.there(name) and values.flag(name, "solid")]


def _speeds(values: Values) -> Iterator[float]:
    """How fast (m/s) actions set things off or carry them."""
    for action in values.spec.things:
        if action.kind == "action" and values.there(action.name) and "speed" in action.properties:
            yield values.number(action.name, "speed")


def _bounce(values: Values, a: str, b: str) -> float:
    return math.sqrt(values.number(a, "restitution") * values.number(b, "restitution"))


def _lying(values: Values, name: str) -> Iterator[bool]:
    for piece in pieces(values, name):
        if isinstance(piece.solid, Cylinder) and disc(piece.solid.radius, piece.solid.height):
            yield abs(_rise(values, name, piece)) < STEEP


def _rise(values: Values, name: str, piece: Piece) -> float:
    """The cosine of the angle between the axis of a piece and the vertical."""
    return dot(rotate(values.pose(name).orientation, rotate(piece.pose.orientation, UP)), UP)


def _falling(values: Values) -> bool:
    """Whether anything that is free may fall: it has a joint, or rests on nothing."""
    joined = _joined(values)
    return any(name in joined or not values.has(name, "on") for name in _free(values))


def _free(values: Values) -> Iterator[str]:
    """Those that can be touched and move."""
    return (name for name in _touchable(values) if not values.flag(name, "fixed"))


def _loose(values: Values) -> Iterator[str]:
    """Those that no joint holds, either."""
    joined = _joined(values)
    return (name for name in _free(values) if name not in joined)


def _joined(values: Values) -> set[str]:
    """The objects that have joints."""
    return {end for j in _joints(values) for end in values.ends(j.name)}


def _joints(values: Values) -> list[Thing]:
    return [t for t in values.spec.things if t.kind == "joint" and values.there(t.name)]


def _ends(values: Values, joint: str) -> set[str]:
    """The one or two objects of a joint that move."""
    return {end for end in values.ends(joint) if not values.flag(end, "fixed")}


def _balanced(values: Values, joint: str, end: str) -> bool:
    """Whether an object's centre of mass lies on the axis, of a hinge of its spec, or at the point by which it is held.

    Whether a hinge of an asset is balanced its file tells, which may give the centre of mass.
    """
    thing = values.spec.thing(joint)
    if thing.of:
        return False
    parts = pieces(values, end)
    room = sum(piece.solid.volume for piece in parts)
    middle = ORIGIN
    for piece in parts:
        middle = add(middle, times(piece.solid.volume / room, piece.pose.apply(piece.solid.center)))
    away = add(values.pose(end).apply(middle), times(-1.0, values.vector(joint, "at")))
    if thing.model == "hinge" and math.hypot(*(axis := values.vector(joint, "axis"))) > 0:
        axis = unit(axis)
        away = add(away, times(-dot(away, axis), axis))
    return math.hypot(*away) < BALANCED * max(_thickness(piece) for piece in parts)


def _driven(values: Values, joint: str) -> bool:
    """Whether a joint has a drive, or is braked."""
    return any(values.has(joint, name) and values.number(joint, name) for name in ("stiffness", "damping"))


def _thickness(piece: Piece) -> float:
    """How thick (m) a piece is at least, along its own axes."""
    return min(piece.solid.reach(axis) + piece.solid.reach(times(-1.0, axis)) for axis in AXES)


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.3g} degrees"


def _length(metres: float) -> str:
    return units.told(float(f"{metres:.2g}"), units.LENGTH)
