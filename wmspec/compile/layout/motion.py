"""Where objects are carried: what `glide`, `follow` and `teleport` do to one object, one after the other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from wmspec.compile.layout import paths
from wmspec.compile.layout.geometry import own_turn
from wmspec.compile.layout.placement import rest
from wmspec.compile.layout.surfaces import is_point
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import Pose, Vector, add, heading, multiply, times, turn
from wmspec.lang.check.ir.ir import TaskSpec, Thing
from wmspec.lang.check.tables.verbs import VERBS
from wmspec.lang.check.tables.vocabulary import HEADINGS

if TYPE_CHECKING:
    from wmspec.compile.layout.values import Values

#: Verbs that carry an object whatever is in its way, which makes it kinematic.
CARRYING = tuple(name for name, verb in VERBS.items() if verb.carries)


@dataclass(frozen=True)
class Stand:
    """Where an object is between two moves, and its yaw (rad) then."""

    pose: Pose
    yaw: float


def carriers(values: Values) -> dict[str, str]:
    """The objects that are carried, which makes them kinematic, each with one of the actions that carry it."""
    carrying: dict[str, str] = {}
    for action in values.spec.things:
        if action.kind == "action" and not action.of and action.verb in CARRYING and values.there(action.name):
            carrying.setdefault(values.reference(action.name, "object"), action.name)
    return carrying


def carrier_sources(spec: TaskSpec) -> frozenset[str]:
    """The sources that decide which objects are carried."""
    acting = (t.name for t in spec.things if t.kind == "action" and not t.of and t.verb in CARRYING)
    return frozenset(f"{name}.{what}" for name in acting for what in ("there", "object"))


def before(values: Values, action: Thing) -> Stand:
    """Where the object of a carrying action is when it begins."""
    owner = values.reference(action.name, "object")
    stand = Stand(values.pose(owner), values.number(owner, "yaw"))
    moves = sorted((a for verb in CARRYING for a in values.acting(verb, owner)), key=lambda a: _start(values, a))
    for move in moves[: next(i for i, m in enumerate(moves) if m.name == action.name)]:
        stand = after(values, move, stand)
    return stand


def _start(values: Values, action: Thing) -> float:
    start = values.number(action.name, "start")
    return start


def after(values: Values, move: Thing, stand: Stand) -> Stand:
    """Where the object is when a move is over that began with it so."""
    if move.verb == "teleport":
        return landed(values, move, stand)
    if move.verb == "follow":
        points, _, turns = way(values, move, stand.pose.position)
        gained = turns[-1] if turns else 0.0
        pose = Pose(points[-1], multiply(turn(gained), stand.pose.orientation) if gained else stand.pose.orientation)
        return Stand(pose, stand.yaw + gained)
    speed, duration = values.number(move.name, "speed"), values.number(move.name, "duration")
    gone = times(speed * duration, heading(angle(values.direction(move.name))))
    return replace(stand, pose=Pose(add(stand.pose.position, gone), stand.pose.orientation))


def landed(values: Values, action: Thing, stand: Stand) -> Stand:
    """Where a teleport puts its object: at a point in space, or resting on what it rested on at another place."""
    owner, to = values.reference(action.name, "object"), values.spot(action.name, "to")
    yaw = values.number(action.name, "yaw") if values.has(action.name, "yaw") else stand.yaw
    _, pitch, roll = own_turn(values, owner)
    if is_point(to) and len(to) == 3:
        return Stand(Pose(to, turn(yaw, pitch, roll)), yaw)
    return Stand(rest(values, owner, to, yaw, pitch, roll), yaw)


def way(
    values: Values, action: Thing, origin: Vector
) -> tuple[tuple[Vector, ...], tuple[float, ...], tuple[float, ...]]:
    """The points (m, in the world) of a path that begins at `origin`, and the times (s) since its start.

    If it turns with its path, also how far (rad) it has turned at each point; else nothing.
    """
    name = action.name
    form, length, width = values.property(name, "path"), values.number(name, "length"), values.number(name, "width")
    points = paths.named(form, length, width) if isinstance(form, str) else values.points(name, "path")
    turned = paths.turned(points, angle(values.direction(name)))
    points, turns = paths.faced(turned) if values.flag(action.name, "facing") else (turned, ())
    line, moments = paths.walked(points, values.number(action.name, "duration"))
    if len(line) < 2 or moments[-1] <= 0:
        raise ImpossibleValue(
            f"the path of `{action.name}` leads nowhere", action.place, "give it a length and a time above 0"
        )
    return tuple(add(origin, point) for point in line), moments, turns


def angle(direction: str | float) -> float:
    """The heading (rad) that a direction word or an angle says."""
    return HEADINGS[direction] if isinstance(direction, str) else direction
