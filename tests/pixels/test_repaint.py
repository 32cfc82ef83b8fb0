"""Other colours need no new renderer: pictures are the same as from a new one, and come sooner."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.engines import installed
from tests.pixels.scenes import SUN
from wmspec.runtime.caches.cache_keys import form_key, look_key
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Light, Pose, Scene, Shot, Surface


def painted(scene: Scene, shift: int) -> Scene:
    """The scene in other colours, textured things too."""
    bodies = []
    for i, body in enumerate(scene.bodies):
        tone = (0.2 + 0.1 * ((i + shift) % 7), 0.9 - 0.1 * ((i + 2 * shift) % 7), 0.3 + 0.05 * ((i * shift) % 5))
        geoms = tuple(replace(geom, surface=replace(geom.surface, color=tone)) for geom in body.geoms)
        bodies.append(replace(body, geoms=geoms))
    return replace(scene, bodies=tuple(bodies))


def shot(scene: Scene) -> Shot:
    return Shot("front", [body.pose for body in scene.bodies])


def test_a_repainted_renderer_draws_as_a_new_one(engine: str, table: Scene) -> None:
    installed(engine)
    studio = RenderCache(engine, 96, 96)
    studio.draw(table, shot(table))
    for shift in (1, 2):
        fresh = RenderCache(engine, 96, 96)
        other = painted(table, shift)
        one, new = studio.draw(other, shot(other)), fresh.draw(other, shot(other))
        fresh.close()
        assert np.array_equal(one.rgb, new.rgb)
        assert np.array_equal(one.ids, new.ids)
    studio.close()


def test_things_of_many_colours_are_repainted_in_sapien(table: Scene) -> None:
    installed("sapien")
    first = table.bodies[0]
    row = [Pose(np.array([0.1 * i, 0.0, 0.1]), first.pose.orientation) for i in range(3)]

    def coloured(*tones: tuple[float, float, float]) -> Scene:
        looks = [replace(first.geoms[0], pose=at, surface=Surface(tone)) for at, tone in zip(row, tones, strict=True)]
        return replace(table, bodies=(replace(first, geoms=tuple(looks)), *table.bodies[1:]))

    red, green, blue = (0.8, 0.1, 0.1), (0.1, 0.6, 0.1), (0.1, 0.1, 0.8)
    studio, fresh = RenderCache("sapien", 96, 96), RenderCache("sapien", 96, 96)
    studio.draw(coloured(red, red, green), shot(table))
    one, new = (cache.draw(coloured(green, blue, red), shot(table)) for cache in (studio, fresh))
    assert np.array_equal(one.rgb, new.rgb)
    assert all(
        (np.abs(new.rgb.astype(int) - 255 * np.array(tone)).max(axis=2) < 128).any() for tone in (red, green, blue)
    )
    studio.close()
    fresh.close()


def test_only_colours_share_a_built_form(table: Scene) -> None:
    other = painted(table, 1)
    assert form_key(other) == form_key(table)
    assert look_key(other) != look_key(table)
    assert form_key(replace(table, light=Light(SUN, 0.5, 0.5))) != form_key(table)
    assert form_key(replace(table, bodies=table.bodies[1:])) != form_key(table)
    still = replace(table, bodies=tuple(replace(body, motion="static", inertia=None) for body in table.bodies))
    assert form_key(still) != form_key(table)


def test_repainting_builds_nothing(engine: str, table: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    built = []
    make = installed(engine).renderer
    monkeypatch.setattr(backend(engine), "renderer", lambda *how: built.append(how) or make(*how))
    studio = RenderCache(engine, 64, 64)
    pictures = [studio.draw(painted(table, shift), shot(table)).rgb for shift in range(6)]
    studio.close()
    assert len(built) == 1
    assert len({picture.tobytes() for picture in pictures}) == 6
