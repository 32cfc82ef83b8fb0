"""What a scene looks like at a time: in other colours than at the start, without what has vanished."""

from __future__ import annotations

from dataclasses import replace

from wmspec.sim.scene.model import Body, Paint, Scene, Vanish

#: Times (s) that are nearer than this are one.
_SAME = 1e-9


def shown_at(scene: Scene, time: float) -> Scene:
    """The scene as pictures show it at a time (s): `scene` itself if nothing has been painted or has vanished."""
    past = sorted((a for a in scene.actions if isinstance(a, Paint) and a.start <= time + _SAME), key=lambda a: a.start)
    colors = {action.body: action.color for action in past}
    gone = vanished(scene, time)
    if not colors and not gone:
        return scene
    return replace(scene, bodies=tuple(_seen(b, colors.get(b.name), b.name in gone) for b in scene.bodies))


def vanished(scene: Scene, time: float) -> frozenset[str]:
    """The names of the bodies that have vanished by a time (s)."""
    return frozenset(a.body for a in scene.actions if isinstance(a, Vanish) and a.start <= time + _SAME)


def _seen(body: Body, color: tuple[float, float, float] | None, gone: bool) -> Body:
    if gone:
        return replace(body, geoms=tuple(replace(geom, visible=False) for geom in body.geoms))
    if color is None:
        return body
    return replace(body, geoms=tuple(replace(g, surface=replace(g.surface, color=color)) for g in body.geoms))
