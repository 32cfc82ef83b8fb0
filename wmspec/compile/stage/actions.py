"""Actions on objects as prims, one function per verb."""

from __future__ import annotations

import math
from pkgutil import resolve_name

from wmspec.compile.layout import motion
from wmspec.compile.layout.evaluator import ACTED_ON, Evaluator
from wmspec.compile.layout.geometry import pieces
from wmspec.compile.layout.surfaces import WORLD, contact_face, support_of
from wmspec.compile.stage.document import Document, Prim
from wmspec.compile.stage.joints import has_drive, has_joint, joint_path
from wmspec.compile.stage.objects import object_path
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import UP, Vector, dot, from_ypr, heading_vector, multiply, rotate, scale
from wmspec.lang.check.ir.ir import Entity
from wmspec.lang.check.tables.color_math import rgb
from wmspec.lang.check.tables.verbs import VERBS

#: Upper bounds on the cosine of a round object's axis with the vertical (lying), and with its path (rolling).
MAX_LYING_COSINE, MIN_ALONG_COSINE = 0.5, 0.99


def add_action(doc: Document, action: Entity, values: Evaluator, carried: dict[str, str]) -> None:
    """Add the prim of an action that happens. Raises WmsError with its location if it is infeasible."""
    name, verb = action.name, VERBS[action.verb]
    there = (f"{name}.there", *(f"{name}.{role}" for role in ACTED_ON), f"{name}.joint")
    prim = doc.add(f"/World/Episode/Actions/{name}", "WmsAction", (), there)
    prim.set("wms:verb", "token", verb.staged or action.verb, uniform=True)
    if "object" in action.properties:
        target = values.reference(name, "object")
        _require_able(action, target, values, carried)
        prim.relate("wms:object", object_path(target), f"{name}.object")
    prim.set("wms:start", "double", values.number(name, "start"), f"{name}.start", uniform=True)
    if values.has(name, "duration"):
        prim.set("wms:duration", "double", values.number(name, "duration"), f"{name}.duration", uniform=True)
    resolve_name(verb.author)(prim, action, values)


def _require_able(action: Entity, target: str, values: Evaluator, carried: dict[str, str]) -> None:
    """Raise unless the object can perform the verb."""
    if values.flag(target, "fixed") and action.verb != "paint":
        raise ImpossibleValue(
            f"`{target}` is fixed, so nothing can {action.verb} it", action.place, "let it be `fixed: false`"
        )
    if action.verb not in motion.CARRYING and target in carried and not VERBS[action.verb].allows_carried:
        what = f"`{target}` is carried by `{carried[target]}`, so `{action.verb}` cannot move it"
        raise ImpossibleValue(what, action.place, "`launch` it instead of carrying it, or carry what it rests on")
    if {"launch", "vanish", "teleport"} & {action.verb, VERBS[action.verb].staged} and has_joint(values, target):
        remedy = "use `impulse`" if action.verb == "launch" else "leave out the joint, or this"
        raise ImpossibleValue(f"a joint holds `{target}`, so it cannot {action.verb}", action.place, remedy)


def _heading(action: Entity, values: Evaluator) -> Vector:
    climb = values.number(action.name, "climb") if values.has(action.name, "climb") else 0.0
    return heading_vector(motion.heading_of(values.direction(action.name)), climb)


def _toward(action: Entity) -> tuple[str, ...]:
    return (f"{action.name}.direction", f"{action.name}.climb")


def _vector(prim: Prim, name: str, value: Vector, *sources: str) -> None:
    prim.set(name, "double3", value, *sources, uniform=True)


# ---------------------------------------------------------------- sudden velocities


def launch(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set velocity and spin at once."""
    name, target = action.name, values.reference(action.name, "object")
    speed = values.number(name, "speed")
    _velocity(prim, action, values, speed, f"{name}.speed")
    spin = _rolling(action, target, speed, values) if values.flag(name, "rolling") else (0.0, 0.0, 0.0)
    sources = (f"{name}.{p}" for p in ("speed", "direction", "rolling", "object"))
    _vector(prim, "wms:spin", spin, *sources, f"{target}.form")


def _velocity(prim: Prim, action: Entity, values: Evaluator, speed: float, *sources: str) -> None:
    prim.set("wms:speed", "double", speed, *sources, uniform=True)
    _vector(prim, "wms:direction", _heading(action, values), *_toward(action))


def _rolling(action: Entity, target: str, speed: float, values: Evaluator) -> Vector:
    """Return the angular velocity of a ball that rolls without slipping: up x velocity / radius."""
    made = pieces(values, target)
    if values.parts(target) or made[0].solid.symmetry != "ball":
        raise ImpossibleValue(f"`{target}` is not a sphere, so it cannot set off rolling", action.place)
    angle = motion.heading_of(values.direction(action.name))
    rate = speed / (made[0].solid.reach(UP))
    return (0.0 - math.sin(angle) * rate, math.cos(angle) * rate, 0.0)


def slide(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set the speed sqrt(2 mu g d) at which friction stops the object after a distance d."""
    name, target = action.name, values.reference(action.name, "object")
    held, here = support_of(values, target), values.pose(target).position
    face = contact_face(values, target, (WORLD, *here[:2]))
    if held is None or face is None:
        raise ImpossibleValue(
            f"`{target}` rests on nothing, so it cannot slide", action.place, "say `on:` what it rests"
        )
    base = held[1]
    if face.normal[2] < 1 - 1e-9:
        raise ImpossibleValue(f"what `{target}` rests on is not level, so it would not stop there", action.place)
    if _rolls(target, heading_vector(motion.heading_of(values.direction(name))), values):
        ball = pieces(values, target)[0].solid.symmetry == "ball"
        remedy = "say `launch(..., rolling: true)`" if ball else "stand it up, or slide it along its axis"
        raise ImpossibleValue(f"`{target}` is round and would roll on instead of sliding", action.place, remedy)
    rub = math.sqrt(values.number(target, "friction") * values.number(base, "friction"))
    speed = math.sqrt(2 * rub * values.gravity * values.number(name, "distance"))
    if speed == 0:
        raise ImpossibleValue(
            f"nothing would stop `{target}` sliding: there is no friction or no gravity", action.place
        )
    sources = (f"{name}.distance", f"{name}.object", f"{target}.friction", f"{base}.friction", "world.gravity")
    _velocity(prim, action, values, speed, *sources, f"{target}.{held[0]}")
    _vector(prim, "wms:spin", (0.0, 0.0, 0.0))


def _rolls(target: str, way: Vector, values: Evaluator) -> bool:
    """Whether an object is round where it rests and rolls in that direction; not along its own axis."""
    made = pieces(values, target)
    if len(made) > 1 or made[0].solid.symmetry == "none":
        return False
    axis = rotate(values.pose(target).compose(made[0].pose).orientation, UP)
    return made[0].solid.symmetry == "ball" or (
        abs(axis[2]) < MAX_LYING_COSINE and abs(dot(axis, way)) < MIN_ALONG_COSINE
    )


# ---------------------------------------------------------------- carried


def glide(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set a constant velocity for a while."""
    _velocity(prim, action, values, values.number(action.name, "speed"), f"{action.name}.speed")


def follow(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set a path."""
    stand = motion.placement_before(values, action)
    points, moments, turns = motion.timed_path(values, action, stand.pose.position)
    form = tuple(f"{action.name}.{p}" for p in ("path", "length", "width", "facing"))
    prim.set("wms:points", "double3[]", points, *form, *_toward(action), f"{action.name}.way", uniform=True)
    prim.set("wms:times", "double[]", moments, *form, *_toward(action), f"{action.name}.duration", uniform=True)
    if turns:
        turned = tuple(multiply(from_ypr(yaw), stand.pose.orientation) for yaw in turns)
        prim.set("wms:orientations", "quatd[]", turned, *form, *_toward(action), f"{action.name}.way", uniform=True)


def teleport(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set another pose at once. What keeps its turn has none here: when it moves freely, only the engine knows it."""
    name, before = action.name, motion.placement_before(values, action)
    pose = motion.teleport_target(values, action, before).pose
    sources = (f"{name}.to", f"{name}.yaw", f"{name}.way")
    _vector(prim, "wms:position", pose.position, *sources)
    if values.has(name, "yaw") or pose.orientation != before.pose.orientation:
        prim.set("wms:orientation", "quatd", pose.orientation, *sources, uniform=True)


# ---------------------------------------------------------------- at once, in the midst of it


def stop(prim: Prim, _action: Entity, _values: Evaluator) -> None:
    """Set velocity and spin to zero."""
    prim.set("wms:speed", "double", 0.0, uniform=True)
    _vector(prim, "wms:spin", (0.0, 0.0, 0.0))


def paint(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set another colour at once."""
    _vector(prim, "wms:color", rgb(values.text(action.name, "color")), f"{action.name}.color")


def vanish(_prim: Prim, _action: Entity, _values: Evaluator) -> None:
    """Add nothing: the object is removed by the verb itself."""


def pass_through(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set what the object goes through."""
    target, through = values.reference(action.name, "object"), values.reference(action.name, "through")
    if target == through:
        raise ImpossibleValue(f"`{target}` cannot go through itself", action.place, "name another object")
    prim.relate("wms:through", object_path(through), f"{action.name}.through")


# ---------------------------------------------------------------- pushed, released, driven


def impulse(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set an impulse."""
    strength = scale(values.number(action.name, "impulse"), _heading(action, values))
    _vector(prim, "wms:impulse", strength, f"{action.name}.impulse", *_toward(action))


def force(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set a force for a while."""
    strength = scale(values.number(action.name, "force"), _heading(action, values))
    _vector(prim, "wms:force", strength, f"{action.name}.force", *_toward(action))


def release(_prim: Prim, action: Entity, values: Evaluator) -> None:
    """Add nothing: the object is held until the start of the action."""
    target = values.reference(action.name, "object")
    if len(values.actions_on("drop", target)) + len(values.actions_on("release", target)) > 1:
        raise ImpossibleValue(f"`{target}` is let go more than once", action.place, "keep one `release` or `drop`")


def drive(prim: Prim, action: Entity, values: Evaluator) -> None:
    """Set another target of a drive."""
    joint = values.spec.thing(values.reference(action.name, "joint"))
    if not has_drive(joint, values):
        raise ImpossibleValue(f"the joint `{joint.name}` has no drive", action.place, "give it a `stiffness:`")
    prim.relate("wms:joint", joint_path(joint.name), f"{action.name}.joint")
    prim.set("wms:target", "double", values.number(action.name, "target"), f"{action.name}.target", uniform=True)
