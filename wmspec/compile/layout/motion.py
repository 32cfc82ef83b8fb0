"""Motion of carried objects: the poses that `glide`, `follow` and `teleport` produce in sequence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from wmspec.compile.layout import paths
from wmspec.compile.layout.geometry import own_rotation
from wmspec.compile.layout.placement import rest
from wmspec.compile.layout.surfaces import is_point
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import Pose, Vector, add, from_ypr, heading_vector, multiply, scale
from wmspec.lang.check.ir.ir import Entity, TaskSpec
from wmspec.lang.check.tables.verbs import VERBS
from wmspec.lang.check.tables.vocabulary import HEADINGS

if TYPE_CHECKING:
    from wmspec.compile.layout.evaluator import Evaluator

#: Verbs that move an object along a fixed path, which makes it kinematic.
CARRYING = tuple(name for name, verb in VERBS.items() if verb.carries)
#: Verbs that tell where an object is. `teleport` makes only objects kinematic that cannot move freely: those not solid.
PLACING = (*CARRYING, "teleport")


@dataclass(frozen=True)
class Placement:
    """The pose of an object between two moves, and its yaw (rad)."""

    pose: Pose
    yaw: float


def carriers(values: Evaluator) -> dict[str, str]:
    """Return the carried (kinematic) objects, each with one of the actions that carry it."""
    carrying: dict[str, str] = {}
    for action in values.spec.things:
        if action.kind == "action" and not action.of and action.verb in PLACING and values.is_present(action.name):
            owner = values.reference(action.name, "object")
            if action.verb in CARRYING or not values.flag(owner, "solid"):
                carrying.setdefault(owner, action.name)
    return carrying


def carrier_sources(spec: TaskSpec) -> frozenset[str]:
    """Return the sources that determine which objects are carried."""
    acting = (t.name for t in spec.things if t.kind == "action" and not t.of and t.verb in PLACING)
    return frozenset(f"{name}.{what}" for name in acting for what in ("there", "object"))


def placement_before(values: Evaluator, action: Entity) -> Placement:
    """Return where the object of a carrying action is when the action begins."""
    owner = values.reference(action.name, "object")
    stand = Placement(values.pose(owner), values.number(owner, "yaw"))
    moves = sorted((a for verb in PLACING for a in values.actions_on(verb, owner)), key=lambda a: _start(values, a))
    for move in moves[: next(i for i, m in enumerate(moves) if m.name == action.name)]:
        stand = placement_after(values, move, stand)
        if move.verb == "teleport":
            stand = replace(stand, pose=_carried_on(values, moves, move, stand.pose))
    return stand


def _carried_on(values: Evaluator, moves: Sequence[Entity], teleport: Entity, pose: Pose) -> Pose:
    """Return where the glides that a teleport interrupts end, given where it puts the object."""
    time = _start(values, teleport)
    for glide in (move for move in moves if move.verb == "glide"):
        left = _start(values, glide) + values.number(glide.name, "duration") - time
        if _start(values, glide) < time and left > 0:
            gone = scale(
                values.number(glide.name, "speed") * left, heading_vector(heading_of(values.direction(glide.name)))
            )
            pose = Pose(add(pose.position, gone), pose.orientation)
    return pose


def _start(values: Evaluator, action: Entity) -> float:
    return values.number(action.name, "start")


def placement_after(values: Evaluator, move: Entity, stand: Placement) -> Placement:
    """Return where the object is when a move is over, given where it was when the move began."""
    if move.verb == "teleport":
        return teleport_target(values, move, stand)
    if move.verb == "follow":
        points, _, turns = timed_path(values, move, stand.pose.position)
        gained = turns[-1] if turns else 0.0
        pose = Pose(
            points[-1], multiply(from_ypr(gained), stand.pose.orientation) if gained else stand.pose.orientation
        )
        return Placement(pose, stand.yaw + gained)
    speed, duration = values.number(move.name, "speed"), values.number(move.name, "duration")
    gone = scale(speed * duration, heading_vector(heading_of(values.direction(move.name))))
    return replace(stand, pose=Pose(add(stand.pose.position, gone), stand.pose.orientation))


def teleport_target(values: Evaluator, action: Entity, stand: Placement) -> Placement:
    """Return where a teleport puts its object: at a point in space, or at another place of its support."""
    owner, to = values.reference(action.name, "object"), values.spot(action.name, "to")
    yaw = values.number(action.name, "yaw") if values.has(action.name, "yaw") else stand.yaw
    _, pitch, roll = own_rotation(values, owner)
    if is_point(to) and len(to) == 3:
        return Placement(Pose(to, from_ypr(yaw, pitch, roll)), yaw)
    return Placement(rest(values, owner, to, yaw, pitch, roll), yaw)


def timed_path(
    values: Evaluator, action: Entity, origin: Vector
) -> tuple[tuple[Vector, ...], tuple[float, ...], tuple[float, ...]]:
    """Return the points (m, world) of a path that begins at `origin`, and the times (s) since its start.

    If the object turns with the path, also return its heading change (rad) at each point; else an empty tuple.
    """
    name = action.name
    form, length, width = values.property(name, "path"), values.number(name, "length"), values.number(name, "width")
    points = paths.named_path(form, length, width) if isinstance(form, str) else values.points(name, "path")
    turned = paths.rotated_points(points, heading_of(values.direction(name)))
    points, turns = paths.aligned_points(turned) if values.flag(action.name, "facing") else (turned, ())
    line, moments = paths.timed_points(points, values.number(action.name, "duration"))
    if len(line) < 2 or moments[-1] <= 0:
        raise ImpossibleValue(
            f"the path of `{action.name}` leads nowhere", action.place, "give it a length and a time above 0"
        )
    return tuple(add(origin, point) for point in line), moments, turns


def heading_of(direction: str | float) -> float:
    """Return the heading (rad) of a direction word or an angle."""
    return HEADINGS[direction] if isinstance(direction, str) else direction
