"""The appearance of a scene at a time: painted colours, vanished bodies."""

from __future__ import annotations

from dataclasses import replace

from wmspec.sim.scene.model import Body, Paint, Scene, Surface, Vanish

#: s: closer times count as equal.
_SAME = 1e-9
#: Smaller differences of a colour channel (0..1) are rounding.
_SAME_COLOR = 1e-4


def appearance_at(scene: Scene, time: float) -> Scene:
    """Return the scene as visible at `time` (s); `scene` itself if nothing was painted or vanished."""
    past = sorted((a for a in scene.actions if isinstance(a, Paint) and a.start <= time + _SAME), key=lambda a: a.start)
    colors = {action.body: action.color for action in past}
    gone = vanished_bodies(scene, time)
    if not colors and not gone:
        return scene
    return replace(scene, bodies=tuple(_seen(b, colors.get(b.name), b.name in gone) for b in scene.bodies))


def vanished_bodies(scene: Scene, time: float) -> frozenset[str]:
    """Return the names of bodies that have vanished by `time` (s)."""
    return frozenset(a.body for a in scene.actions if isinstance(a, Vanish) and a.start <= time + _SAME)


def vanish_times(scene: Scene) -> dict[str, float]:
    """Return the time (s) at which each body vanishes that does."""
    times: dict[str, float] = {}
    for action in (a for a in scene.actions if isinstance(a, Vanish)):
        times[action.body] = min(action.start, times.get(action.body, action.start))
    return times


def _seen(body: Body, color: tuple[float, float, float] | None, gone: bool) -> Body:
    if gone:
        return replace(body, geoms=tuple(replace(geom, visible=False) for geom in body.geoms))
    if color is None:
        return body
    return replace(body, geoms=tuple(replace(g, surface=_painted(g.surface, color)) for g in body.geoms))


def _painted(surface: Surface, color: tuple[float, float, float]) -> Surface:
    """Return a surface in another colour; the same surface if it has that colour, up to rounding."""
    same = all(abs(a - b) < _SAME_COLOR for a, b in zip(surface.color, color, strict=True))
    return surface if same else replace(surface, color=color)
