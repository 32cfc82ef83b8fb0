"""Rules on motion that engines get wrong, all of them or some: agreement is not truth; docs/conformance.md measures."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations

from wmspec.check import units
from wmspec.diagnostics import Note
from wmspec.layout.geometry import pieces
from wmspec.layout.solids import Piece
from wmspec.layout.values import Values
from wmspec.lint.overlap import separation
from wmspec.lint.rule import Breach, rule
from wmspec.lint.scene_rules import Scene
from wmspec.scene.hard import BOUNCY, ENTERED, FAST, FINEST, STEEP, disc
from wmspec.shapes.cylinder import Cylinder
from wmspec.shapes.shape import AXES
from wmspec.space import UP, dot, rotate, times

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
    for a, b in combinations(free, 2) if speed else ():
        gap, way = separation(values, a, b)
        if gap > IMPACT * speed or abs(way[2]) > STEEP or _bounce(values, a, b) < BOUNCY:
            continue
        touch = gap < TOUCHING
        how = "touch" if touch else f"are {_length(gap)} apart"
        who = "every engine lets" if touch else "engines in which impacts take time let"
        what = f"`{a}` and `{b}` {how} {scene.where}: {who} both answer what strikes one of them, at once"
        note = Note(f"`{a}` is declared here", values.place(a))
        others = "" if touch else f", or {OTHERS}"
        apart = f"leave {_length(IMPACT * speed)} between them"
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
def sliding_mesh(scene: Scene) -> Iterator[Breach]:
    """A convex mesh that is sent off, and may slide."""
    values = scene.values
    loose = set(_loose(values))
    for action in values.spec.things:
        if action.kind != "action" or action.verb != "launch" or not values.there(action.name):
            continue
        name = values.property(action.name, "object")
        if name in loose and any(piece.solid.primitive is None for piece in pieces(values, name)):
            kinds = "neither box, ball, capsule nor cylinder"
            what = f"`{name}` is launched {scene.where} and is {kinds}; some engines brake it as it slides"
            remedy = f"make it of those, or {OTHERS}"
            yield Breach(what, values.place(name, "shape"), remedy, about=name)


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


RULES = (struck_in_a_row, rolling_cylinder, sliding_mesh, fast_and_thin)


def _touchable(values: Values) -> list[str]:
    """The objects that are there and can be touched."""
    objects = (t.name for t in values.spec.things if t.kind == "object")
    return [name for name in objects if values.there(name) and values.property(name, "solid")]


def _speeds(values: Values) -> Iterator[float]:
    """How fast (m/s) actions set things off or carry them."""
    for action in values.spec.things:
        if action.kind == "action" and values.there(action.name) and "speed" in action.properties:
            yield values.property(action.name, "speed")


def _bounce(values: Values, a: str, b: str) -> float:
    return math.sqrt(values.property(a, "restitution") * values.property(b, "restitution"))


def _lying(values: Values, name: str) -> Iterator[bool]:
    for piece in pieces(values, name):
        if isinstance(piece.solid, Cylinder) and disc(piece.solid.radius, piece.solid.height):
            axis = rotate(values.pose(name).orientation, rotate(piece.pose.orientation, UP))
            yield abs(dot(axis, UP)) < STEEP


def _free(values: Values) -> Iterator[str]:
    """Those that can be touched and move."""
    return (name for name in _touchable(values) if not values.property(name, "fixed"))


def _loose(values: Values) -> Iterator[str]:
    """Those that no joint holds, either."""
    joined = _joined(values)
    return (name for name in _free(values) if name not in joined)


def _joined(values: Values) -> set[str]:
    """The objects that have joints."""
    joints = [t.name for t in values.spec.things if t.kind == "joint" and values.there(t.name)]
    return {values.property(j, end) for j in joints for end in ("of", "to") if values.has(j, end)}


def _thickness(piece: Piece) -> float:
    """How thick (m) a piece is at least, along its own axes."""
    return min(piece.solid.reach(axis) + piece.solid.reach(times(-1.0, axis)) for axis in AXES)


def _length(metres: float) -> str:
    return units.told(float(f"{metres:.2g}"), units.LENGTH)
