"""The stage of one episode: every object, camera, light and action of the spec as standard prims."""

from __future__ import annotations

import math

from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Counterfactual, TaskSpec, Thing
from wmspec.design.depend import PLACEMENT
from wmspec.design.design import Instance
from wmspec.design.values import Values, rgb
from wmspec.errors import WmsError
from wmspec.scene.version import FORMAT_VERSION
from wmspec.stage.document import Document, Prim, Relation

RATE = 240

_PRIMS = {
    "box": "Cube",
    "cube": "Cube",
    "sphere": "Sphere",
    "cylinder": "Cylinder",
    "cone": "Cone",
    "capsule": "Capsule",
}
_FORM = ("shape", "size", "radius", "height")


def document(spec: TaskSpec, instance: Instance, change: Counterfactual | None = None) -> Document:
    """The stage of an instance, or of what it would be under a counterfactual.

    Raises WmsError with its place if a property has an impossible value.
    """
    values = Values(spec, instance.values, change)
    doc = Document({})
    doc.add("/World", "Xform")
    _physics(doc, spec, values)
    for scope in ("Objects", "Materials", "Cameras", "Lights"):
        doc.add(f"/World/{scope}", "Scope")
    actions = [t for t in spec.things if t.kind == "action" and not _left_out(t, change)]
    kinematic = {values.property(t.name, "object") for t in actions if t.verb == "glide"}
    for thing in spec.things:
        if thing.kind == "object":
            _object(doc, thing.name, values, thing.name in kinematic)
        elif thing.kind == "camera":
            _camera(doc, thing.name, values)
        elif thing.kind == "light":
            _light(doc, thing.name, spec, values)
    _episode(doc, spec, values)
    for action in actions:
        _action(doc, action, values)
    return doc


def _left_out(action: Thing, change: Counterfactual | None) -> bool:
    return change is not None and change.change == "without" and change.owner == action.name


def _world(spec: TaskSpec) -> str | None:
    return next((t.name for t in spec.things if t.kind == "world"), None)


def _physics(doc: Document, spec: TaskSpec, values: Values) -> None:
    world = _world(spec)
    gravity = values.property(world, "gravity") if world else 9.81
    prim = doc.add("/World/physics", "PhysicsScene")
    prim.set("physics:gravityDirection", "vector3f", (0.0, 0.0, -1.0))
    prim.set("physics:gravityMagnitude", "float", gravity, "world.gravity")


# ---------------------------------------------------------------- objects


def _object(doc: Document, name: str, values: Values, kinematic: bool) -> None:
    fixed = values.property(name, "fixed")
    if fixed and kinematic:
        raise WmsError(f"{values.spec.thing(name).place}: `{name}` is fixed, so it cannot glide")
    if not fixed and not values.property(name, "solid"):
        raise WmsError(f"{values.spec.thing(name).place}: `{name}` cannot be touched, so it must be fixed")
    path = f"/World/Objects/{name}"
    body = doc.add(path, "Xform", () if fixed else ("PhysicsRigidBodyAPI",), (f"{name}.fixed",))
    placement = tuple(f"{name}.{p}" for p in PLACEMENT)
    half = values.property(name, "yaw") / 2
    body.set("xformOp:translate", "double3", values.position(name), *placement)
    body.set("xformOp:orient", "quatd", (math.cos(half), 0.0, 0.0, math.sin(half)), f"{name}.yaw")
    body.set("xformOpOrder", "token[]", ("xformOp:translate", "xformOp:orient"), uniform=True)
    if kinematic:
        body.set("physics:kinematicEnabled", "bool", True)
    shape = _shape(doc, name, values)
    _mass(shape, name, values, fixed)
    _material(doc, name, shape, values)


def _shape(doc: Document, name: str, values: Values) -> Prim:
    form = tuple(f"{name}.{p}" for p in _FORM)
    kind = values.property(name, "shape")
    x, y, z = values.extent(name)
    solid = ("PhysicsCollisionAPI", "PhysicsMassAPI") if values.property(name, "solid") else ()
    schemas = (*solid, "MaterialBindingAPI")
    prim = doc.add(f"/World/Objects/{name}/{kind}", _PRIMS[kind], schemas, (*form, f"{name}.solid"))
    corner = (x / 2, y / 2, z / 2)
    if kind in ("box", "cube"):
        prim.set("size", "double", 1.0)
        prim.set("xformOp:scale", "double3", (x, y, z), *form)
        prim.set("xformOpOrder", "token[]", ("xformOp:scale",), uniform=True)
        corner = (0.5, 0.5, 0.5)
    else:
        prim.set("radius", "double", x / 2, *form)
    if kind in ("cylinder", "cone", "capsule"):
        prim.set("height", "double", z - x if kind == "capsule" else z, *form)
        prim.set("axis", "token", "Z", uniform=True)
    prim.set("extent", "float3[]", (tuple(-c for c in corner), corner), *form)
    return prim


def _mass(shape: Prim, name: str, values: Values, fixed: bool) -> None:
    if values.has(name, "mass"):
        shape.set("physics:mass", "float", values.property(name, "mass"), f"{name}.mass")
    elif not fixed:
        shape.set("physics:density", "float", values.property(name, "density"), f"{name}.density")


def _material(doc: Document, name: str, shape: Prim, values: Values) -> None:
    """One material for both looks and touch: importers that know a single binding find both there."""
    path = f"/World/Materials/{name}"
    material = doc.add(path, "Material", ("PhysicsMaterialAPI",))
    material.relations["outputs:surface"] = Relation((f"{path}/surface.outputs:surface",))
    friction = values.property(name, "friction")
    material.set("physics:staticFriction", "float", friction, f"{name}.friction")
    material.set("physics:dynamicFriction", "float", friction, f"{name}.friction")
    material.set("physics:restitution", "float", values.property(name, "restitution"), f"{name}.restitution")
    surface = doc.add(f"{path}/surface", "Shader")
    surface.set("info:id", "token", "UsdPreviewSurface", uniform=True)
    color = tuple(_linear(c) for c in rgb(values.property(name, "color")))
    surface.set("inputs:diffuseColor", "color3f", color, f"{name}.color", f"{name}.material", f"{name}.image")
    surface.set(
        "inputs:roughness", "float", values.property(name, "roughness"), f"{name}.roughness", f"{name}.material"
    )
    surface.set("inputs:metallic", "float", values.property(name, "metallic"), f"{name}.metallic", f"{name}.material")
    surface.set("outputs:surface", "token", None)
    shape.relate("material:binding", path)


def _linear(c: float) -> float:
    """SRGB to linear light (IEC 61966-2-1)."""
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


# ---------------------------------------------------------------- eyes and lights

#: An aperture and near and far planes (m) that suit scenes on a table or in a room.
APERTURE, NEAR, FAR = 24.0, 0.05, 50.0


def _camera(doc: Document, name: str, values: Values) -> None:
    eye, target = values.property(name, "at"), values.property(name, "look_at")
    prim = doc.add(f"/World/Cameras/{name}", "Camera")
    prim.set("xformOp:transform", "matrix4d", _looking(eye, target, values, name), f"{name}.at", f"{name}.look_at")
    prim.set("xformOpOrder", "token[]", ("xformOp:transform",), uniform=True)
    focal = APERTURE / 2 / math.tan(values.property(name, "fov") / 2)
    prim.set("focalLength", "float", focal, f"{name}.fov")
    prim.set("horizontalAperture", "float", APERTURE)
    prim.set("verticalAperture", "float", APERTURE)
    prim.set("clippingRange", "float2", (NEAR, FAR))


def _looking(
    eye: tuple[float, ...], target: tuple[float, ...], values: Values, name: str
) -> tuple[tuple[float, ...], ...]:
    """USD's row-vector matrix of a camera at `eye` that looks at `target`, the horizon level."""
    forward = [t - e for e, t in zip(eye, target, strict=True)]
    length = math.hypot(*forward)
    if length < 1e-9:
        raise WmsError(f"{values.spec.thing(name).place}: the camera `{name}` looks at the very point where it is")
    z = [-f / length for f in forward]
    level = math.hypot(z[0], z[1])
    x = [-z[1] / level, z[0] / level, 0.0] if level > 1e-9 else [1.0, 0.0, 0.0]
    y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
    return ((*x, 0.0), (*y, 0.0), (*z, 0.0), (*eye, 1.0))


def _light(doc: Document, name: str, spec: TaskSpec, values: Values) -> None:
    direction = values.property(name, "direction")
    if math.hypot(*direction) < 1e-9:
        raise WmsError(f"{values.spec.thing(name).place}: the light `{name}` has no direction")
    sun = doc.add(f"/World/Lights/{name}", "DistantLight")
    aim = _looking((0.0, 0.0, 0.0), direction, values, name)
    sun.set("xformOp:transform", "matrix4d", aim, f"{name}.direction")
    sun.set("xformOpOrder", "token[]", ("xformOp:transform",), uniform=True)
    sun.set("inputs:intensity", "float", values.property(name, "diffuse"), f"{name}.diffuse")
    world = _world(spec)
    background = rgb(values.property(world, "background")) if world else (0.86, 0.88, 0.90)
    sky = doc.add(f"/World/Lights/{name}_sky", "DomeLight")
    sky.set("inputs:intensity", "float", values.property(name, "ambient"), f"{name}.ambient")
    sky.set("inputs:color", "color3f", tuple(_linear(c) for c in background), "world.background")


# ---------------------------------------------------------------- what happens


def _episode(doc: Document, spec: TaskSpec, values: Values) -> None:
    episode = doc.add("/World/Episode", "WmsEpisode")
    episode.set("wms:formatVersion", "int", FORMAT_VERSION, uniform=True)
    episode.set("wms:task", "string", spec.name, uniform=True)
    episode.set("wms:duration", "double", values.ref("end"), "end", uniform=True)
    episode.set("wms:rate", "int", RATE, uniform=True)
    doc.add("/World/Episode/Actions", "Scope")
    doc.add("/World/Episode/Observations", "Scope")
    for observation, times in observed(spec, values):
        prim = doc.add(f"/World/Episode/Observations/{observation}", "WmsObservation")
        prim.relate("wms:camera", f"/World/Cameras/{observation}")
        prim.set("wms:times", "double[]", times, f"observe.{observation}", uniform=True)


def observed(spec: TaskSpec, values: Values) -> list[tuple[str, tuple[float, ...]]]:
    """The cameras that look, and all the times (s) at which each does, in order.

    Raises WmsError if one is outside the episode.
    """
    end = values.ref("end")
    found: dict[str, set[float]] = {}
    for observation in spec.observations:
        times = evaluate(observation.times, values)
        for time in times:
            if not -1e-9 <= time <= end + 1e-9:
                raise WmsError(f"{observation.place}: {time:g} s is outside the episode, which lasts {end:g} s")
        found.setdefault(observation.camera, set()).update(times)
    return [(camera, tuple(sorted(times))) for camera, times in found.items()]


def _action(doc: Document, action: Thing, values: Values) -> None:
    name = action.name
    target = values.property(name, "object")
    if values.property(target, "fixed"):
        raise WmsError(f"{action.place}: `{target}` is fixed, so nothing can {action.verb} it")
    angle, speed = values.property(name, "direction"), values.property(name, "speed")
    heading = (math.cos(angle), math.sin(angle), 0.0)
    prim = doc.add(f"/World/Episode/Actions/{name}", "WmsAction")
    prim.set("wms:verb", "token", action.verb, uniform=True)
    prim.relate("wms:object", f"/World/Objects/{target}", f"{name}.object")
    prim.set("wms:start", "double", values.property(name, "start"), f"{name}.start", uniform=True)
    prim.set("wms:speed", "double", speed, f"{name}.speed", uniform=True)
    prim.set("wms:direction", "double3", heading, f"{name}.direction", uniform=True)
    if action.verb == "glide":
        prim.set("wms:duration", "double", values.property(name, "duration"), f"{name}.duration", uniform=True)
    else:
        spin = _rolling(action, target, values) if values.property(name, "rolling") else (0.0, 0.0, 0.0)
        sources = [f"{name}.{p}" for p in ("speed", "direction", "rolling")] + [f"{target}.{p}" for p in _FORM]
        prim.set("wms:spin", "double3", spin, *sources, uniform=True)


def _rolling(action: Thing, target: str, values: Values) -> tuple[float, float, float]:
    """The angular velocity of a ball that rolls without slipping: up x velocity / radius."""
    if values.property(target, "shape") != "sphere":
        raise WmsError(f"{action.place}: `{target}` is not a sphere, so it cannot set off rolling")
    angle, speed = values.property(action.name, "direction"), values.property(action.name, "speed")
    rate = speed / (values.extent(target)[0] / 2)
    return (0.0 - math.sin(angle) * rate, math.cos(angle) * rate, 0.0)
