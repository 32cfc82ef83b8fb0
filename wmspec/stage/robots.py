"""Arms on the stage: a reference to what one is made of, and what it does as ways of its joints and as holds."""

from __future__ import annotations

from wmspec.check.ir import Thing
from wmspec.layout.values import Values
from wmspec.resources import resource
from wmspec.robots.plan import ARMS, base, plan
from wmspec.stage.document import Document
from wmspec.stage.objects import object_path


def add_robot(doc: Document, robot: Thing, values: Values) -> None:
    """The prim of an arm, with the hand drawn back. Raises WmsError with its place if it cannot stand there."""
    pose = base(values, robot.name)
    prim = doc.add(object_path(robot.name), "Xform")
    prim.reference = str(resource(ARMS[robot.model].asset))
    sources = [f"{robot.name}.{name}" for name in ("on", "at", "yaw")]
    if values.has(robot.name, "on"):
        sources.append(f"{values.property(robot.name, 'on')}.pose")
    prim.set("xformOp:translate", "double3", pose.position, *sources)
    prim.set("xformOp:orient", "quatd", pose.orientation, *sources)
    prim.set("xformOpOrder", "token[]", ("xformOp:translate", "xformOp:orient"), uniform=True)


def add_action(doc: Document, action: Thing, values: Values) -> None:
    """What an arm does: a `reach`, and a `hold` below it if it takes something.

    Raises WmsError with its place if it cannot.
    """
    reach = plan(values)[action.name]
    path, here = f"/World/Episode/Actions/{action.name}", object_path(action.of)
    there, way = (f"{action.name}.there", f"{action.name}.object"), f"{action.name}.way"
    prim = doc.add(path, "WmsAction", (), there)
    prim.set("wms:verb", "token", "reach", uniform=True)
    prim.relate("wms:joints", tuple(f"{here}/{joint}" for joint in ARMS[values.spec.thing(action.of).model].joints))
    prim.set("wms:start", "double", values.property(action.name, "start"), f"{action.name}.start", uniform=True)
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
