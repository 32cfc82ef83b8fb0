"""What physics and pictures read of a scene, as hashes: by them traces, renderers and pictures are shared.

The hash of a body is kept with it, since one body is in many scenes.
"""

from __future__ import annotations

from dataclasses import replace

from wmspec.core.memoize import cached_on
from wmspec.sim.scene.model import Body, Scene, Shot, Surface
from wmspec.sim.scene.model.digest import digest

_PLAIN = Surface()


def physics_key(scene: Scene) -> bytes:
    """What physics reads of a scene: two scenes with the same key have the same trace."""
    return cached_on(scene, _physics)


def form_key(scene: Scene) -> bytes:
    """What a picture shows of a scene apart from poses and colours."""
    return cached_on(scene, _form)


def look_key(scene: Scene) -> bytes:
    """What a picture shows of a scene apart from poses."""
    return cached_on(scene, _look)


def shot_key(shot: Shot) -> bytes:
    """From where a picture is taken, and where everything is."""
    return digest(shot.camera, *[(pose.position.tobytes(), pose.orientation.tobytes()) for pose in shot.poses])


def _physics(scene: Scene) -> bytes:
    bodies = [cached_on(body, _felt) for body in scene.bodies]
    return digest(scene.gravity, scene.actions, bodies, scene.joints, scene.filtered, scene.duration, scene.rate)


def _felt(body: Body) -> bytes:
    return digest(replace(body, geoms=tuple(replace(geom, surface=_PLAIN) for geom in body.geoms)))


def _form(scene: Scene) -> bytes:
    return digest([cached_on(body, _shown) for body in scene.bodies], scene.cameras, scene.light, scene.background)


def _look(scene: Scene) -> bytes:
    return digest(form_key(scene), [cached_on(body, _paint) for body in scene.bodies])


def _shown(body: Body) -> bytes:
    pieces = [(g.shape, g.pose, g.surface.texture, g.surface.repeats, g.collides) for g in body.geoms if g.visible]
    return digest(body.name, body.motion, pieces)


def _paint(body: Body) -> bytes:
    return digest([geom.surface for geom in body.geoms if geom.visible])
