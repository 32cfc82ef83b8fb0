"""Robots on the stage.

An arm references its asset and has joint trajectories and holds. Cars and walkers are carried bodies.
"""

from __future__ import annotations

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.placement import base
from wmspec.compile.robots import car
from wmspec.compile.robots.plan import ARMS, arm_of, plan
from wmspec.compile.robots.travel import travels
from wmspec.compile.stage import materials
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.objects import geometry, object_path
from wmspec.core.resources import resource
from wmspec.lang.check.ir.ir import Entity
from wmspec.lang.check.tables.color_math import rgb

#: Mass and moments of walkers and cars (kg, kg m²); without effect, but some importers require a mass.
WEIGHT, MOMENTS = 70.0, (16.0, 16.0, 1.0)


def add_robot(doc: Document, robot: Entity, values: Evaluator) -> None:
    """Add the prim of a robot in its initial state; an arm's hand is retracted.

    Raises WmsError with its location if the base pose is invalid.
    """
    pose, arm = base(values, robot.name), robot.model in ARMS
    path = object_path(robot.name)
    body = () if arm else ("PhysicsRigidBodyAPI", *(("PhysicsMassAPI",) if robot.model == "walker" else ()))
    prim = doc.add(path, "Xform", body, (f"{robot.name}.model",) if arm else ())
    sources = [f"{robot.name}.{name}" for name in ("on", "at", "yaw")]
    if values.has(robot.name, "on"):
        sources.append(f"{values.reference(robot.name, 'on')}.pose")
    prim.set("xformOp:translate", "double3", pose.position, *sources)
    prim.set("xformOp:orient", "quatd", pose.orientation, *sources)
    prim.set("xformOpOrder", "token[]", ("xformOp:translate", "xformOp:orient"), uniform=True)
    if arm:
        prim.reference = str(resource(arm_of(values, robot.name).asset))
        return
    prim.set("physics:kinematicEnabled", "bool", True)
    if robot.model == "car":
        _paint(doc, robot.name, values)
    else:
        prim.set("physics:mass", "float", WEIGHT)
        prim.set("physics:diagonalInertia", "float3", MOMENTS)
        prim.set("physics:principalAxes", "quatf", (1.0, 0.0, 0.0, 0.0))


def _paint(doc: Document, name: str, values: Evaluator) -> None:
    """Add the coloured shapes of a car."""
    doc.add(f"/World/Materials/{name}", "Scope")
    for part, piece, tone in car.parts():
        source = () if tone else (f"{name}.color",)
        shade = rgb(tone or values.text(name, "color"))
        material = materials.plain_material(doc, f"/World/Materials/{name}/{part}", shade, *source)
        prim = geometry(doc, f"{object_path(name)}/{part}", piece, (), (f"{name}.form",))
        prim.relate("material:binding", material)


def add_action(doc: Document, action: Entity, values: Evaluator) -> None:
    """Add the action of a robot. Raises WmsError with its location if it is infeasible."""
    (_reach if values.spec.thing(action.of).model in ARMS else _follow)(doc, action, values)


def _follow(doc: Document, action: Entity, values: Evaluator) -> None:
    """Add the path of a car or a walker."""
    travel, way = travels(values)[action.name], (f"{action.name}.way", f"{action.name}.duration")
    prim = doc.add(f"/World/Episode/Actions/{action.name}", "WmsAction", (), (f"{action.name}.there",))
    prim.set("wms:verb", "token", "follow", uniform=True)
    prim.relate("wms:object", object_path(action.of))
    prim.set("wms:start", "double", values.number(action.name, "start"), f"{action.name}.start", uniform=True)
    prim.set("wms:duration", "double", travel.times[-1], f"{action.name}.duration", uniform=True)
    prim.set("wms:points", "double3[]", travel.points, *way, uniform=True)
    prim.set("wms:times", "double[]", travel.times, f"{action.name}.duration", uniform=True)
    prim.set("wms:orientations", "quatd[]", travel.turns, *way, uniform=True)


def _reach(doc: Document, action: Entity, values: Evaluator) -> None:
    """Add a joint trajectory of an arm, with a `hold` below it for a grasp."""
    reach = plan(values)[action.name]
    path, here = f"/World/Episode/Actions/{action.name}", object_path(action.of)
    there, way = (f"{action.name}.there", f"{action.name}.object"), f"{action.name}.way"
    prim = doc.add(path, "WmsAction", (), there)
    prim.set("wms:verb", "token", "reach", uniform=True)
    prim.relate("wms:joints", tuple(f"{here}/{joint}" for joint in arm_of(values, action.of).joints))
    prim.set("wms:start", "double", values.number(action.name, "start"), f"{action.name}.start", uniform=True)
    prim.set("wms:duration", "double", reach.times[-1], f"{action.name}.duration", uniform=True)
    prim.set("wms:times", "double[]", reach.times, f"{action.name}.duration", uniform=True)
    prim.set("wms:values", "double[]", tuple(reach.values.reshape(-1).tolist()), way, uniform=True)
    if reach.hold:
        hold = doc.add(f"{path}/hold", "WmsAction", (), (*there, way))
        hold.set("wms:verb", "token", "hold", uniform=True)
        hold.relate("wms:object", object_path(reach.hold.object), f"{action.name}.object")
        hold.relate("wms:hand", f"{here}/hand")
        hold.set("wms:start", "double", reach.hold.start, way, uniform=True)
        hold.set("wms:duration", "double", reach.hold.stop - reach.hold.start, way, uniform=True)
        hold.set("wms:points", "double3[]", reach.hold.points, way, uniform=True)
