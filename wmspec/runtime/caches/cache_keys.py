"""Hashes of the parts of a scene that physics and rendering read; the keys of caches.

The hash of a body is cached on it, since one body occurs in many scenes.
"""

from __future__ import annotations

from dataclasses import replace

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Body, Scene, Shot, Surface
from wmspec.sim.scene.model.digest import digest

_PLAIN = Surface()


def physics_key(scene: Scene) -> bytes:
    """Return the hash of what physics reads: scenes with equal keys have equal traces."""
    return cached_on(scene, _physics)


def form_key(scene: Scene) -> bytes:
    """Return the hash of what a picture shows, except poses and colours."""
    return cached_on(scene, _form)


def look_key(scene: Scene) -> bytes:
    """Return the hash of what a picture shows, except poses."""
    return cached_on(scene, _look)


def shot_key(shot: Shot) -> bytes:
    """Return the hash of the camera and all poses."""
    return digest(shot.camera, *[(pose.position.tobytes(), pose.orientation.tobytes()) for pose in shot.poses])


def _physics(scene: Scene) -> bytes:
    bodies = [cached_on(body, _body_physics) for body in scene.bodies]
    return digest(scene.gravity, scene.actions, bodies, scene.joints, scene.filtered, scene.duration, scene.rate)


def _body_physics(body: Body) -> bytes:
    return digest(replace(body, geoms=tuple(replace(geom, surface=_PLAIN) for geom in body.geoms)))


def _form(scene: Scene) -> bytes:
    appearances = [cached_on(body, _body_appearance) for body in scene.bodies]
    return digest(appearances, scene.cameras, scene.light, scene.background)


def _look(scene: Scene) -> bytes:
    return digest(form_key(scene), [cached_on(body, _body_colors) for body in scene.bodies])


def _body_appearance(body: Body) -> bytes:
    pieces = [(g.shape, g.pose, g.surface.texture, g.surface.repeats, g.collides) for g in body.geoms if g.visible]
    return digest(body.name, body.motion, pieces)


def _body_colors(body: Body) -> bytes:
    return digest([geom.surface for geom in body.geoms if geom.visible])
