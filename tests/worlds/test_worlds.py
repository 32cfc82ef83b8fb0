"""The things and rooms of the libraries: they weigh what they would, rest, fill their picture, and look alike."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageFilter

import wmspec
from tests.engines import ENGINES, installed
from tools import worlds
from wmspec.runtime.engines.registry import default
from wmspec.sim.scene.model import Frame, Scene
from wmspec.sim.usd import read

THINGS = worlds.things()
#: Least and most that things of a library weigh (kg), but those that are lighter or heavier by nature.
WEIGHS = {
    "kitchenware": (0.1, 2.5),
    "food": (0.03, 2.5),
    "toys": (0.03, 2),
    "household": (0.05, 6),
    "furniture": (3, 80),
}
APART = {
    "spoon": (0.02, 0.08),
    "fork": (0.02, 0.08),
    "pencil": (0.002, 0.01),
    "television": (5, 20),
    "window": (20, 60),
    "door": (20, 60),
}
#: What stands up in MuJoCo for a second within this (m); a hammer lies down on its head first.
STILL = 0.01

WEIGHED = """
use floor
use {library}
task weighed : custom {{
  factor only in [1, 2]
  object weight {{ shape: sphere  size: 1 cm  mass: only * 1 kg  on: floor at (11.5 m, 11.5 m) }}
{things}
  observe front at [0 s]
}}
"""
STANDS = """
use floor
use {library} only [{name}]
task stands : custom {{
  factor only in [1, 2]
  object it : {name} {{ on: floor at (0, 0) }}
  object weight {{ shape: sphere  size: 1 cm  mass: only * 1 kg  on: floor at (9 m, 0) }}
  observe front at [0 s, 0.5 s]
}}
"""
PLAYED = """
use {name}(style: style, clutter: clutter) as here
task played : custom {{
  factor style in ["warm", "cold", "dark"]
  factor clutter in [0, 3]
  object ball {{ shape: sphere  size: 6 cm  on: here.{surface} at (0, 0) }}
  observe here.front at [0 s]
}}
"""
DRAWN = """
use {library} as here
task drawn : custom {{
  factor only in [1, 2]
  factor turn in 0 .. 11 by 1
  design groups of 60 {{ cross: only  turn: [turn] }}
  object weight {{ shape: sphere  size: 1 mm  mass: only * 1 g  on: here.ground at (0, 0) }}
  observe here.front at [0 s]
  observe here.side at [0 s]
  question same "Which?" {{ options [1, 2]  answer only }}
}}
"""
BARE = re.compile(r"(^|_)(floor|ground|table|leg_.|walls|house|lawn|mat|mat_.|weight)$")


def test_there_are_many() -> None:
    assert len(THINGS) >= 40
    assert sum(len(worlds.templates(library)) for library in worlds.LIBRARIES) == len(THINGS)


@pytest.mark.parametrize("library", worlds.LIBRARIES)
def test_objects_have_their_mass(library: str) -> None:
    names = [name for name in THINGS if THINGS[name] == library]
    things = [
        f"  object a_{name} : {name} {{ on: floor at ({4 * (i % 6) - 10} m, {4 * (i // 6) - 10} m) }}"
        for i, name in enumerate(names)
    ]
    scene = worlds.scene(WEIGHED.format(library=library, things="\n".join(things)))
    inertias = {body.name: body.inertia for body in scene.bodies}
    for name in names:
        low, high = APART.get(name, WEIGHS[library])
        inertia = inertias[f"a_{name}"]
        assert inertia is not None
        assert low < inertia.mass < high, name


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("name", THINGS)
def test_object_stands(name: str) -> None:
    installed("mujoco")
    run = wmspec.load(text=STANDS.format(library=THINGS[name], name=name))[0].run("mujoco")
    path = run["it"].position
    assert np.linalg.norm(path[-1] - path[0]) < STILL


@pytest.mark.engine
@pytest.mark.parametrize("name", ["mug", "tangerine", "striped_ball", "clock", "sofa"])
def test_object_fills_its_picture(name: str) -> None:
    scene = worlds.thing(name, THINGS[name])
    (frame,) = worlds.frames(scene, default(), 64, ["near"])
    assert (frame.ids == [body.name for body in scene.bodies].index("it")).mean() > 0.1


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("name", THINGS)
def test_object_renders_alike_in_all_engines(name: str) -> None:
    alike(worlds.thing(name, THINGS[name]), "near")


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("camera", worlds.CAMERAS)
@pytest.mark.parametrize("name", worlds.ROOMS)
def test_room_renders_alike_in_all_engines(name: str, camera: str) -> None:
    alike(worlds.room(name), camera)


def alike(scene: Scene, camera: str) -> None:
    """What docs/worlds.md says of all pairs of engines."""
    for engine in ENGINES:
        installed(engine)
    drawn = [worlds.frames(scene, engine, 256, [camera])[0] for engine in ENGINES]
    for pair in combinations(drawn, 2):
        overlap, color, depth = worlds.apart(*pair)
        assert overlap >= 0.99
        assert color <= 4
        assert depth <= 0.1


@pytest.mark.pixels
def test_the_cover_of_a_bed_has_no_speckles_in_mujoco() -> None:
    """Its top shaded itself here and there: 51 pixels were darker by 30 of 255 than what is around them."""
    installed("mujoco")
    whole = worlds.room("nursery")
    bare = [body for body in whole.bodies if not body.name.endswith(("rail", "doll"))]  # their shadows are thin
    nursery = replace(whole, bodies=tuple(bare))
    (frame,) = worlds.frames(nursery, "mujoco", 384, ["front"])
    cot = frame.ids == next(i for i, body in enumerate(nursery.bodies) if body.name.endswith("cot"))
    within = np.asarray(Image.fromarray(cot.astype(np.uint8)).filter(ImageFilter.MinFilter(9))) > 0
    gray = Image.fromarray(frame.rgb).convert("L")
    darker = np.asarray(gray.filter(ImageFilter.MedianFilter(5)), int) - np.asarray(gray, int)
    assert within.sum() > 20_000
    assert (darker[within] > 30).sum() < 30


@pytest.mark.parametrize("name", worlds.ROOMS)
def test_a_room_has_styles_and_clutter_and_a_place_to_stand(name: str) -> None:
    task = wmspec.load(text=PLAYED.format(name=name, surface=worlds.surface(name)))
    assert len(task) == 6
    some = [one for one in task if one.factors["style"] == "warm" or one.factors["clutter"] == 0]
    looks = [one.stage().Flatten().ExportToString() for one in some]
    assert len(set(looks)) == len(looks) == 4


@pytest.mark.engine
@pytest.mark.parametrize("name", worlds.ROOMS)
def test_no_camera_of_a_room_sees_an_empty_sky_or_an_empty_wall(name: str) -> None:
    room = worlds.room(name, "(clutter: 0)")
    for camera, frame in zip(worlds.CAMERAS, worlds.frames(room, default(), 64, worlds.CAMERAS), strict=True):
        assert (frame.ids < 0).mean() < 0.02
        assert camera == "top" or furnished(room, frame) > 0.1


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("library", ["grounds", "tables"])
def test_no_camera_of_the_perception_catalogue_sees_an_empty_wall(library: str) -> None:
    """Wherever a group is set, and with nothing lying about."""
    task = wmspec.load(text=DRAWN.format(library=library))
    bare: dict[Any, Any] = {}
    for i in range(0, len(task), 2):
        nuisances = {name.removeprefix("here_"): value for name, value in task[i].nuisances.items()}
        if nuisances["clutter"] == 0:
            bare.setdefault(nuisances["room"], read(task[i].stage()))
    assert len(bare) == 4
    for scene in bare.values():
        for frame in worlds.frames(scene, default(), 64, ["front", "side"]):
            assert furnished(scene, frame) > 0.05


def furnished(scene: Scene, frame: Frame) -> float:
    """The share of a picture that furniture covers: what is more than floor, walls and what things stand on."""
    names = [body.name.split("_", 1)[-1] for body in scene.bodies]
    return float(sum((frame.ids == i).mean() for i, name in enumerate(names) if not BARE.search(name)))
