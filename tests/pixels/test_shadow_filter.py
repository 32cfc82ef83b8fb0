"""Edges of shadows are soft: a map of the sun is filtered over three by three texels, alike in all engines."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.engines import ENGINES
from tests.pixels.scenes import body, scene, views
from wmspec.sim.scene.model import Light, Shot, Surface
from wmspec.sim.scene.render.shadow_filter import REACH, deciding_texels, occlusion
from wmspec.sim.shapes import Box

NOTHING = np.float32(np.inf)


def half_plane(side: int, edge: int) -> Any:
    """A map that sees something at a distance of 1 in its first columns."""
    seen = np.full((side, side), NOTHING, np.float32)
    seen[:, :edge] = 1
    return seen


def test_a_straight_edge_becomes_a_ramp() -> None:
    x = np.linspace(2, 14, 97, dtype=np.float32)[None]
    shaded = occlusion(x, np.full_like(x, 8), np.full_like(x, 2), half_plane(16, 8))[0]
    assert np.all(np.diff(shaded) <= 1e-6)
    assert np.all(shaded[x[0] < 8 - REACH] == 1)
    assert np.all(shaded[x[0] > 8 + REACH] == 0)
    assert np.abs(np.diff(shaded)).max() < 0.1, "no step"


def test_points_nearer_to_the_sun_or_outside_its_map_are_lit() -> None:
    x = np.linspace(-40, 40, 81, dtype=np.float32)[None]
    rows = np.full_like(x, 4)
    assert not occlusion(x, rows, np.full_like(x, 0.5), half_plane(8, 8)).any()
    shaded = occlusion(x, rows, np.full_like(x, 2), half_plane(8, 8))[0]
    assert not shaded[(x[0] < -1) | (x[0] > 9)].any()
    assert shaded[(x[0] > 2) & (x[0] < 6)].all()


@given(st.integers(0, 2**32 - 1), st.floats(-15, 25), st.floats(0, 20))
def test_few_texels_decide_on_the_shadows_of_a_window(seed: int, first: float, extent: float) -> None:
    rng = np.random.default_rng(seed)
    seen = np.where(rng.random((12, 12)) < 0.7, rng.random((12, 12)), np.inf).astype(np.float32)
    x, y = (rng.uniform(start, start + extent, (6, 7)).astype(np.float32) for start in (first, rng.uniform(-15, 25)))
    away = rng.random((6, 7)).astype(np.float32)
    rows, columns = deciding_texels(y, 12), deciding_texels(x, 12)
    part = occlusion(x, y, away, seen[rows, columns], (rows.start, columns.start))
    np.testing.assert_array_equal(part, occlusion(x, y, away, seen))


@pytest.mark.parametrize("toward", [(0.35, 0.45, -1), (0.9, 0.1, -0.3), (-0.2, 0.9, -0.3), (0, 0, -1), (1, 0, -0.2)])
def test_shadows_are_alike_for_any_sun(toward: tuple[float, ...], renderer: Any) -> None:
    direction = np.array(toward) / np.linalg.norm(toward)
    floor = body("floor", "static", (0, 0, -0.05), Box((3.0, 3.0, 0.05)), Surface((0.8, 0.8, 0.8)))
    tower = body("tower", "dynamic", (0, 0, 0.1), Box((0.04, 0.04, 0.1)), Surface((0.8, 0.2, 0.2)))
    what = replace(scene(floor, tower, cameras=views()), light=Light(direction))
    poses = [one.pose for one in what.bodies]
    dark = []
    for engine in ENGINES:
        frame = renderer(engine, what, 128, 128).draw(Shot("top", poses))
        dark.append((frame.rgb.astype(float).mean(axis=2), frame.ids == 0))
    for (one, first), (other, second) in combinations(dark, 2):
        both = first & second
        assert np.mean(np.abs(one - other)[both] > 16) < 0.01
