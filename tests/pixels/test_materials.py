"""The materials: images repeat without seams, lie on every shape as they should, and look alike in every engine."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from tests.engines import ENGINES, quick
from tests.examples import slow_except
from tests.pixels.scenes import LYING, body, scene, turned, wedge
from tools import looks
from wmspec.sim.materials import MATERIALS, TEXTURES, Material
from wmspec.sim.scene.model import Camera, Frame, Geom, Pose, Scene, Shot, Surface
from wmspec.sim.scene.model.transform import identity
from wmspec.sim.scene.render.camera import look_at
from wmspec.sim.scene.render.color import load_texture
from wmspec.sim.scene.render.texcoords import texcoords
from wmspec.sim.shapes import Box, Capsule, Cone, Cylinder, Shape, Sphere

IMAGES = sorted(looks.IMAGES)
TEXTURED = sorted(name for name, one in MATERIALS.items() if one.path)
SHAPES: tuple[Shape, ...] = (
    Sphere(0.06),
    Box((0.05,) * 3),
    Cylinder(0.05, 0.11),
    Cone(0.06, 0.12),
    Capsule(0.035, 0.08),
    wedge(),
)


def surface(material: Material, color: Any = None) -> Surface:
    """How an object of the material looks."""
    every = (material.repeats, material.repeats) if material.path else None
    path = str(material.path) if material.path else None
    return Surface(color or material.color, material.roughness, material.metallic, path, every)


def test_the_table_and_the_files_name_one_another() -> None:
    assert sorted(one.image for one in MATERIALS.values() if one.image) == IMAGES
    assert sorted(path.name for path in TEXTURES.iterdir()) == IMAGES


@pytest.mark.parametrize("name", slow_except({*IMAGES} - {"leather.png", "stone.png"}, IMAGES))
def test_files_are_as_the_tool_writes_them(name: str) -> None:
    assert looks.current(name)


@pytest.mark.parametrize("name", IMAGES)
def test_images_repeat_without_seams(name: str) -> None:
    """Across the border texels differ no more than they do anywhere inside."""
    grey = load_texture(str(TEXTURES / name))[..., 0].astype(float)
    for axis in (0, 1):
        inside = np.abs(np.diff(grey, axis=axis)).mean(axis=1 - axis)
        across = np.abs(np.take(grey, 0, axis) - np.take(grey, -1, axis)).mean()
        assert across <= 1.2 * inside.max() + 1


@pytest.mark.parametrize("name", IMAGES)
def test_images_keep_the_tint_in_sight(name: str) -> None:
    """Grey, with light texels in which the colour is as it was given."""
    image = load_texture(str(TEXTURES / name))
    assert np.all(image == image[..., :1])
    assert np.percentile(image, 95) >= 190


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_image_has_the_requested_size(shape: Shape) -> None:
    """Area of the image per area of the shape is repeats², but for what closing around an axis and poles take."""
    geom = Geom("x", shape, identity(), Surface(texture="x.png", repeats=(10.0, 20.0)))
    facets = texcoords(geom)
    a, b, c = (facets.points[facets.faces[:, i]] for i in range(3))
    s, t, u = (facets.st[facets.faces[:, i]] for i in range(3))
    covered = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    first, second = (t - s).T, (u - s).T
    shown = np.abs(first[0] * second[1] - first[1] * second[0]).sum() / 2
    assert facets.st.min() >= 0
    if type(shape) in (Box, Cylinder):
        assert shown / covered == pytest.approx(200, rel=0.15)
    else:
        assert shown > 0


@pytest.mark.parametrize("shape", [Box((0.3, 0.2, 0.1)), Cylinder(0.1, 0.3), Sphere(0.2)], ids=str)
def test_images_are_not_mirrored(shape: Shape) -> None:
    facets = texcoords(Geom("x", shape, identity(), Surface(texture="x.png", repeats=(3.0, 3.0))))
    s, t, u = (facets.st[facets.faces[:, i]] for i in range(3))
    first, second = (t - s).T, (u - s).T
    assert np.all(first[0] * second[1] - first[1] * second[0] > -1e-12)


def lined_up(names: list[str], color: Any) -> Scene:
    """Every shape in a row for each material."""
    shapes = [
        body(
            f"{name}{j}",
            "dynamic",
            (0.16 * (j - 2.5), 0.17 * (i - 1), 0.07),
            shape,
            surface(MATERIALS[name], color),
            turn=LYING if isinstance(shape, Capsule) else turned(0.3),
        )
        for i, name in enumerate(names)
        for j, shape in enumerate(SHAPES)
    ]
    floor = body("floor", "static", (0, 0, -0.05), Box((3.0, 3.0, 0.05)), surface(MATERIALS["wood"]))
    eye = Camera("eye", look_at((0, -1.0, 0.9), (0, 0, 0.03)), math.radians(33), 0.05, 20.0)
    return scene(floor, *shapes, cameras=(eye,))


@pytest.fixture(
    scope="module", params=[(TEXTURED[i : i + 3], tint) for i, tint in ((0, None), (3, (0.12, 0.27, 0.8)), (6, None))]
)
def frames(request: pytest.FixtureRequest, renderer: Any) -> dict[str, Frame]:
    """Three materials on every shape, in every engine."""
    what = lined_up(*request.param)
    poses: list[Pose] = [one.pose for one in what.bodies]
    return {engine: renderer(engine, what, 256, 256).draw(Shot("eye", poses)) for engine in ENGINES}


@pytest.mark.parametrize("pair", list(combinations(ENGINES, 2)), ids="-".join)
def test_engines_tint_alike(pair: tuple[str, str], frames: dict[str, Frame]) -> None:
    a, b = (frames[engine] for engine in pair)
    for one in (one for one in np.unique(a.ids) if (a.ids == one).sum() > 150):  # else a few strokes decide
        apart = a.rgb[a.ids == one].mean(axis=0) - b.rgb[b.ids == one].mean(axis=0)
        assert np.abs(apart).max() < 4, one
    everything = np.abs(a.rgb.astype(float).mean(axis=(0, 1)) - b.rgb.mean(axis=(0, 1)))
    assert everything.max() < 1.6


@pytest.mark.parametrize("engine", quick("mujoco", "sapien"))
def test_materials_are_distinguishable(engine: str, renderer: Any) -> None:
    """Of one colour, their pictures still differ, on average by more than engines may."""
    names, shots = sorted(MATERIALS), {}
    for name in names:
        what = lined_up([name], (0.7, 0.7, 0.7))
        frame = renderer(engine, what, 256, 256).draw(Shot("eye", [one.pose for one in what.bodies]))
        shots[name] = np.where(frame.ids[..., None] > 0, frame.rgb, 0).astype(float)[..., 0]
    for one, other in combinations(names, 2):
        assert np.abs(shots[one] - shots[other])[shots[one] > 0].mean() > 4, (one, other)
