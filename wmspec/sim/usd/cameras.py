"""Cameras and lights, with defaults that show the whole stage."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pxr import Gf, Usd

from wmspec.sim.scene.model import Body, Camera, Light
from wmspec.sim.scene.model.transform import apply, compose, inverse
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.usd.frames import StageFrame, split_transform, vector
from wmspec.sim.usd.prims import refuse, value
from wmspec.sim.usd.shader_inputs import srgb
from wmspec.sim.usd.substitutions import STRICT, Substitutions

BACKGROUND = (0.86, 0.88, 0.9)
"""Background colour, sRGB, of a stage without a DomeLight."""

_SUN = np.array((0.3, 0.5, -1.0)) / math.sqrt(1.34)
_FOVY = math.radians(40)
_FROM = np.array((0.0, -0.85, 0.53))
"""Direction of the default camera: in front, 32 degrees up."""


def camera(prim: Usd.Prim, name: str, body: Body | None, world: StageFrame) -> Camera:
    """Return a pinhole camera, attached to `body` if given.

    Raises: StageError: if it is orthographic or shifted, or has invalid numbers.
    """
    if value(prim, "projection", "perspective") != "perspective":
        refuse(prim, "only perspective cameras are supported", "author projection = perspective")
    if value(prim, "horizontalApertureOffset", 0.0) or value(prim, "verticalApertureOffset", 0.0):
        refuse(prim, "a camera with shifted apertures is not supported", "author aperture offsets of 0")
    aperture, focal = (float(value(prim, name, 0.0)) for name in ("verticalAperture", "focalLength"))
    near, far = (float(x) * world.meters for x in value(prim, "clippingRange", (1, 1e6)))
    if not (aperture > 0 and focal > 0 and 0 < near < far):
        refuse(prim, "it sees nothing", "author verticalAperture and focalLength above 0, clippingRange 0 < near < far")
    pose = split_transform(world.matrix(prim), prim).pose
    pose = compose(inverse(body.pose), pose) if body else pose
    return Camera(name, pose, 2 * math.atan(aperture / (2 * focal)), near, far, body.name if body else None)


def overview(bodies: Sequence[Body]) -> Camera:
    """Return a camera that shows all movable bodies, or all bodies if none is movable, from the front."""
    shown = [body for body in bodies if body.motion != "static"] or list(bodies)
    corners = [np.zeros((1, 3))] if not any(body.geoms for body in shown) else []
    signs = np.array(np.meshgrid((-1, 1), (-1, 1), (-1, 1))).reshape(3, -1).T
    for body in shown:
        corners += [apply(body.pose, apply(geom.pose, signs * geom.shape.half_extent)) for geom in body.geoms]
    points = np.concatenate(corners)
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = max(float(np.linalg.norm(points - center, axis=1).max()), 0.05)
    distance = 1.2 * radius / math.sin(_FOVY / 2)
    eye = center + distance * _FROM / np.linalg.norm(_FROM)
    return Camera("overview", look_at(eye, center), _FOVY, distance / 100, distance * 100)


def daylight(
    suns: Sequence[Usd.Prim], skies: Sequence[Usd.Prim], world: StageFrame, notes: Substitutions = STRICT
) -> tuple[Light, tuple[float, float, float]]:
    """Return the sun and the background colour (sRGB).

    Intensities of DistantLight and DomeLight are `diffuse` and `ambient` if wmspec wrote them or if they sum to 1.
    Other intensities are in units that engines lack; then the default split applies.

    Raises: StageError: if there are several lights of a kind, or the sky is an image.
    """
    for extra in (*suns[1:], *skies[1:]):
        reason = "only one DistantLight and one DomeLight are supported"
        notes.record(extra, reason, "the first one is used", "deactivate the others")
    direction = (
        vector(split_transform(world.matrix(suns[0]), suns[0]).rigid.TransformDir(Gf.Vec3d(0, 0, -1))) if suns else _SUN
    )
    background = _background(skies[0], notes) if skies else BACKGROUND
    shadows = not suns or bool(value(suns[0], "inputs:shadow:enable", True))
    diffuse, ambient = (float(value(p[0], "inputs:intensity", 1.0)) if p else 0.0 for p in (suns, skies))
    written = suns and skies and all(_from_spec(light) for light in (suns[0], skies[0]))
    if written or (suns and skies and math.isclose(diffuse + ambient, 1.0, abs_tol=1e-4)):
        return Light(direction, diffuse, ambient, shadows=shadows), background
    return Light(direction, shadows=shadows), background


def _from_spec(light: Usd.Prim) -> bool:
    """Whether a spec says how strong a light is."""
    return bool(light.GetAttribute("inputs:intensity").HasCustomDataKey("wms:from"))


def _background(sky: Usd.Prim, notes: Substitutions) -> tuple[float, float, float]:
    if (picture := value(sky, "inputs:texture:file")) and picture.path:
        remedy = "remove inputs:texture:file and author inputs:color"
        notes.record(sky, "a sky image is not supported", "its plain colour is used", remedy)
    return srgb(value(sky, "inputs:color", Gf.Vec3f(1)))
