"""Cameras and lights as prims."""

from __future__ import annotations

import math

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.objects import object_path
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import Vector
from wmspec.lang.check.tables.color_math import linear, rgb

#: Aperture and near and far planes (m) for scenes on a table or in a room.
APERTURE, NEAR, FAR = 24.0, 0.05, 50.0

#: Default background colour, sRGB.
BACKGROUND = (0.86, 0.88, 0.90)

Matrix = tuple[tuple[float, ...], ...]


def camera_path(name: str, values: Evaluator) -> str:
    """Return the path of a camera's prim: below the object that it rides on, if any."""
    if not values.has(name, "ride"):
        return f"/World/Cameras/{name}"
    return f"{object_path(values.reference(name, 'ride'))}/Cameras/{name}"


def add_camera(doc: Document, name: str, values: Evaluator) -> None:
    """Add the prim of a camera. Raises WmsError if it looks at itself, or its object is absent."""
    eye, target = values.vector(name, "at"), values.vector(name, "look_at")
    path = camera_path(name, values)
    if values.has(name, "ride"):
        ridden = values.reference(name, "ride")
        if not values.is_present(ridden):
            raise ImpossibleValue(
                f"the camera `{name}` rides on `{ridden}`, which is not there", values.source_location(name, "ride")
            )
        doc.add(path.rpartition("/")[0], "Scope", (), (f"{name}.ride",))
    prim = doc.add(path, "Camera", (), (f"{name}.ride",))
    prim.set(
        "xformOp:transform", "matrix4d", _look_at_matrix(eye, target, values, name), f"{name}.at", f"{name}.look_at"
    )
    prim.set("xformOpOrder", "token[]", ("xformOp:transform",), uniform=True)
    focal = APERTURE / 2 / math.tan(values.number(name, "fov") / 2)
    prim.set("focalLength", "float", focal, f"{name}.fov")
    prim.set("horizontalAperture", "float", APERTURE)
    prim.set("verticalAperture", "float", APERTURE)
    far = values.number(name, "far") if values.has(name, "far") else FAR
    prim.set("clippingRange", "float2", (NEAR, far), *((f"{name}.far",) if values.has(name, "far") else ()))


def _look_at_matrix(eye: Vector, target: Vector, values: Evaluator, name: str) -> Matrix:
    """Return USD's row-vector matrix of a camera at `eye` that looks at `target` with a level horizon."""
    forward = [t - e for e, t in zip(eye, target, strict=True)]
    length = math.hypot(*forward)
    if length < 1e-9:
        raise ImpossibleValue(f"the camera `{name}` looks at the very point where it is", values.source_location(name))
    z = [-f / length for f in forward]
    level = math.hypot(z[0], z[1])
    x = [-z[1] / level, z[0] / level, 0.0] if level > 1e-9 else [1.0, 0.0, 0.0]
    y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
    return ((*x, 0.0), (*y, 0.0), (*z, 0.0), (*eye, 1.0))


def add_light(doc: Document, name: str, world: str | None, values: Evaluator) -> None:
    """Add the prims of a light: a sun and a sky. Raises WmsError if it has no direction."""
    direction = values.vector(name, "direction")
    if math.hypot(*direction) < 1e-9:
        raise ImpossibleValue(f"the light `{name}` has no direction", values.source_location(name))
    shadows = f"{name}.shadows"
    shining = () if values.flag(name, "shadows") else ("ShadowAPI",)
    sun = doc.add(f"/World/Lights/{name}", "DistantLight", shining, (shadows,))
    if shining:
        sun.set("inputs:shadow:enable", "bool", False, shadows)
    aim = _look_at_matrix((0.0, 0.0, 0.0), direction, values, name)
    sun.set("xformOp:transform", "matrix4d", aim, f"{name}.direction")
    sun.set("xformOpOrder", "token[]", ("xformOp:transform",), uniform=True)
    sun.set("inputs:intensity", "float", values.number(name, "diffuse"), f"{name}.diffuse")
    background = rgb(values.text(world, "background")) if world else BACKGROUND
    sky = doc.add(f"/World/Lights/{name}_sky", "DomeLight")
    sky.set("inputs:intensity", "float", values.number(name, "ambient"), f"{name}.ambient")
    sky.set("inputs:color", "color3f", tuple(linear(c) for c in background), "world.background")
