"""The three engines draw the same picture: the same objects, colours and distances, pixel by pixel."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest

from tests.engines import ENGINES
from wmspec.sim.scene.model import Frame, Scene, Shot

SIZE = 256


@pytest.fixture(scope="module", params=["front", "side", "top", "oblique", "riding"])
def frames(request: pytest.FixtureRequest, table: Scene, renderer: Any) -> dict[str, Frame]:
    """The same shot from every engine."""
    shot = Shot(request.param, [body.pose for body in table.bodies])
    return {engine: renderer(engine, table, SIZE, SIZE).draw(shot, depth=True) for engine in ENGINES}


@pytest.mark.parametrize("pair", list(combinations(ENGINES, 2)), ids="-".join)
def test_objects_cover_the_same_pixels(pair: tuple[str, str], frames: dict[str, Frame]) -> None:
    a, b = (frames[engine].ids for engine in pair)
    assert np.array_equal(np.unique(a), np.unique(b))
    for body in np.unique(a):
        assert np.sum((a == body) & (b == body)) / np.sum((a == body) | (b == body)) >= 0.99


@pytest.mark.parametrize("pair", list(combinations(ENGINES, 2)), ids="-".join)
def test_objects_have_the_same_colour(pair: tuple[str, str], frames: dict[str, Frame]) -> None:
    a, b = (frames[engine] for engine in pair)
    for body in np.unique(a.ids):
        apart = a.rgb[a.ids == body].mean(axis=0) - b.rgb[b.ids == body].mean(axis=0)
        assert np.abs(apart).max() < 4


@pytest.mark.parametrize("pair", list(combinations(ENGINES, 2)), ids="-".join)
def test_pictures_differ_in_few_pixels(pair: tuple[str, str], frames: dict[str, Frame]) -> None:
    a, b = (frames[engine].rgb.astype(float) for engine in pair)
    assert np.abs(a - b).mean() < 2
    assert np.mean(np.abs(a - b).max(axis=2) > 16) < 0.03


@pytest.mark.parametrize("pair", list(combinations(ENGINES, 2)), ids="-".join)
def test_objects_are_equally_far(pair: tuple[str, str], frames: dict[str, Frame]) -> None:
    a, b = (frames[engine] for engine in pair)
    inside = interior(a.ids) & interior(b.ids) & (a.ids == b.ids) & (a.ids >= 0)
    assert a.depth is not None
    assert b.depth is not None
    assert np.percentile(np.abs(a.depth - b.depth)[inside], 99) < 1e-4


def interior(ids: Any) -> Any:
    """Pixels whose four neighbours show the same body."""
    padded = np.pad(ids, 1, constant_values=-2)
    shifted = (padded[1:-1, :-2], padded[1:-1, 2:], padded[:-2, 1:-1], padded[2:, 1:-1])
    return np.logical_and.reduce([ids == other for other in shifted])


def test_background_is_exactly_the_scenes(table: Scene, frames: dict[str, Frame]) -> None:
    for frame in frames.values():
        empty = interior(frame.ids) & (frame.ids < 0)
        assert np.all(frame.rgb[empty] == np.rint(255 * np.array(table.background)))
        assert frame.depth is not None
        assert np.all(frame.depth[frame.ids < 0] == 0)
